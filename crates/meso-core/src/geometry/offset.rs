//! The inward offset: the ITZ's inner surface (Sec. 2.1, Fig. 2).
//!
//! The planes are moved inwards and intersected through duality: about an interior point, the plane n . x = h becomes
//! the point n / h, and the hull of these points is dual to the eroded body (its facets are the body's vertices).
//! Dual points are rounded once from double-double values and their hull is exact, so the result is the exact
//! erosion of planes displaced by at most 2^-53 of the body's extent: that makes the error of its volume a product
//! which is known beforehand, extent times area over volume. Where that is too large the answer is an error.

mod dual;
mod planes;

use super::inradius::{Erosion, erosion, plane_corners};
use super::{HullError, Polyhedron};
use crate::math::Vec3;
use planes::dual_points;

/// Relative error of the volume beyond which no answer is given.
const ACCURACY: f64 = 1e-9;

/// Why an offset has no trustworthy answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OffsetError {
    /// The thickness is negative, NaN or infinite.
    #[error("the offset thickness is {thickness}; it must be finite and not negative")]
    Thickness {
        /// The value given, mm.
        thickness: f64,
    },
    /// The result cannot be given to the promised accuracy.
    #[error("the offset is ill-conditioned: {reason}")]
    IllConditioned {
        /// What was met.
        reason: String,
    },
}

/// The half-space erosion { x : n_i . x <= d_i - thickness |n_i| } of `body`, or `None` where it vanishes.
///
/// `thickness` in mm. Whether it vanishes (has no volume) is decided exactly. The volume of the result is right to 1e-12
/// for well-shaped bodies and to 1e-9 for all; it is that of the exact erosion, where its vertices are rounded to f64.
/// A face that is not plane to the last bit counts as the plane of its widest triangle.
///
/// # Errors
/// See [`OffsetError`].
pub fn inward_offset(body: &Polyhedron, thickness: f64) -> Result<Option<Polyhedron>, OffsetError> {
    if !thickness.is_finite() || thickness < 0.0 {
        return Err(OffsetError::Thickness { thickness });
    }
    if thickness == 0.0 {
        return Ok(Some(body.clone()));
    }
    let corners = plane_corners(body);
    // Most shells are thin: the centroid is well inside, and no search for a better centre is needed.
    let centroid = body.centroid();
    if let Some(points) = dual_points(&corners, &centroid, thickness) {
        return dual::intersect(&points, &centroid).map(Some);
    }
    if clearly_vanishes(body, thickness) {
        return Ok(None);
    }
    match erosion(&corners, thickness) {
        Erosion::Nothing => Ok(None),
        Erosion::Around(center) => {
            let points = dual_points(&corners, &center, thickness)
                .ok_or_else(|| ill_conditioned("what is left is smaller than the spacing of f64 numbers there"))?;
            dual::intersect(&points, &center).map(Some)
        }
    }
}

/// A ball of radius r fits only where 3 volumes are at least r areas (the cones from its centre to the faces).
fn clearly_vanishes(body: &Polyhedron, thickness: f64) -> bool {
    let roundings = 1.0 - 1e-10;
    let area: f64 = body.triangles().map(|t| area_at_least(&t.map(|i| body.vertices()[i as usize]))).sum();
    3.0 * body.volume() < thickness * area * roundings
}

fn area_at_least([a, b, c]: &[Vec3; 3]) -> f64 {
    let (u, v) = (b - a, c - a);
    (u.cross(&v).norm() - 8.0 * f64::EPSILON * u.norm() * v.norm()).max(0.0) / 2.0
}

fn ill_conditioned(reason: &str) -> OffsetError {
    OffsetError::IllConditioned { reason: reason.to_owned() }
}

impl From<HullError> for OffsetError {
    fn from(_: HullError) -> Self {
        ill_conditioned("the planes, moved inwards, cannot be told apart in f64")
    }
}
