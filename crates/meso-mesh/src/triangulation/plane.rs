//! A plane region as triangles: its rims kept, Delaunay's between them, refined by Ruppert's algorithm and smoothed.
//!
//! Halving the triangles of a fan would be simpler, but a fan of a polygon with one short edge has needles, and the nodes on
//! a needle's long sides come as close to each other as that edge is short.

use super::nodes::snap;
use super::{Triangles, Untriangulated};
use meso_collision::math::Vec3;
use meso_concrete::stop;
use spade::handles::{FixedVertexHandle, InnerTag};
use spade::{AngleLimit, ConstrainedDelaunayTriangulation, HasPosition, Point2, RefinementParameters, Triangulation};

/// The refinement stops at circumradii of this many shortest edges: angles of 24.6 degrees, where rims allow them.
const RADIUS_PER_EDGE: f64 = 1.2;
/// Triangles with less than this share of the largest area stay as they are: at short edges of rims nodes would crowd.
const LEAST_AREA: f64 = 1.0 / 16.0;
/// Nodes that a refinement may add, more than any needs.
const MOST: usize = 10_000_000;
/// Rounds of smoothing.
const ROUNDS: usize = 3;

/// The nodes from `from` to `to`, both included, where an edge is cut.
pub(crate) fn halved(from: Vec3, to: Vec3, limit: f64) -> Vec<Vec3> {
    if (to - from).norm_squared() <= limit * limit {
        return vec![from, to];
    }
    let middle = snap((from + to) / 2.0);
    let mut nodes = halved(from, middle, limit);
    nodes.extend(&halved(middle, to, limit)[1..]);
    nodes
}

/// Two directions in a plane, and the plane's position.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    u: Vec3,
    v: Vec3,
    /// The plane's point nearest the origin.
    foot: Vec3,
}

impl Frame {
    /// The plane at `position` across an axis, seen from above.
    pub(crate) fn across(axis: usize, position: f64) -> Self {
        let [u, v] = [1, 2].map(|next| Vec3::ith((axis + next) % 3, 1.0));
        Self { u, v, foot: Vec3::ith(axis, position) }
    }

    /// The plane of a convex polygon, seen from the side from which it is counter-clockwise.
    pub(crate) fn of(polygon: &[Vec3]) -> Self {
        let edge = |k: usize| polygon[(k + 1) % polygon.len()] - polygon[k];
        let from_first = |k: usize| polygon[k] - polygon[0];
        let area = (2..polygon.len()).map(|k| from_first(k - 1).cross(&from_first(k))).sum::<Vec3>();
        let normal = area / area.norm();
        let longest = (0..polygon.len()).map(edge).max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
        let along = longest.unwrap_or(Vec3::x());
        let v = normal.cross(&along);
        let v = v / v.norm();
        Self { u: v.cross(&normal), v, foot: normal * normal.dot(&polygon[0]) }
    }

    /// False for a polygon without area.
    pub(crate) fn is_plane(&self) -> bool {
        [self.u, self.v, self.foot].iter().flatten().all(|x| x.is_finite())
    }

    fn flat(&self, position: &Vec3) -> Point2<f64> {
        Point2::new(self.u.dot(position), self.v.dot(position))
    }

    fn position(&self, point: Point2<f64>) -> Vec3 {
        snap(self.foot + self.u * point.x + self.v * point.y)
    }
}

/// A vertex of the triangulation. The refinement of a large region takes seconds in one call; it makes one of these for every
/// node that it adds, so that is where it stops.
#[derive(Clone, Copy)]
struct PlaneVertex(Point2<f64>);

impl From<Point2<f64>> for PlaneVertex {
    fn from(point: Point2<f64>) -> Self {
        stop::point();
        Self(point)
    }
}

impl HasPosition for PlaneVertex {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.0
    }
}

/// A region in the making.
pub(crate) struct FittedPlane {
    frame: Frame,
    cdt: ConstrainedDelaunayTriangulation<PlaneVertex>,
    /// By the vertices' numbers: those of rims first, in their order.
    pub(crate) points: Vec<Vec3>,
}

impl FittedPlane {
    /// A region whose hull has no node but on rims, with the space between the `rims` in it, nodes in a row each; no edge is longer
    /// than `limit` mm by much.
    ///
    /// # Errors
    /// Says where rims cross.
    pub(crate) fn new(frame: Frame, rims: &[Vec<Vec3>], limit: f64) -> Result<Self, Untriangulated> {
        Self::refined(frame, rims, refinement(limit))
    }

    /// Triangulates a region between rims that go around it and its holes: rounding puts some nodes of the outer ones off the hull.
    fn inside(frame: Frame, rims: &[Vec<Vec3>], limit: f64) -> Result<Self, Untriangulated> {
        Self::refined(frame, rims, refinement(limit).exclude_outer_faces(true))
    }

    fn refined(
        frame: Frame,
        rims: &[Vec<Vec3>],
        parameters: RefinementParameters<f64>,
    ) -> Result<Self, Untriangulated> {
        let mut plane = Self::between(frame, rims)?;
        plane.cdt.refine(parameters);
        let inner = smoothed(&plane.cdt, plane.points.len());
        if !inner.is_empty() {
            // Delaunay's anew, since the nodes have moved.
            plane = Self::between(frame, rims)?;
            inner.into_iter().map(|point| frame.position(point)).for_each(|position| {
                plane.vertex(position);
            });
        }
        Ok(plane)
    }

