//! Clearance grid: balls by the cells that they reach into, for tests of random positions.
//!
//! Every test waits for memory. So a cell and its first balls stand in one bucket of 128 bytes; a list of lists would
//! cost two cache misses.

use crate::cell_grid::{CellGrid, cells};
use meso_collision::math::{Aabb, Vec3};

/// Balls in a bucket: as many as most cells ever hold.
const CAPACITY: usize = 7;
/// [`CAPACITY`] balls - x, y, z and radius in mm, as the bits of f32 - then their count, then the number of the next
/// bucket. Plain numbers, since of these a list of zeros takes no memory before it is written.
type Bucket = [u32; 32];
const COUNT: usize = 28;
const NEXT: usize = 29;

/// The balls that lie there already.
pub(super) struct ClearanceGrid {
    grid: CellGrid,
    /// The first bucket of every cell, then those that were added when one was full.
    buckets: Vec<Bucket>,
}

impl ClearanceGrid {
    /// None yet, over `domain` with cells of about `cell` mm.
    pub(super) fn new(domain: &Aabb, cell: f64) -> Self {
        let grid = CellGrid::new(domain, cell);
        Self { buckets: vec![[0; 32]; grid.len()], grid }
    }

    /// Adds a ball (mm).
    pub(super) fn insert(&mut self, centre: &Vec3, radius: f64) {
        let ball = [centre.x, centre.y, centre.z, radius].map(|value| (value as f32).to_bits());
        let (low, high) = self.grid.range(&around(centre, radius));
        for cell in cells(low, high) {
            let bucket = self.open_bucket(self.grid.flat(cell));
            let count = bucket[COUNT] as usize;
            bucket[4 * count..4 * count + 4].copy_from_slice(&ball);
            bucket[COUNT] += 1;
        }
    }

    /// The last bucket of a cell, with space for one more.
    fn open_bucket(&mut self, mut number: usize) -> &mut Bucket {
        while self.buckets[number][NEXT] != 0 {
            number = self.buckets[number][NEXT] as usize;
        }
        if self.buckets[number][COUNT] as usize == CAPACITY {
            self.buckets[number][NEXT] = self.buckets.len() as u32;
            number = self.buckets.len();
            self.buckets.push([0; 32]);
        }
        &mut self.buckets[number]
    }

    /// Distance of a ball to the nearest other in the cells it reaches into, negative where it overlaps one, infinite
    /// where there is none; or of any other, no farther than `enough` (mm).
    pub(super) fn clearance(&self, centre: &Vec3, radius: f64, enough: f32) -> f32 {
        let (low, high) = self.grid.range(&around(centre, radius));
        let own = [centre.x as f32, centre.y as f32, centre.z as f32];
        let mut least = f32::INFINITY;
        for z in low[2]..=high[2] {
            for y in low[1]..=high[1] {
                let row = self.grid.flat([low[0], y, z])..=self.grid.flat([high[0], y, z]);
                for mut bucket in &self.buckets[row] {
                    least = least.min(nearest(bucket, own) - radius as f32);
                    while least > enough && bucket[NEXT] != 0 {
                        bucket = &self.buckets[bucket[NEXT] as usize];
                        least = least.min(nearest(bucket, own) - radius as f32);
                    }
                    if least <= enough {
                        return least;
                    }
                }
            }
        }
        least
    }
}

/// Distance from a point to the surface of the nearest ball of a bucket.
#[inline(always)]
fn nearest(bucket: &Bucket, [x, y, z]: [f32; 3]) -> f32 {
    let mut least = f32::INFINITY;
    for ball in bucket[..4 * bucket[COUNT] as usize].chunks_exact(4) {
        let at = |k: usize| f32::from_bits(ball[k]);
        let (dx, dy, dz) = (at(0) - x, at(1) - y, at(2) - z);
        least = least.min((dx * dx + dy * dy + dz * dz).sqrt() - at(3));
    }
    least
}

/// The box of a ball.
pub(super) fn around(centre: &Vec3, radius: f64) -> Aabb {
    let half = Vec3::repeat(radius);
    Aabb { min: centre - half, max: centre + half }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_concrete::aggregate::random::{Draw, Stream};

    #[test]
    fn the_clearance_is_that_of_the_nearest_ball_in_reach() {
        let domain = Aabb { min: Vec3::zeros(), max: Vec3::repeat(30.0) };
        let mut stream = Stream::new(11, Draw::Sample, 0, 0);
        let mut draw = || (stream.point(&domain.min, &domain.max), stream.uniform(0.5, 4.0));
        let lying: Vec<(Vec3, f64)> = (0..400).map(|_| draw()).collect();
        let mut balls = ClearanceGrid::new(&domain, 5.0);
        lying.iter().for_each(|(centre, radius)| balls.insert(centre, *radius));
        let (mut full, mut overlapping) = (0, 0);
        for _ in 0..500 {
            let (centre, radius) = draw();
            let clearance = |(other, its): &(Vec3, f64)| (other - centre).norm() - radius - its;
            let least = lying.iter().map(clearance).fold(f64::INFINITY, f64::min);
            let found = f64::from(balls.clearance(&centre, radius, f32::NEG_INFINITY));
            assert!(if least < 0.0 { (found - least).abs() < 1e-4 } else { found > least - 1e-4 }, "{found} {least}");
            assert!(balls.clearance(&centre, radius, 0.0) <= 0.0 || least > -1e-4);
            overlapping += u32::from(least < 0.0);
            full += u32::from(balls.buckets.len() > balls.grid.len());
        }
        assert!(overlapping > 100 && full > 0, "some overlap, and some cells hold more than a bucket");
    }
}
