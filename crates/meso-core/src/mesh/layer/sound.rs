//! When a tetrahedron is good enough: the volume that it must keep.

use super::LayerCell;
use crate::math::Vec3;

/// A cell of the aggregate may lose all but this share of its shape (volume over mean edge cubed).
const KEPT_SHAPE: f64 = 0.03;
/// A rail stands at least this high over its triangle, as a share of its length: 1 degree.
const UPRIGHT: f64 = 0.02;

/// The least volume of a cell of the aggregate that was at `before` and is at `now`, mm3.
pub(super) fn least_of_core(before: [Vec3; 4], now: [Vec3; 4]) -> f64 {
    KEPT_SHAPE * volume(before) * (size(now) / size(before))
}

/// The least volume of a cell of the layer whose rail ends at `rail`, mm3.
pub(super) fn least_of_layer(cell: &LayerCell, rail: [Vec3; 2]) -> f64 {
    UPRIGHT * cell.area * (rail[0] - rail[1]).norm() / 3.0
}

/// mm3.
pub(super) fn volume([a, b, c, d]: [Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// The cube of the edges' quadratic mean but for a factor, mm3.
pub(super) fn size(p: [Vec3; 4]) -> f64 {
    let squares: f64 = (0..4).map(|i| (0..i).map(|j| (p[i] - p[j]).norm_squared()).sum::<f64>()).sum();
    squares * squares.sqrt()
}
