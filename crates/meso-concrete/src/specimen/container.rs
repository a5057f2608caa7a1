//! The interface of every specimen's geometry.

use super::Largest;
use meso_collision::geometry::{BodyForm, TriangleMesh};
use meso_collision::math::{Aabb, Vec3};
use std::fmt::Debug;

/// Relative rounding of a gap or an extent.
const ROUNDING: f64 = 1e-13;

/// The closed region that a specimen encloses, in the specimen's frame.
#[allow(unused_variables, reason = "the defaults of most containers need no arguments")]
pub trait Container: Debug + Send + Sync {
    /// Bounding box, mm; it begins at the origin.
    fn aabb(&self) -> Aabb;

    /// Volume, mm3: analytic, or by the divergence theorem.
    fn volume(&self) -> f64;

    /// The narrowest distance between two parallel walls, or planes that enclose it, mm; infinite without walls.
    fn width(&self) -> f64;

    /// True when the hull of the vertices `body`, moved by `centre`, lies in the container with `gap` mm to its
    /// surface.
    ///
    /// Never true for a body that lies outside. Exact between planes without a gap. Gaps and curved walls need
    /// rounding: it errs by at most 1e-12 of the specimen's size, on the side of refusing.
    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool;

    /// True when a body of this form with these vertices, moved by `centre`, lies in the container with `gap` mm to its
    /// surface.
    ///
    /// A ball is its centre with a wider gap. An ellipsoid counts as its box in a box, elsewhere as 320 facets around it,
    /// up to 2 % of its size too wide.
    fn holds_body(&self, form: &BodyForm, vertices: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        let BodyForm::Round(round) = form else { return self.holds(vertices, centre, gap) };
        let centre = centre + round.centre();
        if let Some(radius) = round.radius() {
            return self.holds(&[Vec3::zeros()], &centre, (gap + radius) * (1.0 + ROUNDING));
        }
        if self.is_box() {
            let half = round.half_extents() * (1.0 + ROUNDING);
            return self.holds(&[-half, half], &centre, gap);
        }
        self.holds(&round.circumscribed(), &centre, gap)
    }

    /// Upper bounds on a body in the container.
    fn largest(&self) -> Largest {
        Largest { ball_radius: self.width() / 2.0, length: self.aabb().size().norm(), volume: self.volume() }
    }

    /// Share of the volume that lies more than `rim` mm inside the surface, roughly; `None` where the bounding box
    /// gives a good estimate.
    fn share_within(&self, rim: f64) -> Option<f64> {
        None
    }

    /// Distance from `point` to the surface, mm; negative outside, where only the sign is certain. Infinite where there
    /// is no surface.
    fn depth(&self, point: &Vec3) -> f64;

    /// True when `point` is inside and at least `distance` mm from the surface.
    fn is_clear(&self, point: &Vec3, distance: f64) -> bool {
        self.depth(point) >= distance
    }

    /// True when the closed container holds `point`.
    fn contains(&self, point: &Vec3) -> bool {
        self.depth(point) >= 0.0
    }

    /// Convex bodies around the container whose boxes meet `near`; no grain inside meets them.
    fn obstacles(&self, near: &Aabb) -> Vec<Obstacle<'_>> {
        Vec::new()
    }

    /// True where the segment between any two points inside lies inside.
    fn is_convex(&self) -> bool {
        true
    }

    /// True for boxes: their walls are those of the bounding box.
    fn is_box(&self) -> bool {
        false
    }

    /// One step of the centre of the hull of `body` (about its centre, inside the bounding box) towards `gap` mm
    /// inside the other walls; `centre` itself where that is fulfilled.
    fn confine(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> Vec3 {
        *centre
    }

    /// The surface as polygons, for pictures and for cutting: exact for planes, within 1e-3 of the size of curved
    /// walls.
    fn surface(&self) -> Surface;
}

/// A convex body outside the container.
#[derive(Clone, Copy, Debug)]
pub struct Obstacle<'a> {
    /// Points of the surface, mm.
    pub points: &'a [Vec3],
    /// Unit normals out of the container, its own first: grains are pushed against these alone. Empty where any
    /// direction is allowed.
    ///
    /// The shortest push off a single triangle of a wall leads along the wall, onto the next triangle, and back. So
    /// only its own normal counts, and those of the walls behind a reentrant edge.
    pub outward: &'a [Vec3],
}

/// A closed surface of polygons, counter-clockwise from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Corners of the surface, mm.
    pub points: Vec<Vec3>,
    /// Convex polygons as indices of points.
    pub faces: Vec<Vec<u32>>,
}

impl Surface {
    /// Volume inside the surface, mm3.
    pub fn volume(&self) -> f64 {
        TriangleMesh { vertices: self.points.clone(), triangles: self.triangles().collect() }.volume()
    }

    /// The polygons cut into triangles, fan-wise.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.faces.iter().flat_map(|face| (2..face.len()).map(|k| [face[0], face[k - 1], face[k]]))
    }
}

/// Segments around a circle in pictures: chords within 3e-4 of the radius.
const SEGMENTS: u32 = 128;

/// A ring of points about the z axis at (`x`, `y`) = (`middle`, `middle`).
pub(super) fn ring(middle: f64, radius: f64, z: f64) -> impl Iterator<Item = Vec3> {
    (0..SEGMENTS).map(move |i| {
        let angle = f64::from(i) * (std::f64::consts::TAU / f64::from(SEGMENTS));
        Vec3::new(middle + radius * libm::cos(angle), middle + radius * libm::sin(angle), z)
    })
}

/// The faces of stacked rings from the bottom to the top, closed by a polygon at each end.
pub(super) fn stack(rings: u32) -> Vec<Vec<u32>> {
    let n = SEGMENTS;
    let mut faces = vec![(0..n).rev().collect(), ((rings - 1) * n..rings * n).collect()];
    for ring in 1..rings {
        let (below, above) = ((ring - 1) * n, ring * n);
        faces.extend((0..n).map(|i| (i, (i + 1) % n)).map(|(i, j)| vec![below + i, below + j, above + j, above + i]));
    }
    faces
}

/// Pulls in a body whose farthest vertex is more than `reach` from an axis or a centre, by the excess.
pub(super) fn pull_in(body: &[Vec3], centre: &Vec3, reach: f64, arm: impl Fn(&Vec3) -> Vec3) -> Vec3 {
    let arms = body.iter().map(|v| arm(&(v + centre)));
    let (farthest, length2) = arms
        .map(|arm| (arm, arm.norm_squared()))
        .fold((Vec3::zeros(), 0.0), |best, next| if next.1 > best.1 { next } else { best });
    if length2 <= reach * reach {
        return *centre;
    }
    let length = length2.sqrt();
    centre - farthest * ((length - reach) / length)
}
