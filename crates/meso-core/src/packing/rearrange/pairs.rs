//! Which bodies may touch: pairs within a skin, by a grid, with what is known of their contact.

use super::bodies::Bodies;
use super::contact::{Contact, LANES, V, direction_or_up};
use crate::math::{Aabb, Vec3};
use crate::wide::widest;
use rayon::prelude::*;
use std::ops::Range;

/// Two bodies within the skin of each other; `a` is of the finer level of size, or the lower number of one level.
#[derive(Clone, Copy)]
pub(super) struct Pair {
    pub(super) a: u32,
    pub(super) b: u32,
    pub(super) contact: Contact,
    /// Gap plus both path lengths when the gap was last computed: while `clear - path_a - path_b` exceeds what counts
    /// as a contact, the pair needs no look.
    pub(super) clear: f64,
}

/// The pairs, and every body's share of them.
pub(super) struct Pairs {
    /// By `a`, then `b`.
    pub(super) all: Vec<Pair>,
    /// `firsts[i]..firsts[i + 1]`: the pairs whose `a` is body i.
    firsts: Vec<u32>,
    /// `second_starts[i]..second_starts[i + 1]` in `seconds`: the pairs whose `b` is body i.
    second_starts: Vec<u32>,
    seconds: Vec<u32>,
    /// Longest path any body may go before the list must be made anew, mm.
    skin: f64,
    paths_at_build: Vec<f64>,
    /// The wider list that this one is picked from.
    near: Near,
}

impl Pairs {
    pub(super) fn none() -> Self {
        Self {
            all: Vec::new(),
            firsts: vec![0],
            second_starts: vec![0],
            seconds: Vec::new(),
            skin: 0.0,
            paths_at_build: Vec::new(),
            near: Near::default(),
        }
    }

    /// Pairs whose `a` is `body`: it is pushed against the normal.
    pub(super) fn as_first(&self, body: u32) -> impl Iterator<Item = &Pair> {
        self.all[self.firsts[body as usize] as usize..self.firsts[body as usize + 1] as usize].iter()
    }

    /// Pairs whose `b` is `body`: it is pushed along the normal.
    pub(super) fn as_second(&self, body: u32) -> impl Iterator<Item = &Pair> {
        let range = self.second_starts[body as usize] as usize..self.second_starts[body as usize + 1] as usize;
        self.seconds[range].iter().map(|&pair| &self.all[pair as usize])
    }

    /// True when a body may have come nearer to one that the list does not name.
    pub(super) fn stale(&self, bodies: &Bodies) -> bool {
        moved_beyond(self.skin / 2.0, bodies, &self.paths_at_build)
    }

    /// The pairs whose boxes are less than `reach + skin` apart, so that no other is within `reach` until a body has
    /// gone `skin / 2`. What is known of a pair that was listed before is kept.
    pub(super) fn rebuild(&mut self, bodies: &Bodies, reach: f64, skin: f64) {
        self.near.cover(bodies, reach, skin);
        let limit = (reach + skin) as f32;
        let within: Vec<Vec<(u32, u32)>> = self
            .near
            .pairs
            .par_chunks(8 * CHUNK)
            .map(|pairs| widest(|| pairs.iter().copied().filter(|&(a, b)| bodies.boxes_within(a, b, limit)).collect()))
            .collect();
        let within = within.concat();
        self.all = within.par_iter().map(|&(a, b)| self.pair(bodies, a, b)).collect();
        drop(within);
        self.index(bodies.len());
        self.skin = skin;
        self.paths_at_build = paths(bodies);
    }

    /// The pair as the old list knew it, or with a first guess of its direction and due for a look.
    fn pair(&self, bodies: &Bodies, a: u32, b: u32) -> Pair {
        let old = if a as usize + 1 < self.firsts.len() {
            &self.all[self.firsts[a as usize] as usize..self.firsts[a as usize + 1] as usize]
        } else {
            &[]
        };
        match old.binary_search_by_key(&b, |pair| pair.b) {
            Ok(i) => old[i],
            Err(_) => {
                let contact = Contact::towards(direction_or_up(bodies.offset(a, b)));
                Pair { a, b, contact, clear: f64::NEG_INFINITY }
            }
        }
    }

