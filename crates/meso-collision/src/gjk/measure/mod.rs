//! Depths of overlaps and times of impact, each between two bounds.

pub(crate) mod impact;
pub(crate) mod penetration;

use crate::gjk::prove::certificate::highest;
use crate::gjk::support::Support;
use crate::math::Vec3;

/// An upper bound of the height of a body's points.
fn top(body: &impl Support, v: &Vec3) -> f64 {
    (0..body.len()).map(|i| highest(&body.point(i), v)).fold(f64::NEG_INFINITY, f64::max)
}
