//! Prisms with a notch sawn into the middle of their lower side, for bending tests.

use super::box_minus_convex::BoxMinusConvex;
use super::profile::{self, Station};
use meso_collision::geometry::HullError;
use meso_collision::math::Vec3;

/// Length along x, width along y, depth along z, and the notch's depth and width, mm.
pub(super) fn container(
    [length, width, depth]: [f64; 3],
    notch_depth: f64,
    notch_width: f64,
) -> Result<BoxMinusConvex, HullError> {
    let (left, right) = ((length - notch_width) / 2.0, (length + notch_width) / 2.0);
    let station = |x: f64, low: f64| Station { x, low, high: depth };
    let lows = [(0.0, 0.0), (left, 0.0), (left, notch_depth), (right, notch_depth), (right, 0.0), (length, 0.0)];
    let surface = profile::surface(&lows.map(|(x, low)| station(x, low)), width, true);
    let corner = |i: usize| {
        let (x, y) = ([left, right][i & 1], [-width, 2.0 * width][i >> 1 & 1]);
        Vec3::new(x, y, [-depth, notch_depth][i >> 2])
    };
    let narrowest = length.min(width).min(depth - notch_depth);
    BoxMinusConvex::new(surface, narrowest, &[(0..8).map(corner).collect()])
}
