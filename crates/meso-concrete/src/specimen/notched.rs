//! Prisms with a notch sawn into their lower side, for bending tests, and perhaps one above it, for shear.

use super::box_minus_convex::BoxMinusConvex;
use super::profile::{self, Station};
use meso_collision::geometry::HullError;
use meso_collision::math::Vec3;

/// Length along x, width along y, depth along z, the depths of the lower and of the upper notch, their width, and the
/// place of their middle along x, mm.
pub(super) fn container(
    [length, width, depth]: [f64; 3],
    [lower, upper]: [f64; 2],
    notch_width: f64,
    middle: f64,
) -> Result<BoxMinusConvex, HullError> {
    let (left, right) = (middle - notch_width / 2.0, middle + notch_width / 2.0);
    let station = |(x, is_notched): (f64, bool)| {
        let [below, above] = if is_notched { [lower, upper] } else { [0.0; 2] };
        Station { x, low: below, high: depth - above }
    };
    let line = [(0.0, false), (left, false), (left, true), (right, true), (right, false), (length, false)];
    let surface = profile::surface(&line.map(station), width, true);
    let cutout = |[low, high]: [f64; 2]| {
        let corner = |i: usize| {
            let (x, y) = ([left, right][i & 1], [-width, 2.0 * width][i >> 1 & 1]);
            Vec3::new(x, y, [low, high][i >> 2])
        };
        (0..8).map(corner).collect::<Vec<_>>()
    };
    let notches = [(lower, [-depth, lower]), (upper, [depth - upper, 2.0 * depth])];
    let cutouts: Vec<_> = notches.into_iter().filter(|(deep, _)| *deep > 0.0).map(|(_, z)| cutout(z)).collect();
    let narrowest = length.min(width).min(depth - lower - upper);
    BoxMinusConvex::new(surface, narrowest, &cutouts)
}
