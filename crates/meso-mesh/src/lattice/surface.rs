//! A body's surface as the fit needs it: edges and corners near a point, and steps along a face.

use crate::cells::NO_BODY;
use crate::tet::TetMesh;
use meso_collision::geometry::{Plane, Polyhedron, Round, nearest_on_triangle};
use meso_collision::math::Vec3;

/// Sine of the angle below which planes count as parallel.
const PARALLEL: f64 = 1e-3;

/// Faces, edges and corners of a body.
pub(super) struct Surface {
    planes: Vec<Plane>,
    /// The triangle in each plane of a body with dents, beyond which the plane is no part of the surface.
    triangles: Vec<[Vec3; 3]>,
    edges: Vec<Edge>,
    corners: Vec<Vec3>,
    /// mm3.
    pub(super) volume: f64,
    /// Points this far from a plane count as on it, mm.
    slack: f64,
    /// A ball or an ellipsoid, without faces, edges and corners.
    round: Option<Round>,
}

/// An edge of a body.
struct Edge {
    start: Vec3,
    along: Vec3,
    /// `along` over its squared length.
    measure: Vec3,
}

impl Edge {
    fn new([a, b]: [Vec3; 2]) -> Self {
        let along = b - a;
        Self { start: a, along, measure: along / along.norm_squared() }
    }
}

impl Surface {
    pub(super) fn new(body: &Polyhedron) -> Self {
        let (volume, slack) = (body.volume(), SLACK * body.aabb().size().max());
        if let Some(round) = body.round() {
            let (planes, triangles, edges, corners) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            return Self { planes, triangles, edges, corners, volume, slack, round: Some(round) };
        }
        let at = |i: u32| body.vertices()[i as usize];
        let mut edges = Vec::new();
        for face in body.faces() {
            let face: Vec<u32> = face.iter().collect();
            for i in 0..face.len() {
                let (a, b) = (face[i], face[(i + 1) % face.len()]);
                if a < b {
                    edges.push([a, b]);
                }
            }
        }
        Self {
            planes: body.planes().collect(),
            triangles: if body.is_convex() { Vec::new() } else { body.triangles().map(|t| t.map(at)).collect() },
            edges: edges.into_iter().map(|edge| Edge::new(edge.map(at))).collect(),
            corners: body.vertices().to_vec(),
            volume,
            slack,
            round: None,
        }
    }

    /// Calls `visit` with the corners and the nearest points of the edges within `reach` of `x`.
    pub(super) fn features_near(&self, x: &Vec3, reach: f64, mut visit: impl FnMut(Vec3)) {
        let near = |p: &Vec3| (p - x).norm_squared() < reach * reach;
        self.corners.iter().filter(|corner| near(corner)).for_each(|corner| visit(*corner));
        for edge in &self.edges {
            let t = (x - edge.start).dot(&edge.measure);
            if t > 0.0 && t < 1.0 {
                let position = edge.start + edge.along * t;
                if near(&position) {
                    visit(position);
                }
            }
        }
    }

    /// `x` after the part of `step` that lies in all the faces at `x`, or `None` where that leaves the faces.
    pub(super) fn along_face(&self, x: &Vec3, step: &Vec3) -> Option<Vec3> {
        if let Some(round) = &self.round {
            let normal = round.normal(x);
            return self.has(x).then(|| round.nearest(&(x + step - normal * normal.dot(step))));
        }
        let at = self.faces_at(x);
        let step = match at[..] {
            [(_, plane)] => step - plane.normal * plane.normal.dot(step),
            [(_, first), (_, second)] => {
                let edge = first.normal.cross(&second.normal).normalize();
                edge * edge.dot(step)
            }
            _ => return None,
        };
        let position = x + step;
        (self.holds(&position) && at.iter().all(|(face, _)| self.is_on(*face, &position))).then_some(position)
    }

    /// Projects a point within the planes through `x` across `axes`, too.
    pub(super) fn along_face_within(&self, x: &Vec3, step: &Vec3, axes: [bool; 3]) -> Option<Vec3> {
        if let Some(round) = &self.round {
            return if self.has(x) { nearest_in_planes(round, &(x + step), axes, self.slack) } else { None };
        }
        let at = self.faces_at(x);
        let mut normals: Vec<Vec3> = (0..3).filter(|i| axes[*i]).map(|i| Vec3::ith(i, 1.0)).collect();
        normals.extend(at.iter().map(|(_, plane)| plane.normal));
        let &[first, second] = normals.as_slice() else { return None };
        let edge = first.cross(&second).try_normalize(PARALLEL)?;
        let position = x + edge * edge.dot(step);
        (self.holds(&position) && at.iter().all(|(face, _)| self.is_on(*face, &position))).then_some(position)
    }

