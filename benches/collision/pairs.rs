//! Pair sets: what a collision test is asked in packing.

use super::bodies::{Dice, Grain};
use meso_collision::math::Vec3;
use std::collections::VecDeque;

/// Two grains, by index, and the displacement of the second.
#[derive(Clone, Copy, Debug)]
pub struct Query {
    pub a: u32,
    pub b: u32,
    pub x: Vec3,
}

/// Grains and questions about them.
pub struct PairSet {
    pub name: &'static str,
    pub grains: Vec<Grain>,
    pub queries: Vec<Query>,
}

/// The grains of all random pair sets: three fixed bodies first, then the many.
pub fn grains(n: usize) -> Vec<Grain> {
    let mut dice = Dice::new(3883);
    (0..n + 3).map(|_| Grain::aggregate(&mut dice)).collect()
}

/// The paper's Fig. 4: one of three bodies against each of many, all intersecting.
pub fn intersecting(grains: &[Grain]) -> Vec<Query> {
    from_touching(grains, 1, |dice, touch, _| touch * 0.98 * libm::cbrt(dice.unit()))
}

/// The same with one body only, the `a`th.
pub fn intersecting_with(grains: &[Grain], a: usize) -> Vec<Query> {
    let mut queries = intersecting(grains);
    for q in &mut queries {
        let touch_of_own = q.x.norm();
        let v = q.x / touch_of_own;
        let reach = grains[a].radius + grains[q.b as usize].radius;
        let share = touch_of_own / (grains[q.a as usize].radius + grains[q.b as usize].radius);
        let touch = touching(&grains[a], &grains[q.b as usize], &v, reach);
        *q = Query { a: a as u32, x: v * (share * reach).min(0.98 * touch), ..*q };
    }
    queries
}

/// Apart, with overlapping bounding spheres: uniform in volume between touching and the spheres' reach.
pub fn separated(grains: &[Grain]) -> Vec<Query> {
    let cube = |v: f64| v * v * v;
    from_touching(grains, 2, |dice, touch, reach| libm::cbrt(dice.between(cube(touch * 1.0001), cube(reach))))
}

/// Gaps and depths of 1e-3 to 1e-9 of the size.
pub fn near_touch(grains: &[Grain]) -> Vec<Query> {
    near_touch_at(grains, -9.0, -3.0)
}

/// Gaps and depths of 10^from to 10^to of the size.
pub fn near_touch_at(grains: &[Grain], from: f64, to: f64) -> Vec<Query> {
    from_touching(grains, 4, |dice, touch, reach| {
        let gap = reach * libm::pow(10.0, dice.between(from, to));
        if dice.below(2) == 0 { touch + gap } else { touch - gap }
    })
}

/// For each grain, one of the first three, a direction and a distance along it, chosen by where the two touch and by
/// their radii.
fn from_touching(grains: &[Grain], seed: u64, distance: impl Fn(&mut Dice, f64, f64) -> f64) -> Vec<Query> {
    let mut dice = Dice::new(seed);
    let query = |b: usize| {
        let (a, v) = (b % 3, dice.direction());
        let reach = grains[a].radius + grains[b].radius;
        let touch = touching(&grains[a], &grains[b], &v, reach);
        Query { a: a as u32, b: b as u32, x: v * distance(&mut dice, touch, reach) }
    };
    (3..grains.len()).map(query).collect()
}

/// How far B can move along `v` until it leaves A, to the last bits.
fn touching(a: &Grain, b: &Grain, v: &Vec3, reach: f64) -> f64 {
    let (mut inside, mut outside) = (0.0, reach * 1.0001);
    while outside - inside > 1e-14 * reach {
        let middle = 0.5 * (inside + outside);
        if a.body.overlaps(&b.body, &(v * middle)) { inside = middle } else { outside = middle }
    }
    0.5 * (inside + outside)
}

/// The queries of a placement attempt, in the order in which the grid names the neighbours.
pub struct Stream {
    pub grains: Vec<Grain>,
    /// All queries, attempt after attempt.
    pub queries: Vec<Query>,
    /// One past the last query of every attempt.
    pub ends: Vec<u32>,
}

/// Take and place to a volume fraction in a cube (mm): what the collision test is asked on the way.
///
/// Recorded are the neighbours with overlapping bounding spheres of the last `record` attempts, all of them, though
/// packing would stop at the first overlap; in the order in which a grid of cells names them.
pub fn placement_stream(side: f64, fraction: f64, record: usize) -> Stream {
    let mut dice = Dice::new(40);
    let mut grains = Vec::new();
    let mut volume = 0.0;
    while volume < fraction * side * side * side {
        let grain = Grain::aggregate(&mut dice);
        volume += grain.volume;
        grains.push(grain);
    }
    grains.sort_by(|p, q| q.volume.total_cmp(&p.volume));
    let mut cells = Cells::new(side, 2.0 * grains.iter().map(|g| g.radius).fold(0.0, f64::max));
    let mut attempts: VecDeque<Vec<Query>> = VecDeque::new();
    for g in 0..grains.len() {
        for _ in 0..20_000 {
            let margin = grains[g].radius;
            let at = Vec3::from_fn(|_, _| dice.between(margin, side - margin));
            let near = cells.around(&at).filter(|(p, c)| (c - at).norm() < grains[*p].radius + margin);
            let asked: Vec<Query> = near.map(|(p, c)| Query { a: g as u32, b: *p as u32, x: c - at }).collect();
            let free = asked.iter().all(|q| !grains[g].body.overlaps(&grains[q.b as usize].body, &q.x));
            attempts.push_back(asked);
            if attempts.len() > record {
                attempts.pop_front();
            }
            if free {
                cells.add(g, at);
                break;
            }
        }
    }
    let ends = attempts.iter().scan(0, |end, asked| {
        *end += asked.len() as u32;
        Some(*end)
    });
    let ends = ends.collect();
    Stream { grains, queries: attempts.into_iter().flatten().collect(), ends }
}

/// Placed grains by cell.
struct Cells {
    size: f64,
    per_side: isize,
    cells: Vec<Vec<(usize, Vec3)>>,
}

impl Cells {
    fn new(side: f64, size: f64) -> Self {
        let per_side = (side / size).ceil() as isize;
        Self { size, per_side, cells: vec![Vec::new(); (per_side * per_side * per_side) as usize] }
    }

    fn cell(&self, at: &Vec3) -> [isize; 3] {
        [at.x, at.y, at.z].map(|v| (v / self.size) as isize)
    }

    fn add(&mut self, grain: usize, at: Vec3) {
        let [i, j, k] = self.cell(&at);
        let n = self.per_side;
        self.cells[((i * n + j) * n + k) as usize].push((grain, at));
    }

    fn around(&self, at: &Vec3) -> impl Iterator<Item = &(usize, Vec3)> {
        let ([i, j, k], n) = (self.cell(at), self.per_side);
        let near = (0..27).map(move |c| [i + c / 9 - 1, j + c / 3 % 3 - 1, k + c % 3 - 1]);
        let inside = near.filter(move |c| c.iter().all(|v| (0..n).contains(v)));
        inside.flat_map(move |[i, j, k]| &self.cells[((i * n + j) * n + k) as usize])
    }
}
