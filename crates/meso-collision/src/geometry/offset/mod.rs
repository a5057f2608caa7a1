//! The inward offset: the ITZ's inner surface (Sec. 2.1, Fig. 2).
//!
//! The planes are moved inwards and intersected through duality: about an interior point, the plane n . x = h becomes
//! the point n / h, and the hull of these points is dual to the eroded body (its facets are the body's vertices).
//! Dual points are rounded once from double-double values and their hull is exact, so the result is the exact
//! erosion of planes displaced by at most 2^-53 of the body's extent. The error of its volume is therefore known:
//! extent times area over volume, times that rounding. A body too slender for it is intersected again in an affine
//! frame in which it is round (its dual points are exact there until they are rounded), and mapped back.

mod dual;
mod frame;
mod planes;

use crate::geometry::measure::inradius::{Erosion, erosion, plane_corners};
use crate::geometry::{HullError, Polyhedron};
use crate::math::{Aabb, Vec3};
use dual::Dual;
use frame::Frame;
use planes::dual_points;

/// Relative error of the volume beyond which no answer is given.
const ACCURACY: f64 = 1e-9;

/// Half an ulp of 1.
const ROUNDING: f64 = f64::EPSILON / 2.0;

/// Why an offset has no trustworthy answer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OffsetError {
    /// The thickness is negative, NaN or infinite.
    #[error("the offset thickness is {thickness}; it must be finite and not negative")]
    Thickness {
        /// The value given, mm.
        thickness: f64,
    },
    /// The body has dents or is an ellipsoid, whose inner surface is no polyhedron.
    #[error("the body has dents or is an ellipsoid, so its inner surface is no polyhedron")]
    NotConvex,
    /// The result cannot be given to the promised accuracy.
    #[error("the offset is ill-conditioned: {reason}")]
    IllConditioned {
        /// The obstacle.
        reason: String,
    },
}

/// A thickness that a body can be moved by.
fn accepted(thickness: f64) -> Result<f64, OffsetError> {
    if !thickness.is_finite() || thickness < 0.0 {
        return Err(OffsetError::Thickness { thickness });
    }
    Ok(thickness)
}

impl Polyhedron {
    /// The half-space erosion { x : n_i . x <= d_i - thickness |n_i| } of the body, or `None` where it vanishes.
    ///
    /// `thickness` in mm. Whether it vanishes (has no volume) is decided exactly. The volume of the result is right to
    /// 1e-12 for well-shaped bodies and to 1e-9 for all; it is that of the exact erosion, where its vertices are
    /// rounded to f64. There is no answer only where f64 vertices cannot show the shape: where the rest is thinner than
    /// about 1e-13 of its distance from the origin. A face that is not plane to the last bit counts as the plane of its
    /// widest triangle.
    ///
    /// # Errors
    /// See [`OffsetError`].
    pub fn inward_offset(&self, thickness: f64) -> Result<Option<Self>, OffsetError> {
        self.eroded_by(accepted(thickness)?)
    }

    /// The body whose [`inward_offset`](Self::inward_offset) by `thickness` mm this one is: its planes are moved outwards, which
    /// mitres edges and corners and loses no face.
    ///
    /// # Errors
    /// See [`OffsetError`].
    pub fn outward_offset(&self, thickness: f64) -> Result<Self, OffsetError> {
        self.eroded_by(-accepted(thickness)?)?.ok_or_else(lost)
    }

