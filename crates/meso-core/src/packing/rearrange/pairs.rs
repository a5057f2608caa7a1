//! Which bodies may touch: pairs within a skin, by a grid, with what is known of their contact.

use super::bodies::Bodies;
use super::contact::{Contact, V, dot, gap_along, scale};
use rayon::prelude::*;

/// Two bodies within the skin of each other, `a < b`.
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
        self.paths_at_build.len() != bodies.len()
            || bodies
                .state
                .par_iter()
                .zip(&self.paths_at_build)
                .any(|(state, path)| state.path - path > self.skin / 2.0)
    }

    /// The pairs less than `reach + skin` apart, which the list stays complete for until a body has gone `skin / 2`.
    /// What is known of a pair that was listed before is kept.
    pub(super) fn rebuild(&mut self, bodies: &Bodies, reach: f64, skin: f64) {
        let cells = Cells::new(bodies, reach + skin);
        let limit = (reach + skin) as f32;
        let chunks: Vec<Vec<Pair>> = (0..bodies.len().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(bodies.len());
                let (mut pairs, mut found) = (Vec::with_capacity(CHUNK * 8), Vec::new());
                for a in range {
                    found.clear();
                    cells.partners(bodies, a as u32, limit, &mut found);
                    found.sort_unstable();
                    pairs.extend(found.iter().filter_map(|&b| self.pair(bodies, a as u32, b, limit)));
                }
                pairs
            })
            .collect();
        self.all = chunks.concat();
        self.index(bodies.len());
        self.skin = skin;
        self.paths_at_build = bodies.state.iter().map(|state| state.path).collect();
    }

    /// The pair with its gap along the known or a first guess of the direction; `None` when that is beyond `limit`.
    fn pair(&self, bodies: &Bodies, a: u32, b: u32, limit: f32) -> Option<Pair> {
        let x = bodies.offset(a, b);
        let known = (a as usize + 1 < self.firsts.len()).then(|| {
            let (start, end) = (self.firsts[a as usize] as usize, self.firsts[a as usize + 1] as usize);
            self.all[start..end].binary_search_by_key(&b, |pair| pair.b).ok().map(|i| self.all[start + i].contact)
        });
        let mut contact = known.flatten().unwrap_or_else(|| Contact::towards(unit(x)));
        let (p, q) = (bodies.points(a), bodies.points(b));
        contact.gap = gap_along(&p, &q, x, contact.normal);
        if contact.gap > limit {
            return None;
        }
        let clear = f64::from(contact.gap) + bodies.state[a as usize].path + bodies.state[b as usize].path;
        Some(Pair { a, b, contact, clear })
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

fn unit(x: V) -> V {
    let length = dot(x, x).sqrt();
    if length > 1e-6 { scale(x, 1.0 / length) } else { [0.0, 0.0, 1.0] }
}

/// Bodies by the cell of their centre, in levels of size: a level's cells are as wide as its largest bodies reach.
struct Cells {
    levels: Vec<Level>,
}

struct Level {
    origin: [f64; 3],
    cell: f64,
    counts: [i64; 3],
    largest: f64,
    starts: Vec<u32>,
    members: Vec<u32>,
}

/// A level holds bodies down to this share of its largest radius.
const LEVEL_SPAN: f64 = 0.6;

impl Cells {
    fn new(bodies: &Bodies, reach: f64) -> Self {
        let mut radii: Vec<f64> = bodies.fixed.iter().map(|fixed| f64::from(fixed.outer_radius)).collect();
        radii.sort_unstable_by(f64::total_cmp);
        let mut levels = Vec::new();
        let mut rest = radii.as_slice();
        while let Some(&largest) = rest.last() {
            let below = rest.partition_point(|&radius| radius < LEVEL_SPAN * largest);
            let smallest = rest[below];
            levels.push(Level::new(bodies, smallest, largest, reach));
            rest = &rest[..below];
        }
        Self { levels }
    }

    /// Bodies after `a` whose bounding spheres come within `limit` of that of `a`.
    fn partners(&self, bodies: &Bodies, a: u32, limit: f32, found: &mut Vec<u32>) {
        let radius = bodies.fixed[a as usize].outer_radius;
        let centre = bodies.state[a as usize].centre;
        for level in &self.levels {
            let range = f64::from(radius) + level.largest + f64::from(limit);
            level.visit(&centre, range, |b| {
                let x = bodies.offset(a, b);
                let near = radius + bodies.fixed[b as usize].outer_radius + limit;
                if b > a && dot(x, x) <= near * near {
                    found.push(b);
                }
            });
        }
    }
}

impl Level {
    fn new(bodies: &Bodies, smallest: f64, largest: f64, reach: f64) -> Self {
        let members: Vec<u32> = (0..bodies.len() as u32)
            .filter(|&body| (smallest..=largest).contains(&f64::from(bodies.fixed[body as usize].outer_radius)))
            .collect();
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &body in &members {
            let centre = bodies.state[body as usize].centre;
            for i in 0..3 {
                low[i] = low[i].min(centre[i]);
                high[i] = high[i].max(centre[i]);
            }
        }
        let cell = 2.0 * largest + reach;
        let counts = [0, 1, 2].map(|i| ((high[i] - low[i]) / cell) as i64 + 1);
        let mut level = Self { origin: low, cell, counts, largest, starts: Vec::new(), members: Vec::new() };
        let keys: Vec<u32> =
            members.iter().map(|&body| level.flat(level.cell_of(&bodies.state[body as usize].centre))).collect();
        level.starts = starts(counts.iter().product::<i64>() as usize, keys.iter().copied());
        let mut next = level.starts.clone();
        level.members = vec![0; members.len()];
        for (&body, &key) in members.iter().zip(&keys) {
            level.members[next[key as usize] as usize] = body;
            next[key as usize] += 1;
        }
        level
    }

    fn visit(&self, centre: &crate::math::Vec3, range: f64, mut each: impl FnMut(u32)) {
        let low = self.cell_of(&(centre - crate::math::Vec3::repeat(range)));
        let high = self.cell_of(&(centre + crate::math::Vec3::repeat(range)));
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let (first, last) = (self.flat([low[0], y, z]) as usize, self.flat([high[0], y, z]) as usize);
                for &body in &self.members[self.starts[first] as usize..self.starts[last + 1] as usize] {
                    each(body);
                }
            }
        }
    }

    fn cell_of(&self, point: &crate::math::Vec3) -> [i64; 3] {
        [0, 1, 2].map(|i| (((point[i] - self.origin[i]) / self.cell) as i64).clamp(0, self.counts[i] - 1))
    }

    fn flat(&self, cell: [i64; 3]) -> u32 {
        ((cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]) as u32
    }
}
