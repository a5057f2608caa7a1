//! Aggregates as the mesh builders ask of them: face planes, point location, where a line leaves a grain.

use super::Phase;
use crate::aggregate::Aggregate;
use crate::geometry::Plane;
use crate::math::{Aabb, Vec3};
use rayon::prelude::*;

/// A grain by its face planes.
pub(crate) struct Grain {
    pub(crate) id: u32,
    /// Of its inside.
    pub(crate) phase: Phase,
    pub(crate) aabb: Aabb,
    pub(crate) planes: Vec<Plane>,
    /// Shell thickness in this mesh, mm; 0: no shell.
    pub(crate) shell: f64,
}

impl Grain {
    /// `shell(aggregate)` is the thickness of its shell in the mesh, mm.
    pub(crate) fn all(aggregates: &[Aggregate], shell: impl Fn(&Aggregate) -> f64 + Sync) -> Vec<Self> {
        let grain = |a: &Aggregate| Self {
            id: a.id,
            phase: Phase::inside(a.kind),
            aabb: a.body.aabb(),
            planes: a.body.planes().collect(),
            shell: shell(a),
        };
        aggregates.par_iter().map(grain).collect()
    }

    /// Distance to the farthest face plane ahead, mm: negative inside, where its size is the depth below the surface.
    pub(crate) fn height(&self, x: &Vec3) -> f64 {
        self.planes.iter().map(|p| p.normal.dot(x) - p.offset).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The part of the segment from `inside` to `outside` that lies within the grain, 0 to 1.
    pub(crate) fn exit(&self, inside: &Vec3, outside: &Vec3) -> f64 {
        let direction = outside - inside;
        let mut exit: f64 = 1.0;
        for plane in &self.planes {
            let speed = plane.normal.dot(&direction);
            if speed > 0.0 {
                exit = exit.min((plane.offset - plane.normal.dot(inside)) / speed);
            }
        }
        exit.max(0.0)
    }
}

/// Grains by the cells of a coarse grid: which one holds a point.
pub(crate) struct Locator<'a> {
    grains: &'a [Grain],
    min: Vec3,
    cell: f64,
    counts: [usize; 3],
    buckets: Vec<Vec<u32>>,
}

/// Longest edge of a locator's cell, mm, in grains' mean box sizes.
const CELL_PER_GRAIN: f64 = 0.5;

impl<'a> Locator<'a> {
    pub(crate) fn new(grains: &'a [Grain], domain: &Aabb) -> Self {
        let mean = grains.iter().map(|g| g.aabb.size().max()).sum::<f64>() / grains.len().max(1) as f64;
        let cell = (mean * CELL_PER_GRAIN).max(domain.size().max() / 256.0);
        let counts = [0, 1, 2].map(|i| (domain.size()[i] / cell).ceil().max(1.0) as usize);
        let mut locator =
            Self { grains, min: domain.min, cell, counts, buckets: vec![Vec::new(); counts.iter().product()] };
        for (index, grain) in grains.iter().enumerate() {
            let (low, high) = (locator.cell_of(&grain.aabb.min), locator.cell_of(&grain.aabb.max));
            for k in low[2]..=high[2] {
                for j in low[1]..=high[1] {
                    for i in low[0]..=high[0] {
                        let bucket = locator.bucket([i, j, k]);
                        locator.buckets[bucket].push(index as u32);
                    }
                }
            }
        }
        locator
    }

    /// The grain that holds `x`, as an index, with the point's (negative) height; of several the first.
    pub(crate) fn find(&self, x: &Vec3) -> Option<(usize, f64)> {
        let bucket = &self.buckets[self.bucket(self.cell_of(x))];
        let heights = bucket.iter().map(|&g| (g as usize, self.grains[g as usize].height(x)));
        heights.into_iter().find(|(_, height)| *height <= 0.0)
    }

    fn cell_of(&self, x: &Vec3) -> [usize; 3] {
        [0, 1, 2].map(|i| (((x[i] - self.min[i]) / self.cell).max(0.0) as usize).min(self.counts[i] - 1))
    }

    fn bucket(&self, [i, j, k]: [usize; 3]) -> usize {
        (k * self.counts[1] + j) * self.counts[0] + i
    }
}