    fn eroded_by(&self, thickness: f64) -> Result<Option<Self>, OffsetError> {
        if thickness == 0.0 {
            return Ok(Some(self.clone()));
        }
        if !self.is_convex() {
            return Err(OffsetError::NotConvex);
        }
        if let Some(round) = self.round() {
            let core = round.core(thickness).ok_or(OffsetError::NotConvex)?;
            return Ok(core.radius().is_some_and(|radius| radius > 0.0).then(|| Self::of_round(&core)));
        }
        let corners = plane_corners(self);
        // Most shells are thin: the centroid is well inside, and no search for a better centre is needed.
        let centroid = self.centroid();
        if let Some(points) = dual_points(&corners, &centroid, thickness) {
            return intersect(&corners, &centroid, thickness, &points).map(Some);
        }
        if clearly_vanishes(self, thickness) {
            return Ok(None);
        }
        match erosion(&corners, thickness) {
            Erosion::Nothing => Ok(None),
            Erosion::Around(center) => {
                let points = dual_points(&corners, &center, thickness).ok_or_else(lost)?;
                intersect(&corners, &center, thickness, &points).map(Some)
            }
        }
    }
}

/// Frames tried one after the other. Each divides the remaining slenderness by up to 1e15.
const FRAMES: usize = 4;

/// The body within the planes whose dual points about `center` are `points`.
fn intersect(corners: &[[Vec3; 3]], center: &Vec3, thickness: f64, points: &[Vec3]) -> Result<Polyhedron, OffsetError> {
    let mut dual = Dual::of(points)?;
    if let Some(body) = dual.body() {
        return placed(body, &dual, center, |v| *v, 1.0);
    }
    let mut frame = Frame::default();
    for _ in 0..FRAMES {
        frame = frame.around(&dual).ok_or_else(lost)?;
        dual = Dual::of(&frame.dual_points(corners, center, thickness).ok_or_else(lost)?)?;
        if let Some(body) = dual.body() {
            return placed(body, &dual, center, |v| frame.to_world(v), frame.volume());
        }
    }
    Err(lost())
}

/// The body about its centre in a frame, in the specimen's coordinates. It keeps its volume wherever it is; its
/// vertices must still show its shape.
fn placed(
    body: Polyhedron,
    dual: &Dual,
    center: &Vec3,
    to_world: impl Fn(&Vec3) -> Vec3,
    frame_volume: f64,
) -> Result<Polyhedron, OffsetError> {
    let length = dual.unit();
    let volume = body.volume() * length * length * length * frame_volume;
    let arm = |v: &Vec3| to_world(&(v * length));
    if !is_shown(&body, arm, center, 1e-3 * volume) {
        return Err(lost());
    }
    Ok(body.mapped_to_volume(|v| center + arm(v), volume))
}

/// True where the volume between faces whose corners err by half an ulp of the largest coordinates is below a limit:
/// along each axis, that times the faces seen along it. `arm` takes a vertex to its place about the centre: where
/// coordinates are rounded, a small body may have lost its faces.
fn is_shown(body: &Polyhedron, arm: impl Fn(&Vec3) -> Vec3, center: &Vec3, limit: f64) -> bool {
    let mut aabb = Aabb::empty();
    body.vertices().iter().for_each(|v| aabb.include(&arm(v)));
    let (largest, size) = ((center + aabb.min).abs().sup(&(center + aabb.max).abs()), aabb.size());
    // Along an axis one sees no more of a convex body than of its box, from either side: enough for most; rounding is
    // given a half.
    let sides = Vec3::new(size.y * size.z, size.z * size.x, size.x * size.y);
    if 1.5 * ROUNDING * largest.dot(&(sides * 2.0)) < limit {
        return true;
    }
    let at = |i: u32| arm(&body.vertices()[i as usize]);
    let seen: Vec3 = body.triangles().map(|[a, b, c]| (at(b) - at(a)).cross(&(at(c) - at(a))).abs() / 2.0).sum();
    ROUNDING * largest.dot(&seen) < limit
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

fn lost() -> OffsetError {
    ill_conditioned("what is left is too thin, or too small, for f64 numbers to show its shape there")
}

fn ill_conditioned(reason: &str) -> OffsetError {
    OffsetError::IllConditioned { reason: reason.to_owned() }
}

impl From<HullError> for OffsetError {
    fn from(_: HullError) -> Self {
        ill_conditioned("the planes, moved inwards, cannot be distinguished in f64")
    }
}
