//! The inner side of a shell on a body with dents, as a surface of as many triangles.

use crate::geometry::Polyhedron;
use crate::math::{Mat3, Vec3};

/// Damps corners whose faces are nearly plane; what it leaves after all steps is 1e-6 of the thickness where faces lie 10
/// degrees apart.
const DAMPING: f64 = 1e-3;
const STEPS: usize = 30;
/// Largest difference of a corner's depth from the thickness, root mean square over all corners, as a share of it.
const MOST_OFF: f64 = 0.1;

impl Polyhedron {
    /// The body with dents whose faces lie `thickness` mm deeper: each corner goes to where the moved planes of its faces
    /// meet. `None` where depths of the corners differ from the thickness by more than a tenth, root mean square, as they
    /// do where the body is thinner than two shells.
    ///
    /// Points deeper than the thickness would end in a round along the bottom of a dent; here the faces go on until they
    /// meet.
    pub fn inset(&self, thickness: f64) -> Option<Self> {
        let inner = self.moved_inwards(thickness);
        let is_near = self.off(&inner, |depth| depth / thickness - 1.0) <= MOST_OFF;
        (is_near && inner.volume() > 0.0).then_some(inner)
    }

    /// Whether a body with dents has parts thinner than two shells of `thickness` mm: corners that move inwards come out too
    /// near to the other side, by more than a tenth of the thickness, root mean square over all corners.
    pub fn is_thin(&self, thickness: f64) -> bool {
        let inner = self.moved_inwards(thickness);
        self.off(&inner, |depth| (depth / thickness - 1.0).min(0.0)) > MOST_OFF
    }

    /// Each corner where its faces meet that are moved `thickness` mm inwards.
    fn moved_inwards(&self, thickness: f64) -> Self {
        let mut around: Vec<Vec<Vec3>> = vec![Vec::new(); self.vertices().len()];
        for (triangle, plane) in self.triangles().zip(self.planes()) {
            triangle.iter().for_each(|&corner| around[corner as usize].push(plane.normal));
        }
        let moved = self.vertices().iter().zip(&around).map(|(vertex, normals)| vertex + inward(normals, thickness));
        Self::from_parts(moved.collect(), self.triangles()).with_dents()
    }

    /// Root mean square over the corners of `inner` of what `of` makes of their depths in this body.
    fn off(&self, inner: &Self, of: impl Fn(f64) -> f64) -> f64 {
        let surface = self.surface();
        let squares = inner.vertices().iter().map(|corner| of(surface.depth(corner)).powi(2));
        (squares.sum::<f64>() / inner.vertices().len() as f64).sqrt()
    }
}

/// The displacement of a corner that brings it `thickness` below the planes of its faces, least squares.
fn inward(normals: &[Vec3], thickness: f64) -> Vec3 {
    let damped = normals.iter().map(|n| n * n.transpose()).sum::<Mat3>() + Mat3::identity() * DAMPING;
    let mut moved = normals.iter().sum::<Vec3>().try_normalize(0.0).unwrap_or_default() * -thickness;
    let Some(inverse) = damped.try_inverse() else { return moved };
    for _ in 0..STEPS {
        moved -= inverse * normals.iter().map(|n| n * (thickness + n.dot(&moved))).sum::<Vec3>();
    }
    moved
}
