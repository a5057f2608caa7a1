//! The faces of a periodic box as triangles, one and the same on both sides.
//!
//! The lower face of each axis is triangulated with the rims of the cut grains in it (a constrained Delaunay
//! triangulation, refined by Ruppert's algorithm, rims and sides kept), and moved by the period it is the upper one.

use super::facets::halved;
use super::pieces::{Piece, snap};
use crate::math::{Aabb, Vec3};
use spade::handles::FixedVertexHandle;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};
use std::collections::BTreeMap;

/// The refinement stops at circumradii of this many shortest edges: angles of 24.6 degrees, where rims allow them.
const RADIUS_PER_EDGE: f64 = 1.2;

/// A lower face: its triangles counter-clockwise seen from above, each with the piece whose cap it is part of.
pub(super) struct Face {
    pub(super) points: Vec<Vec3>,
    pub(super) triangles: Vec<([u32; 3], Option<usize>)>,
}

/// The lower face of `domain` across `axis`, cut by `pieces`; no edge in it is longer than `limit` mm by much.
///
/// # Errors
/// Says which rims cross: of disjoint grains none do.
pub(super) fn lower(axis: usize, domain: &Aabb, pieces: &[Piece], limit: f64) -> Result<Face, String> {
    let mut plane = Plane { axis, domain, cdt: ConstrainedDelaunayTriangulation::new(), points: Vec::new() };
    let caps: Vec<(usize, Vec<Vec3>)> = caps(axis, pieces).collect();
    for (from, to) in plane.sides(&caps) {
        plane.keep(&halved(from, to, limit))?;
    }
    for (_, corners) in &caps {
        for (from, to) in edges(corners) {
            // What grains have of the sides is among their parts.
            if !plane.is_on_a_side(&from, &to) {
                plane.keep(&halved(from, to, limit))?;
            }
        }
    }
    // Before the refinement: its nodes are none of the rims'.
    let inside: Vec<(usize, [FixedVertexHandle; 2])> =
        caps.iter().map(|(piece, corners)| (*piece, plane.rim(corners, limit))).collect();
    plane.refine(limit);
    plane.face(&inside)
}

/// The caps on the lower face of `axis` with their pieces.
fn caps(axis: usize, pieces: &[Piece]) -> impl Iterator<Item = (usize, Vec<Vec3>)> {
    pieces.iter().enumerate().flat_map(move |(index, piece)| {
        let here = piece.caps.iter().filter(move |cap| (cap.0, cap.1) == (axis, false));
        here.map(move |cap| (index, cap.2.iter().map(|&corner| piece.points[corner as usize]).collect()))
    })
}

fn edges(corners: &[Vec3]) -> impl Iterator<Item = (Vec3, Vec3)> {
    (0..corners.len()).map(|k| (corners[k], corners[(k + 1) % corners.len()]))
}

/// A face in the making.
struct Plane<'a> {
    axis: usize,
    domain: &'a Aabb,
    cdt: ConstrainedDelaunayTriangulation<Point2<f64>>,
    /// By the vertices' numbers.
    points: Vec<Vec3>,
}

