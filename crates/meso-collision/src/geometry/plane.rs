//! Planes, and the faces that lie in them.

use crate::math::Vec3;
use std::borrow::Borrow;

/// A face plane: the body lies where `normal . x <= offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Outward unit normal.
    pub normal: Vec3,
    /// Signed distance from the origin, mm.
    pub offset: f64,
}

impl Plane {
    /// How far `x` lies above the plane, mm; negative on the body's side.
    #[inline]
    pub fn height(&self, x: &Vec3) -> f64 {
        self.normal.dot(x) - self.offset
    }

    /// How far `x` lies above the outermost of a body's planes, mm: no more than its distance from outside, and inside the
    /// depth below the surface, negative.
    #[inline]
    pub fn height_over<P: Borrow<Self>>(planes: impl IntoIterator<Item = P>, x: &Vec3) -> f64 {
        planes.into_iter().map(|plane| plane.borrow().height(x)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A face as a part of its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Where it lies.
    pub(crate) plane: Plane,
    /// mm2.
    pub(crate) area: f64,
    /// Number of its corners.
    pub(crate) corners: usize,
}
