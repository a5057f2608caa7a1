//! Questions about bodies that may have dents, which the convex answers do not reach.

use crate::geometry::{Plane, Polyhedron};
use crate::gjk::{self, GjkError};
use crate::math::Vec3;

impl Polyhedron {
    /// How far `x` is from the body, mm, negative inside: beyond the farthest face plane, which is less than the distance
    /// where an edge or corner is nearest; the distance itself where the body has dents.
    pub fn height(&self, x: &Vec3) -> f64 {
        if self.is_convex() { Plane::height_over(self.planes(), x) } else { -self.surface().depth(x) }
    }

    /// Distance of two bodies, mm; 0 where they share a point.
    ///
    /// # Errors
    /// Coordinates that are not finite.
    pub fn distance(&self, other: &Self) -> Result<f64, GjkError> {
        if self.is_convex() && other.is_convex() {
            return gjk::distance(self.vertices(), other.vertices());
        }
        let of_corners =
            self.vertices().iter().flat_map(|v| other.vertices().iter().map(move |w| (v - w).norm_squared()));
        let most = of_corners.fold(f64::INFINITY, f64::min).sqrt();
        Ok(self.surface().distance_below(&other.surface(), most))
    }

    /// True where two bodies are more than `gap` mm apart.
    ///
    /// # Errors
    /// Coordinates that are not finite.
    pub fn is_farther(&self, other: &Self, gap: f64) -> Result<bool, GjkError> {
        let hulls = gjk::distance_exceeds(self.vertices(), other.vertices(), gap)?;
        let has_dents = !(self.is_convex() && other.is_convex());
        Ok(hulls || has_dents && self.surface().is_apart(&other.surface(), gap))
    }
}
