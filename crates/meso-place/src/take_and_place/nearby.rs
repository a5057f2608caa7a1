//! Bodies by grid cell, with their inscribed balls: the prefilter of random positions.
//!
//! Every test of a random position waits for memory. So bodies stand eight to a bucket with their balls, which are
//! tested together, and a test reads one or two buckets.

use crate::cell_grid::{CellGrid, cells, is_first_common};
use meso_collision::lanes::{Eight, LANES, least_lane_from_0};
use meso_collision::math::Aabb;
use meso_collision::prefetch::prefetch;

/// No body, and no bucket.
const NONE: u32 = u32::MAX;

/// Position of an empty lane's ball, mm: farther than any other, though its squared distance is still finite.
const NOWHERE: f32 = 1e15;

/// Up to eight bodies of a cell.
#[derive(Clone, Debug)]
struct Bucket {
    x: Eight,
    y: Eight,
    z: Eight,
    radius: Eight,
    bodies: [u32; LANES],
    count: u32,
    /// The cell's bucket before this one, which is full.
    before: u32,
}

impl Bucket {
    const EMPTY: Self = Self {
        x: [NOWHERE; LANES],
        y: [NOWHERE; LANES],
        z: [NOWHERE; LANES],
        radius: [0.0; LANES],
        bodies: [NONE; LANES],
        count: 0,
        before: NONE,
    };
}

/// Buckets per block: blocks take no more memory than they need, and leave small allocations to others.
const BLOCK: usize = 256;

/// Buckets by their numbers.
#[derive(Clone, Debug, Default)]
struct Buckets(Vec<Vec<Bucket>>);

impl Buckets {
    #[inline(always)]
    fn get(&self, number: u32) -> &Bucket {
        &self.0[number as usize / BLOCK][number as usize % BLOCK]
    }

    fn get_mut(&mut self, number: u32) -> &mut Bucket {
        &mut self.0[number as usize / BLOCK][number as usize % BLOCK]
    }

    /// Adds a bucket; its number.
    fn add(&mut self, bucket: Bucket) -> u32 {
        if self.0.last().is_none_or(|block| block.len() == BLOCK) {
            self.0.push(Vec::with_capacity(BLOCK));
        }
        let last = self.0.len() - 1;
        self.0[last].push(bucket);
        (last * BLOCK + self.0[last].len() - 1) as u32
    }
}

/// Bodies by the cells that their boxes reach into. They are only ever added.
#[derive(Clone, Debug)]
pub(super) struct Nearby {
    grid: CellGrid,
    /// Last bucket of every cell.
    last: Vec<u32>,
    buckets: Buckets,
    /// Lowest cell of every body, by body.
    lowest: Vec<[u16; 3]>,
}

/// The body that is nearest to a ball for the size of both.
#[derive(Clone, Copy)]
pub(super) struct Closest {
    /// Distance squared of the two balls' centres over that where they touch.
    pub(super) closeness: f32,
    /// The bucket that has it, and its lane there.
    bucket: u32,
    lane: usize,
}

impl Nearby {
    /// An empty grid over `domain` with cells of about `cell` mm; `bodies` is a hint of how many will come.
    pub(super) fn new(domain: &Aabb, cell: f64, bodies: usize) -> Self {
        let grid = CellGrid::new(domain, cell);
        let lowest = Vec::with_capacity(bodies);
        Self { last: vec![NONE; grid.len()], grid, buckets: Buckets::default(), lowest }
    }

    /// Adds the next body by its box and the x, y, z and radius of a ball that it holds, mm; bodies are numbered from
    /// 0 in the order they come.
    pub(super) fn insert(&mut self, aabb: &Aabb, ball: [f32; 4]) {
        let body = self.lowest.len() as u32;
        let (low, high) = self.grid.range(aabb);
        for cell in cells(low, high) {
            let (bucket, lane) = self.open_lane(self.grid.flat(cell));
            let [x, y, z, radius] = ball;
            (bucket.x[lane], bucket.y[lane], bucket.z[lane]) = (x, y, z);
            (bucket.radius[lane], bucket.bodies[lane]) = (radius, body);
        }
        self.lowest.push(low.map(|i| i as u16));
    }

    /// A cell's last bucket, or a new one where that is full, and the lane in it that is next.
    fn open_lane(&mut self, cell: usize) -> (&mut Bucket, usize) {
        let last = &mut self.last[cell];
        if *last == NONE || self.buckets.get(*last).count as usize == LANES {
            *last = self.buckets.add(Bucket { before: *last, ..Bucket::EMPTY });
        }
        let bucket = self.buckets.get_mut(*last);
        bucket.count += 1;
        let lane = bucket.count as usize - 1;
        (bucket, lane)
    }

    /// The cell numbers of these points, by axis; a point on a cell's side counts to either.
    #[inline(always)]
    pub(super) fn cells_about<const N: usize>(&self, points: &[[f32; N]; 3]) -> [u32; N] {
        self.grid.flat_about(points)
    }

    /// Prefetches this cell.
    #[inline(always)]
    pub(super) fn prefetch(&self, cell: u32) {
        let last = self.last[cell as usize];
        if last != NONE {
            prefetch(std::slice::from_ref(self.buckets.get(last)));
        }
    }

