//! The faces of a periodic box as triangles, one and the same on both sides.
//!
//! The lower face of each axis is triangulated with the rims of the cut grains in it (a constrained Delaunay
//! triangulation, refined by Ruppert's algorithm and smoothed, rims and sides kept), and moved by the period it is the upper one.

use super::facets::halved;
use super::pieces::{Piece, snap};
use crate::math::{Aabb, Vec3};
use spade::handles::FixedVertexHandle;
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, Point2, RefinementParameters, Triangulation};
use std::collections::BTreeMap;

/// The refinement stops at circumradii of this many shortest edges: angles of 24.6 degrees, where rims allow them.
const RADIUS_PER_EDGE: f64 = 1.2;
/// Rounds of smoothing.
const ROUNDS: usize = 3;

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
    let caps: Vec<(usize, Vec<Vec3>)> = caps(axis, pieces).collect();
    let frame = Frame { axis, domain };
    let rims = frame.rims(&caps, limit);
    let inner = Plane::new(frame, &rims)?.inner(limit);
    // Delaunay's anew, since the nodes have moved.
    let mut plane = Plane::new(frame, &rims)?;
    inner.into_iter().for_each(|node| {
        plane.vertex(node);
    });
    plane.face(&caps, limit)
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

/// The lower face across an axis.
#[derive(Clone, Copy)]
struct Frame<'a> {
    axis: usize,
    domain: &'a Aabb,
}

impl Frame<'_> {
    fn in_plane(&self) -> [usize; 2] {
        [(self.axis + 1) % 3, (self.axis + 2) % 3]
    }

    fn place(&self, point: Point2<f64>) -> Vec3 {
        let ([u, v], mut place) = (self.in_plane(), self.domain.min);
        (place[u], place[v]) = (point.x, point.y);
        snap(place)
    }

    /// The rims of `caps` and the face's four sides, as nodes in a row.
    fn rims(&self, caps: &[(usize, Vec<Vec3>)], limit: f64) -> Vec<Vec<Vec3>> {
        let of_caps = caps.iter().flat_map(|(_, corners)| edges(corners));
        // What grains have of the sides is among their parts.
        let of_caps = of_caps.filter(|(from, to)| !self.is_on_a_side(from, to));
        self.sides(caps).into_iter().chain(of_caps).map(|(from, to)| halved(from, to, limit)).collect()
    }

    fn is_on_a_side(&self, from: &Vec3, to: &Vec3) -> bool {
        let both = |axis: usize, place: f64| from[axis] == place && to[axis] == place;
        self.in_plane().into_iter().any(|axis| both(axis, self.domain.min[axis]) || both(axis, self.domain.max[axis]))
    }

    /// The parts of the face's four sides between the grains' edges there.
    fn sides(&self, caps: &[(usize, Vec<Vec3>)]) -> Vec<(Vec3, Vec3)> {
        let [u, v] = self.in_plane();
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
}

/// A face in the making.
struct Plane<'a> {
    frame: Frame<'a>,
    cdt: ConstrainedDelaunayTriangulation<Point2<f64>>,
    /// By the vertices' numbers.
    points: Vec<Vec3>,
}

impl<'a> Plane<'a> {
    fn new(frame: Frame<'a>, rims: &[Vec<Vec3>]) -> Result<Self, String> {
        let mut plane = Self { frame, cdt: ConstrainedDelaunayTriangulation::new(), points: Vec::new() };
        rims.iter().try_for_each(|nodes| plane.keep(nodes))?;
        Ok(plane)
    }

    fn vertex(&mut self, place: Vec3) -> FixedVertexHandle {
        let [u, v] = self.frame.in_plane().map(|axis| place[axis]);
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

    /// The nodes of a refinement, none of them on a rim.
    fn inner(mut self, limit: f64) -> Vec<Vec3> {
        let parameters = RefinementParameters::new()
            .keep_constraint_edges()
            .with_angle_limit(AngleLimit::from_radius_to_shortest_edge_ratio(RADIUS_PER_EDGE))
            // Of an equilateral triangle.
            .with_max_allowed_area(3.0_f64.sqrt() / 4.0 * limit * limit);
        self.cdt.refine(parameters);
        smoothed(&self.cdt, self.points.len()).into_iter().map(|point| self.frame.place(point)).collect()
    }

    /// The triangles, with the pieces whose `caps` they are part of.
    fn face(mut self, caps: &[(usize, Vec<Vec3>)], limit: f64) -> Result<Face, String> {
        let mut piece = vec![None; self.cdt.num_all_faces()];
        for (index, corners) in caps {
            // Counter-clockwise from outside is clockwise from above.
            let nodes = halved(corners[1], corners[0], limit);
            let [a, b] = [0, 1].map(|i| self.vertex(nodes[i]));
            let edge = self.cdt.get_edge_from_neighbors(a, b).ok_or("an edge of a rim is lost")?;
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

/// The vertices from number `first`, each moved towards the mean of its neighbours as far as its triangles allow.
///
/// Ruppert's nodes lie on bisectors of edges, many in a row and on common circles: there gmsh leaves tetrahedra without
/// volume (one of 35 boxes of 30 mm had them).
fn smoothed(cdt: &ConstrainedDelaunayTriangulation<Point2<f64>>, first: usize) -> Vec<Point2<f64>> {
    let mut points: Vec<Point2<f64>> = cdt.vertices().map(|vertex| vertex.position()).collect();
    let ring = |vertex: usize| -> Vec<usize> {
        let vertex = cdt.vertex(FixedVertexHandle::from_index(vertex));
        vertex.out_edges().map(|edge| edge.to().fix().index()).collect()
    };
    let rings: Vec<Vec<usize>> = (first..points.len()).map(ring).collect();
    for _ in 0..ROUNDS {
        for (vertex, ring) in (first..).zip(&rings) {
            points[vertex] = toward_mean(points[vertex], &ring.iter().map(|&i| points[i]).collect::<Vec<_>>());
        }
    }
    points.split_off(first)
}

/// `from`, moved to the mean of the `ring` around it, or so far that no triangle there shrinks below half the least one.
fn toward_mean(from: Point2<f64>, ring: &[Point2<f64>]) -> Point2<f64> {
    let count = ring.len() as f64;
    let mean = ring.iter().fold([0.0, 0.0], |sum, point| [sum[0] + point.x / count, sum[1] + point.y / count]);
    let areas = |at: Point2<f64>| {
        let area = move |a: Point2<f64>, b: Point2<f64>| (a.x - at.x) * (b.y - at.y) - (a.y - at.y) * (b.x - at.x);
        (0..ring.len()).map(move |i| area(ring[i], ring[(i + 1) % ring.len()]))
    };
    // The ring may go around either way.
    let turn = areas(from).sum::<f64>().signum();
    let least = |at: Point2<f64>| areas(at).map(|area| turn * area).fold(f64::INFINITY, f64::min);
    let enough = least(from) / 2.0;
    let ways = [1.0, 0.5, 0.25]
        .map(|share| Point2::new(from.x + (mean[0] - from.x) * share, from.y + (mean[1] - from.y) * share));
    ways.into_iter().find(|way| least(*way) > enough).unwrap_or(from)
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
