//! Cells of equal size over a box, and which of them another box reaches into.

use meso_collision::math::{Aabb, Vec3};

/// No more cells than this, whatever the sizes: bodies may be few and small in a large specimen.
const MOST_CELLS: f64 = 4.0e6;

/// Nor more than this along an axis.
const MOST_ALONG: f64 = 65_535.0;

/// A grid of cells.
#[derive(Clone, Debug)]
pub(super) struct CellGrid {
    origin: Vec3,
    per_mm: f64,
    counts: [i32; 3],
}

impl CellGrid {
    /// Over `domain` with cells of about `cell` mm.
    pub(super) fn new(domain: &Aabb, cell: f64) -> Self {
        let size = domain.size();
        let cell = cell.max(libm::cbrt(size.product() / MOST_CELLS)).max(size.max() / MOST_ALONG);
        let counts = [0, 1, 2].map(|i| (size[i] / cell).ceil().max(1.0) as i32);
        Self { origin: domain.min, per_mm: 1.0 / cell, counts }
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.counts.iter().map(|&n| n as usize).product()
    }

    /// The cell at `point`; of points beyond the box the one nearest to it.
    #[inline]
    pub(super) fn cell_of(&self, point: &Vec3) -> [i32; 3] {
        let along = |i: usize| (((point[i] - self.origin[i]) * self.per_mm) as i32).clamp(0, self.counts[i] - 1);
        [along(0), along(1), along(2)]
    }

    /// The cell numbers of points given by axis. A point within single precision of a cell's side counts to either
    /// cell.
    #[inline(always)]
    pub(super) fn flat_about<const N: usize>(&self, points: &[[f32; N]; 3]) -> [u32; N] {
        let mut flat = [0; N];
        for axis in [2, 1, 0] {
            let (origin, per_mm, count) = (self.origin[axis] as f32, self.per_mm as f32, self.counts[axis]);
            for i in 0..N {
                let along = (((points[axis][i] - origin) * per_mm) as i32).clamp(0, count - 1);
                flat[i] = flat[i] * count as u32 + along as u32;
            }
        }
        flat
    }

    /// The lowest and the highest cell that `aabb` reaches into.
    #[inline]
    pub(super) fn range(&self, aabb: &Aabb) -> ([i32; 3], [i32; 3]) {
        (self.cell_of(&aabb.min), self.cell_of(&aabb.max))
    }

    /// The number of a cell.
    #[inline]
    pub(super) fn flat(&self, cell: [i32; 3]) -> usize {
        ((cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]) as usize
    }
}

/// All cells from `low` to `high`.
#[inline]
pub(super) fn cells(low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (low[2]..=high[2])
        .flat_map(move |z| (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y, z])))
}

/// True for the lowest of the cells that two ranges share, by the lowest cell of each: a pair is met there and nowhere
/// else.
#[inline]
pub(super) fn is_first_common(cell: [i32; 3], low: [i32; 3], other_low: [u16; 3]) -> bool {
    (0..3).all(|i| cell[i] == low[i].max(i32::from(other_low[i])))
}
