//! The side of a plane or a line that a point lies on: signs that rounding cannot change.
//!
//! Shewchuk's adaptive predicates (crate `robust`) are exact unless a product over- or underflows. With coordinates in
//! {0} and [`MIN_MAGNITUDE`] to [`MAX_MAGNITUDE`], every bit of an f64 weighs at least 2^-252 and less than 2^200, so
//! that of a product of three at least 2^-756 and less than 2^600: nothing is lost.

use crate::math::Vec3;
use robust::{Coord, Coord3D};

/// The smallest accepted magnitude of a coordinate that is not 0.
pub(crate) const MIN_MAGNITUDE: f64 = 1e-60;
/// The largest accepted magnitude of a coordinate.
pub(crate) const MAX_MAGNITUDE: f64 = 1e60;

/// True where the predicates are exact for this coordinate.
pub(crate) fn in_range(x: f64) -> bool {
    x == 0.0 || (MIN_MAGNITUDE..=MAX_MAGNITUDE).contains(&x.abs())
}

/// The sign of ((b - a) x (c - a)) . (p - a): positive where the triangle (a, b, c) is counter-clockwise seen from `p`.
pub fn orient3d(a: &Vec3, b: &Vec3, c: &Vec3, p: &Vec3) -> f64 {
    let coord = |v: &Vec3| Coord3D { x: v.x, y: v.y, z: v.z };
    -robust::orient3d(coord(a), coord(b), coord(c), coord(p))
}

/// True when the three points lie on one line (or coincide): their projections along every axis do.
pub(crate) fn collinear(a: &Vec3, b: &Vec3, c: &Vec3) -> bool {
    [(0, 1), (1, 2), (2, 0)].into_iter().all(|(i, j)| {
        let coord = |v: &Vec3| Coord { x: v[i], y: v[j] };
        robust::orient2d(coord(a), coord(b), coord(c)) == 0.0
    })
}