    fn between(frame: Frame, rims: &[Vec<Vec3>]) -> Result<Self, Untriangulated> {
        let mut plane = Self { frame, cdt: ConstrainedDelaunayTriangulation::new(), points: Vec::new() };
        rims.iter().try_for_each(|nodes| plane.keep(nodes))?;
        Ok(plane)
    }

    fn vertex(&mut self, position: Vec3) -> FixedVertexHandle {
        let vertex = self.cdt.insert(self.frame.flat(&position).into()).expect("coordinates are finite and not tiny");
        if vertex.index() == self.points.len() {
            self.points.push(position);
        }
        vertex
    }

    /// Makes the edges between consecutive nodes part of the triangulation.
    fn keep(&mut self, nodes: &[Vec3]) -> Result<(), Untriangulated> {
        let vertices: Vec<FixedVertexHandle> = nodes.iter().map(|node| self.vertex(*node)).collect();
        for pair in vertices.windows(2) {
            if !self.cdt.can_add_constraint(pair[0], pair[1]) {
                return Err(Untriangulated::new("rims of aggregates cross", &self.points[pair[0].index()]));
            }
            self.cdt.add_constraint(pair[0], pair[1]);
        }
        Ok(())
    }

    /// The triangles on the left of the edge between two nodes of a rim and whatever is reached from there across no rim, by
    /// their numbers.
    ///
    /// # Errors
    /// Where there is no such edge.
    pub(crate) fn within(&mut self, from: Vec3, to: Vec3) -> Result<Vec<usize>, Untriangulated> {
        let [a, b] = [from, to].map(|node| self.vertex(node));
        let edge = self.cdt.get_edge_from_neighbors(a, b);
        let edge = edge.ok_or_else(|| Untriangulated::new("an edge of a rim is lost", &from))?;
        let (mut open, mut seen) = (vec![edge.face().fix()], vec![false; self.cdt.num_all_faces()]);
        let mut found = Vec::new();
        while let Some(face) = open.pop() {
            let seen = &mut seen[face.index()];
            let Some(inner) = self.cdt.face(face).as_inner().filter(|_| !*seen) else { continue };
            *seen = true;
            found.push(face.index());
            let beyond = inner.adjacent_edges().into_iter().filter(|edge| !edge.is_constraint_edge());
            open.extend(beyond.map(|edge| edge.rev().face().fix()));
        }
        Ok(found)
    }

    /// All triangles with their numbers, counter-clockwise.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = (usize, [u32; 3])> {
        let corners = |face: spade::handles::FaceHandle<'_, InnerTag, _, _, _, _>| {
            (face.fix().index(), face.vertices().map(|vertex| vertex.fix().index() as u32))
        };
        self.cdt.inner_faces().map(corners)
    }

    /// More than the number of any triangle.
    pub(crate) fn count(&self) -> usize {
        self.cdt.num_all_faces()
    }
}

/// The region on the left of `loops`, seen in `frame`: outlines counter-clockwise, holes clockwise. No edge is longer than
/// `limit` mm by much; those of the loops are halved. It keeps nodes that it does not use.
///
/// # Errors
/// Says where loops cross.
pub(crate) fn region(frame: Frame, loops: &[Vec<Vec3>], limit: f64) -> Result<Triangles, Untriangulated> {
    let edges = |corners: &Vec<Vec3>| {
        let next = |k: usize| corners[(k + 1) % corners.len()];
        (0..corners.len()).map(|k| halved(corners[k], next(k), limit)).collect::<Vec<_>>()
    };
    let rims: Vec<Vec<Vec<Vec3>>> = loops.iter().map(edges).collect();
    let mut plane = FittedPlane::inside(frame, &rims.concat(), limit)?;
    let mut is_within = vec![false; plane.count()];
    for rim in rims {
        plane.within(rim[0][0], rim[0][1])?.into_iter().for_each(|triangle| is_within[triangle] = true);
    }
    // Slivers that rounding leaves between a side and the nodes on it are not within.
    let within = plane.triangles().filter(|(number, _)| is_within[*number]);
    let triangles = within.map(|(_, nodes)| nodes).collect();
    Ok(Triangles { points: plane.points, triangles })
}

/// The parameters of the refinement; rims are kept.
fn refinement(limit: f64) -> RefinementParameters<f64> {
    // Area of an equilateral triangle.
    let largest = 3.0_f64.sqrt() / 4.0 * limit * limit;
    RefinementParameters::new()
        .keep_constraint_edges()
        .with_angle_limit(AngleLimit::from_radius_to_shortest_edge_ratio(RADIUS_PER_EDGE))
        .with_max_additional_vertices(MOST)
        .with_min_required_area(LEAST_AREA * largest)
        .with_max_allowed_area(largest)
}

/// The vertices from number `first`, each moved towards the mean of its neighbours as far as its triangles allow.
///
/// Ruppert's nodes lie on bisectors of edges, many in a row and on common circles: there gmsh leaves tetrahedra without
/// volume (one of 35 boxes of 30 mm had them).
fn smoothed(cdt: &ConstrainedDelaunayTriangulation<PlaneVertex>, first: usize) -> Vec<Point2<f64>> {
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
    let candidates = [1.0, 0.5, 0.25]
        .map(|share| Point2::new(from.x + (mean[0] - from.x) * share, from.y + (mean[1] - from.y) * share));
    candidates.into_iter().find(|point| least(*point) > enough).unwrap_or(from)
}
