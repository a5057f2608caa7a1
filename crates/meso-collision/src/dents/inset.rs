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
        let is_near = self.off(&inner, thickness, |depth| depth / thickness - 1.0) <= MOST_OFF;
        (is_near && inner.body.volume() > 0.0).then_some(inner.body)
    }

    /// Whether a body with dents has parts thinner than two shells of `thickness` mm: corners that move inwards come out too
    /// near to the other side, by more than a tenth of the thickness, root mean square over all corners.
    pub fn is_thin(&self, thickness: f64) -> bool {
        let inner = self.moved_inwards(thickness);
        let is_kept = self.off(&inner, thickness, |depth| (depth / thickness - 1.0).min(0.0)) <= MOST_OFF;
        !is_kept
    }

    /// Each corner where the faces of its skin meet that are moved `thickness` mm inwards; corners of caps stay in their planes.
    fn moved_inwards(&self, thickness: f64) -> Inner {
        let (cuts, mut around) = (self.cuts(), vec![Vec::new(); self.vertices().len()]);
        for ((triangle, plane), corners) in self.triangles().zip(self.planes()).zip(self.corners()) {
            if cuts.is_some_and(|cuts| cuts.cap(&corners)) {
                continue;
            }
            for (number, corner) in triangle.into_iter().zip(corners) {
                let slope = cuts.map_or(plane.normal, |cuts| cuts.along(&corner, &plane.normal));
                around[number as usize].push(slope);
            }
        }
        let moved = self.vertices().iter().zip(&around).map(|(vertex, normals)| vertex + inward(normals, thickness));
        let mut body = Self::from_parts(moved.collect(), self.triangles());
        body.set_caps(self.caps());
        Inner { body, is_below_skin: around.iter().map(|normals| !normals.is_empty()).collect() }
    }

    /// Root mean square of what `of` makes of the depths in this body of the corners of `inner` below its skin.
    fn off(&self, inner: &Inner, thickness: f64, of: impl Fn(f64) -> f64) -> f64 {
        let skin = self.skin(thickness);
        let corners = inner.body.vertices().iter().zip(&inner.is_below_skin).filter(|(_, is_below)| **is_below);
        let squares = corners.clone().map(|(corner, _)| of(skin.depth(corner)).powi(2));
        (squares.sum::<f64>() / corners.count() as f64).sqrt()
    }
}

/// The inner side of a shell.
struct Inner {
    body: Polyhedron,
    /// The corners that faces of the skin have; others lie in caps.
    is_below_skin: Vec<bool>,
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