    fn index(&mut self, bodies: usize) {
        self.firsts = starts(bodies, self.all.iter().map(|pair| pair.a));
        self.second_starts = starts(bodies, self.all.iter().map(|pair| pair.b));
        let mut next = self.second_starts.clone();
        self.seconds = vec![0; self.all.len()];
        for (i, pair) in self.all.iter().enumerate() {
            let slot = &mut next[pair.b as usize];
            self.seconds[*slot as usize] = i as u32;
            *slot += 1;
        }
    }
}

/// Bodies a thread looks for partners of at once.
const CHUNK: usize = 512;

/// Pairs within a skin several times as wide, so that the grid is searched seldom.
#[derive(Default)]
struct Near {
    /// In order.
    pairs: Vec<(u32, u32)>,
    /// Boxes up to here apart were listed, mm.
    limit: f64,
    paths_at_build: Vec<f64>,
}

/// The wider skin over the narrower one.
const WIDER: f64 = 4.0;

impl Near {
    /// Makes the list anew unless it still names all pairs whose boxes are less than `reach + skin` apart.
    fn cover(&mut self, bodies: &Bodies, reach: f64, skin: f64) {
        if !moved_beyond((self.limit - reach - skin) / 2.0, bodies, &self.paths_at_build) {
            return;
        }
        self.pairs = Vec::new();
        self.limit = reach + WIDER * skin;
        let limit = self.limit as f32;
        let cells = Cells::new(bodies, limit);
        let chunks: Vec<Vec<(u32, u32)>> = (0..bodies.len().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(bodies.len());
                let (mut pairs, mut found) = (Vec::with_capacity(CHUNK * 8), Vec::new());
                for a in range {
                    found.clear();
                    widest(|| cells.partners(bodies, a as u32, limit, &mut found));
                    found.sort_unstable();
                    // A partner may be found in several images.
                    found.dedup();
                    pairs.extend(found.iter().map(|&b| (a as u32, b)));
                }
                pairs
            })
            .collect();
        self.pairs = chunks.concat();
        self.paths_at_build = paths(bodies);
    }
}

/// True when a body has gone farther than `length` mm since its path was as in `before`, or there is no such time.
fn moved_beyond(length: f64, bodies: &Bodies, before: &[f64]) -> bool {
    before.len() != bodies.len() || bodies.state.par_iter().zip(before).any(|(state, path)| state.path - path > length)
}

fn paths(bodies: &Bodies) -> Vec<f64> {
    bodies.state.iter().map(|state| state.path).collect()
}

/// Where the items of every key start when they are sorted by key.
fn starts(keys: usize, items: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut starts = vec![0; keys + 1];
    for key in items {
        starts[key as usize + 1] += 1;
    }
    for key in 0..keys {
        starts[key + 1] += starts[key];
    }
    starts
}

/// Bodies by the cell of their centre, in levels of size, from the coarsest.
struct Cells {
    levels: Vec<Level>,
}

#[derive(Default)]
struct Level {
    origin: [f64; 3],
    cell: f64,
    counts: [i64; 3],
    largest: f32,
    starts: Vec<u32>,
    /// Bodies by cell, and copies of what decides whether they may be near, so that a look reads memory in a row.
    members: Vec<u32>,
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
    radius: Vec<f32>,
}

/// A level holds bodies down to this share of its largest radius.
const LEVEL_SPAN: f32 = 0.6;

impl Cells {
    fn new(bodies: &Bodies, limit: f32) -> Self {
        let mut radii: Vec<f32> = bodies.fixed.iter().map(|fixed| fixed.outer_radius).collect();
        radii.sort_unstable_by(f32::total_cmp);
        let mut levels = Vec::new();
        let mut rest = radii.as_slice();
        while let Some(&largest) = rest.last() {
            let below = rest.partition_point(|&radius| radius < LEVEL_SPAN * largest);
            levels.push(Level::new(bodies, rest[below], largest, limit));
            rest = &rest[..below];
        }
        Self { levels }
    }

