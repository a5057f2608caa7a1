//! The ellipsoid an aggregate's vertices lie on (Sec. 2.1).

use crate::math::Vec3;

/// Semi-axes a >= b >= c along x, y, z, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Semi-axes, mm.
    pub semi_axes: Vec3,
}

impl Ellipsoid {
    /// The surface point at longitude `theta` from the x axis and polar angle `phi` from the z axis, radians.
    pub fn point(&self, theta: f64, phi: f64) -> Vec3 {
        let ((across, along), (y, x)) = (libm::sincos(phi), libm::sincos(theta));
        let direction = Vec3::new(across * x, across * y, along);
        self.semi_axes.component_mul(&direction)
    }
}
