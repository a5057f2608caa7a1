//! Spheres. A body is inside when all its vertices are: the sphere is convex.

use super::container::{self, Container, Surface};
use meso_collision::math::{Aabb, Vec3};

/// A sphere that touches the three coordinate planes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sphere {
    radius: f64,
}

/// As for the cylinder, with one square and one sum more.
const ROUNDING: f64 = 10.0 * f64::EPSILON;

/// Rings of a picture's sphere between its poles.
const RINGS: u32 = 63;

impl Sphere {
    pub(super) fn new(diameter: f64) -> Self {
        Self { radius: diameter / 2.0 }
    }

    fn arm(&self, point: &Vec3) -> Vec3 {
        point - Vec3::repeat(self.radius)
    }
}

impl Container for Sphere {
    fn aabb(&self) -> Aabb {
        Aabb { min: Vec3::zeros(), max: Vec3::repeat(2.0 * self.radius) }
    }

    fn volume(&self) -> f64 {
        std::f64::consts::PI * 4.0 / 3.0 * self.radius * self.radius * self.radius
    }

    fn width(&self) -> f64 {
        2.0 * self.radius
    }

    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        let reach = (self.radius - gap).max(0.0);
        let most = reach * reach * (1.0 - ROUNDING);
        body.iter().all(|v| self.arm(&(v + centre)).norm_squared() <= most)
    }

    fn depth(&self, point: &Vec3) -> f64 {
        self.radius - self.arm(point).norm()
    }

    fn confine(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> Vec3 {
        container::pull_in(body, centre, self.radius - gap, |point| self.arm(point))
    }

    /// Rings from pole to pole; the poles themselves are small polygons.
    fn surface(&self) -> Surface {
        let rings = (1..=RINGS).map(|ring| f64::from(ring) / f64::from(RINGS + 1) * std::f64::consts::PI);
        let points = rings.flat_map(|polar| {
            let z = self.radius - self.radius * libm::cos(polar);
            container::ring(self.radius, self.radius * libm::sin(polar), z)
        });
        Surface { points: points.collect(), faces: container::stack(RINGS) }
    }
}
