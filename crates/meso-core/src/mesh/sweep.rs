//! Which grid points lie in which aggregate, and in its shell: row sweeps.
//!
//! A row of grid points parallel to x meets a convex grain in one interval, cut out by the grain's planes: nx x <= d -
//! ny y - nz z. So a grain costs its planes times its rows, and no point is ever tested against a grain.

use super::grains::Grain;
use crate::geometry::Plane;
use crate::math::Vec3;
use crate::stop;

/// Points `origin + (i, j, k) * spacing`, i fastest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointGrid {
    pub(crate) origin: Vec3,
    pub(crate) spacing: Vec3,
    pub(crate) counts: [usize; 3],
}

impl PointGrid {
    fn coordinate(&self, axis: usize, index: usize) -> f64 {
        self.origin[axis] + index as f64 * self.spacing[axis]
    }

    /// The indices whose coordinates lie within the closed interval `low..=high`.
    fn range(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let index = |x: f64| (x - self.origin[axis]) / self.spacing[axis];
        let start = index(low).ceil().max(0.0);
        let end = (index(high).floor() + 1.0).min(self.counts[axis] as f64);
        if start < end { start as usize..end as usize } else { 0..0 }
    }

    /// Points in one z layer.
    pub(crate) fn layer_len(&self) -> usize {
        self.counts[0] * self.counts[1]
    }
}

/// Where a point lies: in the mortar, or in the core or the shell of an aggregate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Label(u32);

impl Label {
    pub(crate) const MORTAR: Self = Self(u32::MAX);

    fn core(grain: u32) -> Self {
        Self(grain << 1)
    }

    fn shell(grain: u32) -> Self {
        Self(grain << 1 | 1)
    }

    /// Index of the grain, or `None` in the mortar.
    pub(crate) fn grain(self) -> Option<u32> {
        (self != Self::MORTAR).then_some(self.0 >> 1)
    }

    pub(crate) fn in_shell(self) -> bool {
        self != Self::MORTAR && self.0 & 1 == 1
    }
}

/// All grains, and by layer of a grid those that meet it.
pub(crate) struct Sweep<'a> {
    grid: PointGrid,
    grains: &'a [Grain],
    by_layer: Vec<Vec<u32>>,
}

impl<'a> Sweep<'a> {
    /// Prepares the labels of `grid`.
    pub(crate) fn new(grid: PointGrid, grains: &'a [Grain]) -> Self {
        let mut by_layer = vec![Vec::new(); grid.counts[2]];
        for (index, grain) in grains.iter().enumerate() {
            for k in grid.range(2, grain.aabb.min.z, grain.aabb.max.z) {
                by_layer[k].push(index as u32);
            }
        }
        Self { grid, grains, by_layer }
    }

    /// Labels of layer `k`, into `labels` of length [`PointGrid::layer_len`].
    pub(crate) fn label_layer(&self, k: usize, labels: &mut [Label]) {
        stop::point();
        labels.fill(Label::MORTAR);
        let z = self.grid.coordinate(2, k);
        for &index in &self.by_layer[k] {
            self.label_grain(index, z, labels);
        }
    }

    fn label_grain(&self, index: u32, z: f64, labels: &mut [Label]) {
        let grain = &self.grains[index as usize];
        for j in self.grid.range(1, grain.aabb.min.y, grain.aabb.max.y) {
            let row = &mut labels[j * self.grid.counts[0]..][..self.grid.counts[0]];
            let [outer, core] = grain.intervals(self.grid.coordinate(1, j), z);
            if grain.shell > 0.0 {
                row[self.grid.range(0, outer.low, outer.high)].fill(Label::shell(index));
            }
            row[self.grid.range(0, core.low, core.high)].fill(Label::core(index));
        }
    }
}

/// The part of a row inside a body; empty when `low > high`.
#[derive(Clone, Copy)]
struct Interval {
    low: f64,
    high: f64,
}

impl Interval {
    /// Keeps the part with `nx * x <= reach`.
    fn clip(&mut self, nx: f64, reach: f64) {
        if nx > 0.0 {
            self.high = self.high.min(reach / nx);
        } else if nx < 0.0 {
            self.low = self.low.max(reach / nx);
        } else if reach < 0.0 {
            self.high = f64::NEG_INFINITY;
        }
    }
}

impl Grain {
    /// The row through (y, z), in the outer body and in the core.
    fn intervals(&self, y: f64, z: f64) -> [Interval; 2] {
        let mut outer = Interval { low: self.aabb.min.x, high: self.aabb.max.x };
        let mut core = outer;
        for Plane { normal, offset } in &self.planes {
            let reach = offset - normal.y * y - normal.z * z;
            outer.clip(normal.x, reach);
            core.clip(normal.x, reach - self.shell);
        }
        [outer, core]
    }
}