    /// Calls `visit` with the positions nearest to `x` on the faces, and with the edges, within the planes through `x` across
    /// `axes`, as far as these are within `reach`.
    pub(super) fn nearest_within(&self, x: &Vec3, axes: [bool; 3], reach: f64, mut visit: impl FnMut(Vec3)) {
        if let Some(round) = &self.round {
            let position = nearest_in_planes(round, x, axes, self.slack);
            return position.filter(|position| (position - x).norm() < reach).into_iter().for_each(visit);
        }
        for (face, plane) in self.planes.iter().enumerate() {
            let direction = Vec3::from_fn(|i, _| if axes[i] { 0.0 } else { plane.normal[i] });
            let step = direction * ((plane.offset - plane.normal.dot(x)) / direction.norm_squared());
            if direction.norm() > PARALLEL && step.norm() < reach && self.face_has(face, &(x + step)) {
                visit(x + step);
            }
        }
        let Some(axis) = (0..3).find(|i| axes[*i]).filter(|_| axes.iter().filter(|held| **held).count() == 1) else {
            return;
        };
        for edge in &self.edges {
            let t = (x[axis] - edge.start[axis]) / edge.along[axis];
            let position = edge.start + edge.along * t;
            if (0.0..=1.0).contains(&t) && (position - x).norm() < reach {
                visit(Vec3::from_fn(|i, _| if axes[i] { x[i] } else { position[i] }));
            }
        }
    }

    /// Calls `visit` with the feet of the perpendiculars from `x` to the faces, as far as these are within `reach`.
    pub(super) fn feet_near(&self, x: &Vec3, reach: f64, mut visit: impl FnMut(Vec3)) {
        if let Some(round) = &self.round {
            let foot = round.nearest(x);
            if (foot - x).norm() < reach {
                visit(foot);
            }
            return;
        }
        for (face, plane) in self.planes.iter().enumerate() {
            let height = plane.height(x);
            let foot = x - plane.normal * height;
            if height.abs() < reach && self.face_has(face, &foot) {
                visit(foot);
            }
        }
    }

    /// Whether `x` lies on the surface.
    pub(super) fn has(&self, x: &Vec3) -> bool {
        if let Some(round) = &self.round {
            return round.height(x).abs() <= self.slack;
        }
        (0..self.planes.len()).any(|face| self.is_on(face, x)) && self.holds(x)
    }

    /// Whether `x` lies in the closed convex body. The faces of a body with dents bound themselves.
    fn holds(&self, x: &Vec3) -> bool {
        !self.triangles.is_empty() || self.planes.iter().all(|p| p.normal.dot(x) <= p.offset + self.slack)
    }

    /// The faces at `x`, by their numbers and planes.
    fn faces_at(&self, x: &Vec3) -> Vec<(usize, &Plane)> {
        self.planes.iter().enumerate().filter(|(face, _)| self.is_on(*face, x)).collect()
    }

    /// Whether `x` lies on a face, or on its plane where that bounds a convex body.
    fn is_on(&self, face: usize, x: &Vec3) -> bool {
        self.planes[face].height(x).abs() <= self.slack && self.triangle_has(face, x)
    }

    /// Whether a point of the plane of a face lies on the body's surface.
    fn face_has(&self, face: usize, x: &Vec3) -> bool {
        self.holds(x) && self.triangle_has(face, x)
    }

    /// Whether `x` lies in the triangle of a body with dents.
    fn triangle_has(&self, face: usize, x: &Vec3) -> bool {
        self.triangles.get(face).is_none_or(|triangle| (nearest_on_triangle(triangle, x) - x).norm() <= self.slack)
    }
}

/// The position on a ball or an ellipsoid near `x` in the planes through `x` across `axes`; `None` where they miss it.
///
/// Steps along the gradient within the planes, each to the surface.
fn nearest_in_planes(round: &Round, x: &Vec3, axes: [bool; 3], slack: f64) -> Option<Vec3> {
    let mut position = *x;
    for _ in 0..STEPS {
        let normal = round.normal(&position);
        let way = Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { normal[axis] });
        let way = way.try_normalize(PARALLEL)?;
        let (from, to) = round.chord(&position, &way)?;
        let step = if from.abs() < to.abs() { from } else { to };
        position += way * step;
        if step.abs() <= slack {
            return Some(position);
        }
    }
    None
}

/// Most steps to a position in a plane.
const STEPS: usize = 20;

/// Share of a body's size that counts as none.
const SLACK: f64 = 1e-9;

/// A body that lacks this share of its volume, or more, counts in full.
const FULL: f64 = 0.02;

/// How much every body's tetrahedra lack of its volume: 1 for [`FULL`] of it or more, -1 for as much too much.
pub(super) fn volume_deficits(mesh: &TetMesh, surfaces: &[Surface]) -> Vec<f64> {
    let mut volumes = vec![0.0; surfaces.len()];
    for cell in mesh.numbers().filter(|&cell| mesh.owner[cell as usize] != NO_BODY) {
        volumes[mesh.owner[cell as usize] as usize] += mesh.volume(cell);
    }
    let deficit = |(surface, volume): (&Surface, f64)| (1.0 - volume / surface.volume) / FULL;
    surfaces.iter().zip(volumes).map(|pair| deficit(pair).clamp(-1.0, 1.0)).collect()
}