impl Plane<'_> {
    fn in_plane(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    fn is_on_a_side(&self, from: &Vec3, to: &Vec3) -> bool {
        let both = |axis: usize, place: f64| from[axis] == place && to[axis] == place;
        self.in_plane().into_iter().any(|axis| both(axis, self.domain.min[axis]) || both(axis, self.domain.max[axis]))
    }

    /// The parts of the face's four sides between the grains' edges there.
    fn sides(&self, caps: &[(usize, Vec<Vec3>)]) -> Vec<(Vec3, Vec3)> {
        let (u, v) = self.in_plane().into();
        let mut parts = Vec::new();
        for (along, across) in [(u, v), (v, u)] {
            for place in [self.domain.min[across], self.domain.max[across]] {
                let mut start = self.domain.min;
                start[across] = place;
                let mut end = start;
                end[along] = self.domain.max[along];
                let corners = caps.iter().flat_map(|cap| &cap.1).filter(|corner| corner[across] == place);
                let mut stops: Vec<Vec3> = corners.copied().chain([start, end]).collect();
                stops.sort_by(|a, b| a[along].total_cmp(&b[along]));
                stops.dedup();
                parts.extend(stops.windows(2).map(|pair| (pair[0], pair[1])));
            }
        }
        parts
    }

    fn vertex(&mut self, place: Vec3) -> FixedVertexHandle {
        let [u, v] = self.in_plane().map(|axis| place[axis]);
        let vertex = self.cdt.insert(Point2::new(u, v)).expect("coordinates are finite and not tiny");
        if vertex.index() == self.points.len() {
            self.points.push(place);
        }
        vertex
    }

    /// Makes the edges between consecutive nodes part of the triangulation.
    fn keep(&mut self, nodes: &[Vec3]) -> Result<(), String> {
        let vertices: Vec<FixedVertexHandle> = nodes.iter().map(|node| self.vertex(*node)).collect();
        for pair in vertices.windows(2) {
            if !self.cdt.can_add_constraint(pair[0], pair[1]) {
                let at = self.points[pair[0].index()];
                return Err(format!("rims of aggregates cross at {:.6}, {:.6}, {:.6} mm", at.x, at.y, at.z));
            }
            self.cdt.add_constraint(pair[0], pair[1]);
        }
        Ok(())
    }

    /// Two neighbours on the rim of a cap, which lies on the left from the first to the second.
    fn rim(&mut self, corners: &[Vec3], limit: f64) -> [FixedVertexHandle; 2] {
        // Counter-clockwise from outside is clockwise from above.
        let nodes = halved(corners[1], corners[0], limit);
        [self.vertex(nodes[0]), self.vertex(nodes[1])]
    }

    fn refine(&mut self, limit: f64) {
        let parameters = RefinementParameters::new()
            .keep_constraint_edges()
            .with_angle_limit(AngleLimit::from_radius_to_shortest_edge_ratio(RADIUS_PER_EDGE))
            // Of an equilateral triangle.
            .with_max_allowed_area(3.0_f64.sqrt() / 4.0 * limit * limit);
        self.cdt.refine(parameters);
        let [u, v] = self.in_plane();
        for vertex in self.cdt.vertices().skip(self.points.len()) {
            let mut place = self.domain.min;
            (place[u], place[v]) = (vertex.position().x, vertex.position().y);
            self.points.push(snap(place));
        }
    }

    /// The triangles; `inside` has for each cap two neighbours on its rim.
    fn face(self, inside: &[(usize, [FixedVertexHandle; 2])]) -> Result<Face, String> {
        let mut piece = vec![None; self.cdt.num_all_faces()];
        for (index, [a, b]) in inside {
            let edge = self.cdt.get_edge_from_neighbors(*a, *b).ok_or("an edge of a rim is lost")?;
            let mut open = vec![edge.face().fix()];
            while let Some(face) = open.pop() {
                let seen = &mut piece[face.index()];
                let Some(face) = self.cdt.face(face).as_inner().filter(|_| seen.is_none()) else { continue };
                *seen = Some(*index);
                let beyond = face.adjacent_edges().into_iter().filter(|edge| !edge.is_constraint_edge());
                open.extend(beyond.map(|edge| edge.rev().face().fix()));
            }
        }
        let triangle = |face: spade::handles::FaceHandle<'_, spade::handles::InnerTag, _, _, _, _>| {
            (face.vertices().map(|vertex| vertex.fix().index() as u32), piece[face.fix().index()])
        };
        let triangles = self.cdt.inner_faces().map(triangle).collect();
        Ok(Face { points: self.points, triangles })
    }
}

/// Nodes by their places, bit for bit.
#[derive(Default)]
pub(super) struct Nodes {
    pub(super) points: Vec<Vec3>,
    numbers: BTreeMap<[u64; 3], u32>,
}

impl Nodes {
    /// The number of the node at `place`, a new one where there is none.
    pub(super) fn at(&mut self, place: Vec3) -> u32 {
        // -0 and 0 are one place.
        let key: [u64; 3] = place.map(|x| (x + 0.0).to_bits()).into();
        *self.numbers.entry(key).or_insert_with(|| {
            self.points.push(place);
            self.points.len() as u32 - 1
        })
    }
}
