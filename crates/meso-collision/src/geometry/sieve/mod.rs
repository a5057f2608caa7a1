//! The sieve size: the side of the smallest square hole that a body passes, over all directions.
//!
//! A body passes a square hole along a direction if its projection fits into the square. The sides of the square are two
//! orthogonal unit vectors u and v, and the body must be at most s wide along both. So the size is the least s for which
//! the set A(s) of directions in which the body is at most s wide holds two orthogonal directions.
//!
//! 1. A projection along the body gives a first side s.
//! 2. The width along u is the largest (p - q) . u over pairs of vertices. Each pair excludes a round cap from A(s), so
//!    its components have concave sides, and u . v over two components is extreme at corners or at u = v. Corners lie where
//!    two pairs have equal widths: on the arcs of the Gauss map, along which an edge is outermost. So A(s) holds orthogonal
//!    directions if and only if two arcs do within A(s).
//! 3. On an arc A(s) consists of a few pieces. Signs of the dot products of their ends decide for two pieces, since a dot
//!    product is bilinear.
//! 4. Each pair of arcs that holds orthogonal directions below s gets its own least side, which becomes s.

mod arcs;
mod search;

use crate::geometry::{BodyForm, Polyhedron};
use crate::simd::dispatch;

/// Relative bound on the difference between a sieve size and the least side over all directions.
pub(crate) const SLACK: f64 = 1e-9;

impl Polyhedron {
    /// Side of the smallest square hole that the body passes, mm, in the best direction.
    ///
    /// The number is at most 1e-9 of itself above the true minimum, and a turned copy has the same size within that bound.
    ///
    /// ```
    /// use meso_collision::geometry::convex_hull;
    /// use meso_collision::math::Vec3;
    /// let cube: Vec<Vec3> = (0..8).map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2))).collect();
    /// assert!((convex_hull(&cube)?.sieve_size() - 1.0).abs() < 1e-9);
    /// # Ok::<(), meso_collision::geometry::HullError>(())
    /// ```
    ///
    /// A sieve meets the hull of a body with dents only.
    pub fn sieve_size(&self) -> f64 {
        match self.form() {
            BodyForm::Hull => dispatch(search::Smallest { body: self }),
            BodyForm::Round(round) => round.sieve_size(),
            BodyForm::Surface => self.hull().map_or(0.0, |hull| hull.sieve_size()),
        }
    }
}
