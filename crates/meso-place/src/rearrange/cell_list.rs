//! Cell list: bodies by the cell of their centre, in levels of size.

use super::bodies::{Bodies, CHUNK, MOST_MARGIN, widened};
use super::contact::{LANES, V};
use meso_collision::math::{Aabb, Vec3};
use meso_collision::simd::{Wide, widest};
use meso_concrete::parallel;
use std::ops::{Range, RangeInclusive};

/// Bodies in levels of size, coarsest first, at their positions when this was built.
pub(super) struct CellList {
    levels: Vec<Level>,
    /// Gap that makes a pair no contact, mm.
    want: f32,
    /// The bodies' paths when this was made, mm.
    paths: Vec<f32>,
}

/// The cells serve until a body has gone farther than this share of its radius.
const MOST_DRIFT: f32 = 0.125;

#[derive(Default)]
struct Level {
    origin: [f64; 3],
    cell: f64,
    counts: [i64; 3],
    /// Radius of the largest body, mm.
    largest: f32,
    /// Farthest reach of any body, mm.
    farthest: f32,
    starts: Vec<u32>,
    /// Bodies by cell. Their positions and reaches are copied beside them, so that a search reads memory in order.
    members: Vec<u32>,
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    /// Including the body's allowed displacement.
    radius: Vec<f32>,
}

/// A level holds bodies down to this share of its largest radius.
const LEVEL_SPAN: f32 = 0.6;

impl CellList {
    pub(super) fn new(bodies: &Bodies, want: f32) -> Self {
        let farthest = largest_of(bodies.len(), |body| far(bodies, body as u32));
        let mut levels = Vec::new();
        let mut below = f32::INFINITY;
        loop {
            let radius = |body: usize| bodies.fixed[body].outer_radius;
            let largest = largest_of(bodies.len(), |body| if radius(body) < below { radius(body) } else { 0.0 });
            if largest == 0.0 {
                break;
            }
            let smallest = LEVEL_SPAN * largest;
            levels.push(Level::new(bodies, smallest..=largest, farthest + want));
            below = smallest;
        }
        Self { levels, want, paths: bodies.paths().to_vec() }
    }

    /// True when a body has moved too far from its noted position.
    pub(super) fn stale(&self, bodies: &Bodies) -> bool {
        let drift = |body: u32| bodies.path(body) - self.paths[body as usize];
        let stale = |body: usize| drift(body as u32) > MOST_DRIFT * bodies.fixed[body].ball_radius;
        parallel::find(bodies.len(), |body| stale(body).then_some(())).is_some()
    }

    /// The bodies that may come within `want` of `a` while neither exceeds its limit, and of which `a` is the first:
    /// those after it in its own level, and all of coarser levels. In order, each once.
    #[inline(always)]
    pub(super) fn seconds(&self, bodies: &Bodies, a: u32, found: &mut Vec<u32>) {
        found.clear();
        let level = self.level_of(bodies, a);
        for (number, coarser) in self.levels[..=level].iter().enumerate() {
            let start = found.len();
            coarser.near(bodies, a, self.want, found);
            if number == level {
                let mut end = start;
                for k in start..found.len() {
                    let body = found[k];
                    found[end] = body;
                    end += usize::from(body > a);
                }
                found.truncate(end);
            }
        }
        found.sort_unstable();
        // A partner may be found in several images.
        found.dedup();
    }

    /// All such pairs of `body`, first and second.
    pub(super) fn pairs(&self, bodies: &Bodies, body: u32) -> Vec<(u32, u32)> {
        widest(PairsOf { cells: self, bodies, body })
    }

    #[inline(always)]
    fn level_of(&self, bodies: &Bodies, body: u32) -> usize {
        let radius = bodies.fixed[body as usize].outer_radius;
        self.levels.iter().position(|level| radius >= LEVEL_SPAN * level.largest).unwrap_or(0)
    }
}

