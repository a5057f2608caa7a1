//! Upright cylinders. A body is inside when all its vertices are: the cylinder is convex.

use super::container::{self, Container, Surface};
use meso_collision::math::{Aabb, Vec3};

/// A cylinder about an axis parallel to z, standing on z = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cylinder {
    radius: f64,
    height: f64,
}

/// Relative error of a squared distance from the axis: four roundings, of the squares and the sum, and a little for
/// those of the radius.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Cylinder {
    pub(super) fn new(diameter: f64, height: f64) -> Self {
        Self { radius: diameter / 2.0, height }
    }

    /// From the axis to `point`, mm.
    fn arm(&self, point: &Vec3) -> Vec3 {
        Vec3::new(point.x - self.radius, point.y - self.radius, 0.0)
    }
}

impl Container for Cylinder {
    fn aabb(&self) -> Aabb {
        Aabb { min: Vec3::zeros(), max: Vec3::new(2.0 * self.radius, 2.0 * self.radius, self.height) }
    }

    fn volume(&self) -> f64 {
        std::f64::consts::PI * self.radius * self.radius * self.height
    }

    fn width(&self) -> f64 {
        self.height.min(2.0 * self.radius)
    }

    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        let reach = (self.radius - gap).max(0.0);
        let most = reach * reach * (1.0 - ROUNDING);
        body.iter().all(|v| {
            let point = v + centre;
            self.arm(&point).norm_squared() <= most && point.z >= gap && point.z <= self.height - gap
        })
    }

    fn depth(&self, point: &Vec3) -> f64 {
        (self.radius - self.arm(point).norm()).min(point.z).min(self.height - point.z)
    }

    fn confine(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> Vec3 {
        container::pull_in(body, centre, self.radius - gap, |point| self.arm(point))
    }

    fn surface(&self) -> Surface {
        let points = [0.0, self.height].into_iter().flat_map(|z| container::ring(self.radius, self.radius, z));
        Surface { points: points.collect(), faces: container::stack(2) }
    }
}
