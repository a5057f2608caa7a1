//! Convex polyhedra: a body is inside when all its vertices are on the inner side of all faces, by exact signs.

use super::at_origin;
use super::container::{Container, Surface};
use meso_collision::geometry::{Face, HullError, Plane, Polyhedron, convex_hull, orient3d};
use meso_collision::math::{Aabb, Vec3};

/// A convex polyhedron.
#[derive(Clone, Debug)]
pub(super) struct Convex {
    body: Polyhedron,
    planes: Vec<Plane>,
    /// Three corners of every face, counter-clockwise from outside.
    corners: Vec<[Vec3; 3]>,
    /// Signed distances from every plane err by less, mm.
    rounding: Vec<f64>,
}

impl Convex {
    /// The hull of `points`, moved to the origin.
    pub(super) fn hull(points: &[[f64; 3]]) -> Result<Self, HullError> {
        Ok(Self::new(convex_hull(&at_origin(points))?))
    }

    pub(super) fn new(body: Polyhedron) -> Self {
        let corners = body.faces().map(|face| [0, 1, 2].map(|k| body.vertices()[face.vertex(k) as usize])).collect();
        // A unit normal errs by some roundings of the size squared over the face's area: much for needles.
        let size = body.aabb().size().norm();
        let rounding = |area: f64| 32.0 * f64::EPSILON * size * (1.0 + size * size / area);
        let rounding = body.faces().map(|face| rounding(area(&body, face))).collect();
        Self { planes: body.planes().collect(), corners, body, rounding }
    }

    /// True when `point` is at least `gap` mm inside face `f`.
    fn is_inside(&self, f: usize, point: &Vec3, gap: f64) -> bool {
        let plane = &self.planes[f];
        let depth = plane.offset - plane.normal.dot(point);
        if gap > 0.0 || depth.abs() > self.rounding[f] {
            return depth >= gap + if gap > 0.0 { self.rounding[f] } else { 0.0 };
        }
        let [a, b, c] = &self.corners[f];
        orient3d(a, b, c, point) <= 0.0
    }
}

impl Container for Convex {
    fn aabb(&self) -> Aabb {
        self.body.aabb()
    }

    fn volume(&self) -> f64 {
        self.body.volume()
    }

    /// The least extent across a face.
    fn width(&self) -> f64 {
        let lowest = |normal: &Vec3| self.body.vertices().iter().map(|v| normal.dot(v)).fold(f64::INFINITY, f64::min);
        let extents = self.planes.iter().map(|plane| plane.offset - lowest(&plane.normal));
        extents.fold(f64::INFINITY, f64::min)
    }

    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        (0..self.planes.len()).all(|f| body.iter().all(|v| self.is_inside(f, &(v + centre), gap)))
    }

    fn depth(&self, point: &Vec3) -> f64 {
        self.planes.iter().map(|plane| plane.offset - plane.normal.dot(point)).fold(f64::INFINITY, f64::min)
    }

    /// Out of every plane in turn.
    fn confine(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> Vec3 {
        let mut inside = *centre;
        for (plane, rounding) in self.planes.iter().zip(&self.rounding) {
            let highest = body.iter().map(|v| plane.normal.dot(v)).fold(f64::NEG_INFINITY, f64::max);
            let excess = highest + plane.normal.dot(&inside) - (plane.offset - gap - rounding);
            if excess > 0.0 {
                inside -= plane.normal * excess;
            }
        }
        inside
    }

    fn surface(&self) -> Surface {
        Surface { points: self.body.vertices().to_vec(), faces: self.body.faces().map(|face| face.to_vec()).collect() }
    }
}

/// Area of a face, mm2.
fn area(body: &Polyhedron, face: Face) -> f64 {
    let cross = face.triangles().map(|t| {
        let [a, b, c] = t.map(|i| body.vertices()[i as usize]);
        (b - a).cross(&(c - a))
    });
    cross.sum::<Vec3>().norm() / 2.0
}