/// The pairs of a body, on wide registers.
struct PairsOf<'a> {
    cells: &'a CellList,
    bodies: &'a Bodies<'a>,
    body: u32,
}

impl Wide for PairsOf<'_> {
    type Output = Vec<(u32, u32)>;

    #[inline(always)]
    fn run(self) -> Vec<(u32, u32)> {
        let Self { cells, bodies, body } = self;
        let (own, mut pairs, mut found) = (cells.level_of(bodies, body), Vec::new(), Vec::new());
        for (number, level) in cells.levels.iter().enumerate() {
            found.clear();
            level.near(bodies, body, cells.want, &mut found);
            for &other in found.iter().filter(|other| **other != body) {
                let first = number < own || (number == own && body < other);
                pairs.push(if first { (body, other) } else { (other, body) });
            }
        }
        pairs
    }
}

impl Level {
    /// The bodies of these radii, with their images that a body in the box, which reaches so far, may come near.
    fn new(bodies: &Bodies, radii: RangeInclusive<f32>, reach: f32) -> Self {
        let largest = *radii.end();
        let members = bodies.filter(|body| radii.contains(&bodies.fixed[body as usize].outer_radius));
        let farthest = largest_of(members.len(), |k| far(bodies, members[k]));
        let margin = f64::from(reach + farthest) * 1.000_1;
        let placed: Vec<(u32, V)> = bodies.with_images(&members, margin);
        let mut aabb = Aabb::empty();
        placed.iter().for_each(|(_, centre)| aabb.include(&widened(*centre)));
        let most = MOST_CELLS * placed.len() as f64 + LEAST_CELLS;
        let cell = f64::from(CELL * largest).max(libm::cbrt(aabb.size().product() / most));
        let counts = [0, 1, 2].map(|i| (aabb.size()[i] / cell) as i64 + 1);
        let mut level = Self { origin: aabb.min.into(), cell, counts, largest, farthest, ..Self::default() };
        level.fill(bodies, &placed);
        level
    }

    /// Sorts the bodies by cell.
    fn fill(&mut self, bodies: &Bodies, placed: &[(u32, V)]) {
        let order = self.sort(placed);
        let placed = |k: usize| &placed[order[k] as usize];
        self.members = parallel::map_short(order.len(), |k| placed(k).0);
        let coordinates = |axis: usize| padded(order.len(), |k| placed(k).1[axis]);
        (self.x, self.y, self.z) = (coordinates(0), coordinates(1), coordinates(2));
        self.radius = padded(order.len(), |k| far(bodies, self.members[k]));
    }

    /// The numbers of the `placed` by cell; also sets where those of each cell start.
    fn sort(&mut self, placed: &[(u32, V)]) -> Vec<u32> {
        let key = |(_, centre): &(u32, V)| self.flat(self.cell_of(&widened(*centre)));
        let keys = parallel::map_short(placed.len(), |k| key(&placed[k]));
        self.starts = starts(self.counts.iter().product::<i64>() as usize, keys.iter().copied());
        let mut next = self.starts.clone();
        let mut order = vec![0; placed.len()];
        for (item, &key) in (0..).zip(&keys) {
            order[next[key as usize] as usize] = item;
            next[key as usize] += 1;
        }
        order
    }

    /// Appends the bodies that may come within `want` of `body`, and it itself.
    #[inline(always)]
    fn near(&self, bodies: &Bodies, body: u32, want: f32, found: &mut Vec<u32>) {
        let limit = want + bodies.margin(body);
        let reach = bodies.fixed[body as usize].outer_radius + limit;
        let start = found.len();
        // The members' centres are rounded; a ten-thousandth of the distance is far more than that.
        self.visit(&bodies.state[body as usize].centre, reach * 1.000_1, found);
        let mut end = start;
        for k in start..found.len() {
            let other = found[k];
            found[end] = other;
            end += usize::from(bodies.box_gap(body, other) <= limit + bodies.margin(other));
        }
        found.truncate(end);
    }

