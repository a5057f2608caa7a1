//! Planes, and the faces that lie in them.

use crate::math::Vec3;

/// A face plane: the body lies where `normal . x <= offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Outward unit normal.
    pub normal: Vec3,
    /// Signed distance from the origin, mm.
    pub offset: f64,
}

/// A face as a part of its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Where it lies.
    pub plane: Plane,
    /// mm2.
    pub area: f64,
    /// Number of its corners.
    pub corners: usize,
}