    /// Among the bodies that reach into this cell, the one nearest to the ball about x, y, z, relative to the sizes
    /// of both.
    #[inline(always)]
    pub(super) fn closest(&self, cell: u32, [x, y, z]: [f32; 3], own_radius: f32) -> Closest {
        let (mut least, mut buckets) = ([f32::MAX; LANES], [NONE; LANES]);
        let mut next = self.last[cell as usize];
        while next != NONE {
            let bucket = self.buckets.get(next);
            let mut closeness = [0.0; LANES];
            for (lane, closeness) in closeness.iter_mut().enumerate() {
                let (dx, dy, dz) = (bucket.x[lane] - x, bucket.y[lane] - y, bucket.z[lane] - z);
                let reach = own_radius + bucket.radius[lane];
                *closeness = (dx * dx + dy * dy + dz * dz) / (reach * reach);
            }
            for lane in 0..LANES {
                buckets[lane] = if closeness[lane] < least[lane] { next } else { buckets[lane] };
            }
            for lane in 0..LANES {
                least[lane] = if closeness[lane] < least[lane] { closeness[lane] } else { least[lane] };
            }
            next = bucket.before;
        }
        let (closeness, lane) = least_lane_from_0(&least);
        Closest { closeness, bucket: buckets[lane], lane }
    }

    /// The number of the body that was found, if there is one.
    #[inline(always)]
    pub(super) fn body(&self, found: Closest) -> Option<u32> {
        (found.bucket != NONE).then(|| self.buckets.get(found.bucket).bodies[found.lane])
    }

    /// Every body whose cells meet those of `aabb`, each once; stops and returns false when `visit` returns false.
    pub(super) fn all_near(&self, aabb: &Aabb, mut visit: impl FnMut(u32) -> bool) -> bool {
        let (low, high) = self.grid.range(aabb);
        cells(low, high).all(|cell| {
            let mut next = self.last[self.grid.flat(cell)];
            while next != NONE {
                let bucket = self.buckets.get(next);
                let all = bucket.bodies[..bucket.count as usize]
                    .iter()
                    .rev()
                    .all(|&body| !is_first_common(cell, low, self.lowest[body as usize]) || visit(body));
                if !all {
                    return false;
                }
                next = bucket.before;
            }
            true
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::math::Vec3;
    use meso_concrete::aggregate::random::{Draw, Stream};

    const DOMAIN: f64 = 30.0;

    /// Balls in boxes a little larger than they are, as x, y, z and radius.
    fn scene(stream: &mut Stream, bodies: usize) -> (Nearby, Vec<Aabb>, Vec<[f32; 4]>) {
        let domain = Aabb { min: Vec3::zeros(), max: Vec3::repeat(DOMAIN) };
        let mut nearby = Nearby::new(&domain, 6.0, 1);
        let (mut boxes, mut balls) = (Vec::new(), Vec::new());
        for _ in 0..bodies {
            let (centre, radius) = (stream.point(&domain.min, &domain.max), stream.uniform(0.5, 3.0));
            let aabb = Aabb { min: centre - Vec3::repeat(1.2 * radius), max: centre + Vec3::repeat(1.3 * radius) };
            let [x, y, z, radius] = [centre.x, centre.y, centre.z, radius].map(|x| x as f32);
            nearby.insert(&aabb, [x, y, z, radius]);
            boxes.push(aabb);
            balls.push([x, y, z, radius]);
        }
        (nearby, boxes, balls)
    }

    #[test]
    fn near_bodies_are_named_once_each() {
        // More than fill a bucket of most cells, and more than a block of buckets.
        let (nearby, boxes, _) = scene(&mut Stream::new(3, Draw::Sample, 0, 0), 900);
        assert!(nearby.buckets.0.len() > 1);
        for aabb in &boxes {
            let mut seen = vec![0; boxes.len()];
            nearby.all_near(aabb, |body| {
                seen[body as usize] += 1;
                true
            });
            for (seen, other) in seen.into_iter().zip(&boxes) {
                assert!(seen <= 1);
                assert!(seen == 1 || !aabb.intersects(other), "a near body was missed");
            }
        }
    }

    #[test]
    fn a_look_finds_a_ball_that_holds_the_point_wherever_one_does() {
        let mut stream = Stream::new(4, Draw::Sample, 0, 0);
        let (nearby, _, balls) = scene(&mut stream, 600);
        let mut held = 0;
        for _ in 0..200 {
            let points: [[f32; 5]; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| stream.uniform(0.0, DOMAIN) as f32));
            for (i, cell) in nearby.cells_about(&points).into_iter().enumerate() {
                let at = [points[0][i], points[1][i], points[2][i]];
                let closeness = |[x, y, z, radius]: &[f32; 4]| {
                    ((x - at[0]).powi(2) + (y - at[1]).powi(2) + (z - at[2]).powi(2)) / radius.powi(2)
                };
                let least = balls.iter().map(closeness).fold(f32::INFINITY, f32::min);
                let found = nearby.closest(cell, at, 0.0);
                if least < 1.0 {
                    let body = nearby.body(found).expect("its box reaches into the cell");
                    assert!((found.closeness / least - 1.0).abs() < 1e-5);
                    assert!((closeness(&balls[body as usize]) / least - 1.0).abs() < 1e-5);
                    held += 1;
                } else {
                    assert!(found.closeness >= 0.9999);
                }
            }
        }
        assert!((300..700).contains(&held), "{held} of 1000");
    }
}
