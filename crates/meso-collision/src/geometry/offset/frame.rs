//! An affine frame in which a slender body is round: its axes are edges between vertices that are far apart.
//!
//! A plane y . x = 1 about the centre is (A^T y) . z = 1 for x = A z, and volumes are multiplied by det A.

use super::dual::Dual;
use super::planes::exact_point_in;
use crate::geometry::exact::integer;
use crate::math::Vec3;

/// The columns of A: the frame's axes in the specimen's coordinates, mm.
pub(super) struct Frame([Vec3; 3]);

impl Default for Frame {
    /// The specimen's own.
    fn default() -> Self {
        Self([Vec3::x(), Vec3::y(), Vec3::z()])
    }
}

impl Frame {
    /// The next frame: along three edges of a large tetrahedron among the vertices that `dual` has in this one. `None` where
    /// f64 edges span no volume.
    pub(super) fn around(&self, dual: &Dual) -> Option<Self> {
        let edges = far_edges(dual.vertices()).map(|edge| self.to_world(&(edge * dual.unit())));
        let [u, v, w] = edges;
        let volume = Self(edges).volume();
        let frame = if volume < 0.0 { Self([v, u, w]) } else { Self(edges) };
        (volume != 0.0 && volume.is_finite()).then_some(frame)
    }

    /// The dual points of the planes through `corners`, moved inwards, in this frame.
    pub(super) fn dual_points(&self, corners: &[[Vec3; 3]], center: &Vec3, thickness: f64) -> Option<Vec<Vec3>> {
        corners.iter().map(|triangle| exact_point_in(&self.0, triangle, center, thickness)).collect()
    }

    pub(super) fn to_world(&self, v: &Vec3) -> Vec3 {
        self.0[0] * v.x + self.0[1] * v.y + self.0[2] * v.z
    }

    /// det A, mm3, rounded once.
    pub(super) fn volume(&self) -> f64 {
        let unit = integer::unit_exponent(self.0.iter().flat_map(|p| [p.x, p.y, p.z]));
        let [u, v, w] = self.0.map(|axis| integer::to_integers(&axis, unit));
        integer::quotient(&integer::dot(&u, &integer::cross(&v, &w)), &1.into(), 3 * unit)
    }
}

/// From the first vertex to the farthest, from there to the one farthest from that line, and to the one farthest from that
/// plane.
fn far_edges(vertices: &[Vec3]) -> [Vec3; 3] {
    let farthest = |measure: &dyn Fn(&Vec3) -> f64| {
        let far = vertices.iter().max_by(|p, q| measure(p).total_cmp(&measure(q)));
        *far.expect("a body has vertices")
    };
    let a = farthest(&|p| p.norm_squared());
    let u = farthest(&|p| (p - a).norm_squared()) - a;
    let v = farthest(&|p| u.cross(&(p - a)).norm_squared()) - a;
    let normal = u.cross(&v);
    let w = farthest(&|p| normal.dot(&(p - a)).abs()) - a;
    [u, v, w]
}