    /// Bodies of the level of `a` after it, and of all coarser levels, whose boxes come within `limit` of its own.
    #[inline(always)]
    fn partners(&self, bodies: &Bodies, a: u32, limit: f32, found: &mut Vec<u32>) {
        let (radius, centre) = (bodies.fixed[a as usize].outer_radius, &bodies.state[a as usize].centre);
        for level in &self.levels {
            let own = radius >= LEVEL_SPAN * level.largest;
            // The members' centres are rounded; a ten-thousandth of the distance is far more than that.
            level.visit(centre, (radius + limit) * 1.000_1, |body| {
                if (body > a || !own) && bodies.boxes_within(a, body, limit) {
                    found.push(body);
                }
            });
            if own {
                return;
            }
        }
    }
}

impl Level {
    /// The bodies of these radii, with their images that a body of no larger radius may come within `limit` of.
    fn new(bodies: &Bodies, smallest: f32, largest: f32, limit: f32) -> Self {
        let radii = smallest..=largest;
        let inside = |body: &u32| radii.contains(&bodies.fixed[*body as usize].outer_radius);
        let margin = f64::from(2.0 * largest + limit) * 1.000_1;
        let members = (0..bodies.len() as u32).filter(inside);
        let placed: Vec<(u32, Vec3)> = bodies.with_images(members, margin);
        let aabb = Aabb::around(placed.iter().map(|(_, centre)| centre));
        let cell = 2.0 * f64::from(largest);
        let counts = [0, 1, 2].map(|i| (aabb.size()[i] / cell) as i64 + 1);
        let mut level = Self { origin: aabb.min.into(), cell, counts, largest, ..Self::default() };
        let keys: Vec<u32> = placed.iter().map(|(_, centre)| level.flat(level.cell_of(centre))).collect();
        level.starts = starts(counts.iter().product::<i64>() as usize, keys.iter().copied());
        let mut next = level.starts.clone();
        let mut order = vec![0; placed.len()];
        for (item, &key) in (0..).zip(&keys) {
            order[next[key as usize] as usize] = item;
            next[key as usize] += 1;
        }
        let coordinates =
            |axis: usize| order.iter().map(|&item: &u32| placed[item as usize].1[axis] as f32).collect::<Vec<f32>>();
        (level.x, level.y, level.z) = (coordinates(0), coordinates(1), coordinates(2));
        level.members = order.iter().map(|&item| placed[item as usize].0).collect();
        level.radius = level.members.iter().map(|&body| bodies.fixed[body as usize].outer_radius).collect();
        level
    }

    /// Calls `each` with the bodies whose bounding spheres come within `reach` of `centre`.
    #[inline(always)]
    fn visit(&self, centre: &Vec3, reach: f32, mut each: impl FnMut(u32)) {
        let range = Vec3::repeat(f64::from(reach + self.largest));
        let (low, high) = (self.cell_of(&(centre - range)), self.cell_of(&(centre + range)));
        let at = [centre.x as f32, centre.y as f32, centre.z as f32];
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let (first, last) = (self.flat([low[0], y, z]) as usize, self.flat([high[0], y, z]) as usize);
                self.visit_row(self.starts[first] as usize..self.starts[last + 1] as usize, at, reach, &mut each);
            }
        }
    }

    /// The same among neighbouring members, several at a time.
    #[inline(always)]
    fn visit_row(&self, row: Range<usize>, at: V, reach: f32, each: &mut impl FnMut(u32)) {
        for start in row.clone().step_by(LANES) {
            let end = (start + LANES).min(row.end);
            let mut clear = [1.0; LANES];
            let [x, y, z, radius] = [&self.x, &self.y, &self.z, &self.radius].map(|values| &values[start..end]);
            for lane in 0..end - start {
                let (dx, dy, dz) = (x[lane] - at[0], y[lane] - at[1], z[lane] - at[2]);
                let touch = reach + radius[lane];
                clear[lane] = dx * dx + dy * dy + dz * dz - touch * touch;
            }
            for (lane, clear) in clear.iter().enumerate().take(end - start) {
                if *clear <= 0.0 {
                    each(self.members[start + lane]);
                }
            }
        }
    }

    fn cell_of(&self, point: &Vec3) -> [i64; 3] {
        [0, 1, 2].map(|i| (((point[i] - self.origin[i]) / self.cell) as i64).clamp(0, self.counts[i] - 1))
    }

    fn flat(&self, cell: [i64; 3]) -> u32 {
        ((cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]) as u32
    }
}