    /// Appends the bodies whose bounding spheres come within `reach` of `centre`.
    #[inline(always)]
    fn visit(&self, centre: &Vec3, reach: f32, found: &mut Vec<u32>) {
        let range = Vec3::repeat(f64::from(reach + self.farthest));
        let (low, high) = (self.cell_of(&(centre - range)), self.cell_of(&(centre + range)));
        let at = [centre.x as f32, centre.y as f32, centre.z as f32];
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let (first, last) = (self.flat([low[0], y, z]) as usize, self.flat([high[0], y, z]) as usize);
                self.visit_row(self.starts[first] as usize..self.starts[last + 1] as usize, at, reach, found);
            }
        }
    }

    /// Searches among neighbouring members, several at a time.
    #[inline(always)]
    fn visit_row(&self, row: Range<usize>, at: V, reach: f32, found: &mut Vec<u32>) {
        for start in row.clone().step_by(LANES) {
            let lanes = start..start + LANES;
            let (x, y, z) = (&self.x[lanes.clone()], &self.y[lanes.clone()], &self.z[lanes.clone()]);
            let radius = &self.radius[lanes];
            let mut meets = 0_u32;
            for lane in 0..LANES {
                let (dx, dy, dz) = (x[lane] - at[0], y[lane] - at[1], z[lane] - at[2]);
                let touch = reach + radius[lane];
                meets |= u32::from(dx * dx + dy * dy + dz * dz <= touch * touch) << lane;
            }
            meets &= u32::MAX >> (u32::BITS - (row.end - start).min(LANES) as u32);
            while meets != 0 {
                found.push(self.members[start + meets.trailing_zeros() as usize]);
                meets &= meets - 1;
            }
        }
    }

    #[inline(always)]
    fn cell_of(&self, point: &Vec3) -> [i64; 3] {
        let along = |i: usize| (((point[i] - self.origin[i]) / self.cell) as i64).clamp(0, self.counts[i] - 1);
        [along(0), along(1), along(2)]
    }

    #[inline(always)]
    fn flat(&self, cell: [i64; 3]) -> u32 {
        ((cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]) as u32
    }
}

/// `of(k)` for every number below `count`, and some zeros, so that several can be read at the end.
fn padded(count: usize, of: impl Fn(usize) -> f32 + Sync) -> Vec<f32> {
    parallel::map_short(count + LANES, |k| if k < count { of(k) } else { 0.0 })
}

/// The largest `of(k)` of every number below `count`; 0 where none is larger.
fn largest_of(count: usize, of: impl Fn(usize) -> f32 + Sync) -> f32 {
    let largest = |chunk: usize| (chunk * CHUNK..count.min((chunk + 1) * CHUNK)).map(&of).fold(0.0, f32::max);
    parallel::map(count.div_ceil(CHUNK), largest).into_iter().fold(0.0, f32::max)
}

/// Farthest reach of a body from its noted position, mm.
fn far(bodies: &Bodies, body: u32) -> f32 {
    let fixed = &bodies.fixed[body as usize];
    fixed.outer_radius + (MOST_DRIFT + MOST_MARGIN) * fixed.ball_radius
}

/// No more cells than this for each body, and some: bodies may be few and small, as voids are, in a large specimen.
/// Levels of a usual grading have one to six for each.
const MOST_CELLS: f64 = 32.0;
const LEAST_CELLS: f64 = 32_768.0;
/// Side of a cell over the largest radius in it.
const CELL: f32 = 1.0;

/// Where the items of every key start when they are sorted by key.
pub(super) fn starts(keys: usize, items: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut starts = vec![0; keys + 1];
    for key in items {
        starts[key as usize + 1] += 1;
    }
    for key in 0..keys {
        starts[key + 1] += starts[key];
    }
    starts
}
