//! A closed surface in fewer triangles, nowhere farther from the given one than a stated distance.
//!
//! Edges are collapsed in the order of their quadric error (M. Garland, P. Heckbert, Surface Simplification Using Quadric
//! Error Metrics, 1997), which ends at a limit. Passes over flat arrays take the place of a queue: each pass collapses the
//! edges of the lowest errors, and a vertex that it has moved waits for the next one. Only collapses that keep the surface
//! closed and of its kind are done: the two ends of the edge have two neighbours in common, and no triangle turns over.
//! Afterwards both surfaces are proved to lie within the distance of each other, and the reduced one not to cross itself;
//! where either fails, the surface at a lower limit is tried.

use super::SelfCrossing;
use crate::geometry::{TriangleMesh, Triangles};
use crate::math::{Aabb, Vec3};
use crate::stop;

/// Why a surface was not reduced.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotReduced {
    /// The given surface crosses itself.
    #[error("its surface crosses itself near {at:?}")]
    Crosses {
        /// A point near the crossing, in the frame of the surface, mm.
        at: [f64; 3],
    },
}

/// Limits of the root mean square quadric error that are tried, the largest first, as shares of the distance.
const LIMITS: [f64; 6] = [0.08, 0.15, 0.25, 0.35, 0.5, 0.6];

impl TriangleMesh {
    /// The surface in fewer triangles, within `distance` mm of the given one, and the given one within that of it.
    ///
    /// The surface must be closed. The result is closed, has as many handles and parts, and does not cross itself. It is the
    /// given surface where no fewer triangles are proved to be near enough.
    ///
    /// # Errors
    /// See [`NotReduced`].
    pub fn reduced(&self, distance: f64) -> Result<Self, NotReduced> {
        let given = self.facets();
        let stages = Reduction::new(self, &Aabb::everywhere()).stages(&LIMITS.map(|limit| limit * distance));
        let is_accepted = |reduced: &Self| {
            let found = reduced.facets();
            Proof::of(&given, &found, distance)
                && Proof::of(&found, &given, distance)
                && (SelfCrossing { mesh: reduced, facets: &found }).find().is_none()
        };
        if let Some(reduced) = stages.into_iter().rev().find(is_accepted) {
            return Ok(reduced);
        }
        match (SelfCrossing { mesh: self, facets: &given }).find() {
            Some([first, _]) => Err(NotReduced::Crosses { at: first[0].into() }),
            None => Ok(self.clone()),
        }
    }

    /// The surface with all edges collapsed whose root mean square quadric error is at most `limit` mm: a few times faster
    /// than [`reduced`](Self::reduced), and nothing is proved. Vertices in a side of `walls` stay in it.
    pub fn simplified(&self, limit: f64, walls: &Aabb) -> Self {
        Reduction::new(self, walls).stages(&[limit]).pop().unwrap_or_else(|| self.clone())
    }
}

/// Divisions of every triangle that is compared with a surface, where they are needed.
const DIVISIONS: u32 = 7;
/// Most divisions of a large triangle, whose parts are still larger than [`SMALL`] times the distance.
const MOST_DIVISIONS: u32 = 14;
const SMALL: f64 = 0.25;

/// A proof that all points of a surface lie within `distance` mm of another. The distance of a triangle's middle grows by no
/// more than the way from there. The distance from one triangle of the other surface is largest at a corner, since that
/// triangle is convex: this ends at once where the surfaces lie in one plane.
struct Proof<'a> {
    other: &'a Triangles,
    distance: f64,
    /// The triangle of the other surface that was near the last point: neighbours follow each other.
    last: u32,
    /// Square of the longest edge of the other surface's triangles and twice the distance: no longer one is near one triangle.
    longest: f64,
}

/// Square of a triangle's longest edge.
fn longest_of([a, b, c]: &[Vec3; 3]) -> f64 {
    (a - b).norm_squared().max((b - c).norm_squared()).max((c - a).norm_squared())
}

impl<'a> Proof<'a> {
    fn of(surface: &Triangles, other: &'a Triangles, distance: f64) -> bool {
        let longest = other.corners().iter().map(longest_of).fold(0.0, f64::max);
        let mut proof = Self { other, distance, last: 0, longest: (longest.sqrt() + 2.0 * distance).powi(2) };
        surface.corners().iter().all(|triangle| proof.holds(triangle, 0))
    }

    fn holds(&mut self, triangle: &[Vec3; 3], divisions: u32) -> bool {
        stop::point();
        let [a, b, c] = triangle;
        let middle = (a + b + c) / 3.0;
        let radius = triangle.iter().map(|corner| (corner - middle).norm()).fold(0.0, f64::max);
        if self.has_near(&middle, self.distance - radius) {
            return true;
        }
        let is_last = divisions >= DIVISIONS && (radius <= SMALL * self.distance || divisions == MOST_DIVISIONS);
        if is_last || !self.has_near(&middle, self.distance) {
            return false;
        }
        if longest_of(triangle) <= self.longest && self.is_near_one(triangle, &middle) {
            return true;
        }
        let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
        let quarters = [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]];
        quarters.iter().all(|quarter| self.holds(quarter, divisions + 1))
    }

    /// True where one triangle of the other surface, near the middle, has all corners within the distance.
    fn is_near_one(&self, corners: &[Vec3; 3], middle: &Vec3) -> bool {
        let most = self.distance * (1.0 - ROUNDING_OF_A_DISTANCE);
        let holds = |t: u32| corners.iter().all(|corner| self.other.nearest_of(t, corner).1 <= most);
        let around = Aabb { min: *middle, max: *middle }.grown(self.distance);
        holds(self.last) || self.other.meeting(around).any(holds)
    }

    /// True where a triangle of the other surface comes within `reach` mm of a point.
    fn has_near(&mut self, point: &Vec3, reach: f64) -> bool {
        let most = reach * (1.0 - ROUNDING_OF_A_DISTANCE);
        let is_near = |t: &u32| self.other.nearest_of(*t, point).1 <= most;
        if most < 0.0 || is_near(&self.last) {
            return most >= 0.0;
        }
        let around = Aabb { min: *point, max: *point }.grown(reach);
        let found = self.other.meeting(around).find(is_near);
        self.last = found.unwrap_or(self.last);
        found.is_some()
    }
}

/// Bound on the rounding of a distance, as a share.
const ROUNDING_OF_A_DISTANCE: f64 = 1e-12;

/// Area-weighted sum of squared distances from planes: x^T A x + 2 b^T x + c.
#[derive(Clone, Copy, Default)]
struct Quadric {
    /// A by entries xx, yy, zz, yz, zx, xy.
    a: [f64; 6],
    b: Vec3,
    c: f64,
    area: f64,
}

impl Quadric {
    fn of_plane(corners: &[Vec3; 3]) -> Self {
        let cross = cross(corners);
        let length = cross.norm();
        let n = if length > 0.0 { cross / length } else { Vec3::zeros() };
        let (offset, area) = (-n.dot(&corners[0]), length / 2.0);
        let a = [n.x * n.x, n.y * n.y, n.z * n.z, n.y * n.z, n.z * n.x, n.x * n.y].map(|square| square * area);
        Self { a, b: n * (offset * area), c: offset * offset * area, area }
    }

    fn with(&self, other: &Self) -> Self {
        let a = std::array::from_fn(|i| self.a[i] + other.a[i]);
        Self { a, b: self.b + other.b, c: self.c + other.c, area: self.area + other.area }
    }

    /// Mean square distance of `x` from the planes, mm2.
    fn mean_square(&self, x: &Vec3) -> f64 {
        let [xx, yy, zz, yz, zx, xy] = self.a;
        let ax =
            Vec3::new(xx * x.x + xy * x.y + zx * x.z, xy * x.x + yy * x.y + yz * x.z, zx * x.x + yz * x.y + zz * x.z);
        ((x.dot(&ax) + 2.0 * self.b.dot(x) + self.c) / self.area.max(f64::MIN_POSITIVE)).max(0.0)
    }

    /// The position of the least error, drawn a little to `middle` where planes do not determine it.
    fn least(&self, middle: &Vec3) -> Option<Vec3> {
        let regular = REGULAR * self.area;
        let [xx, yy, zz, yz, zx, xy] = self.a;
        let [xx, yy, zz] = [xx + regular, yy + regular, zz + regular];
        // Cofactors of the symmetric matrix.
        let [c0, c1, c2] = [yy * zz - yz * yz, zx * yz - xy * zz, xy * yz - zx * yy];
        let [c11, c12, c22] = [xx * zz - zx * zx, xy * zx - xx * yz, xx * yy - xy * xy];
        let determinant = xx * c0 + xy * c1 + zx * c2;
        let r = middle * regular - self.b;
        let x = Vec3::new(
            c0 * r.x + c1 * r.y + c2 * r.z,
            c1 * r.x + c11 * r.y + c12 * r.z,
            c2 * r.x + c12 * r.y + c22 * r.z,
        );
        (determinant > 0.0).then(|| x / determinant)
    }

    /// The position of the least error near an edge, and that error. Flat regions leave it to the edge. `held` puts a position
    /// where its vertex has to stay.
    fn best(&self, ends: [&Vec3; 2], held: impl Fn(Vec3) -> Vec3) -> (Vec3, f64) {
        let middle = (ends[0] + ends[1]) / 2.0;
        let reach = (ends[0] - ends[1]).norm_squared();
        let near = self.least(&middle).filter(|x| (x - middle).norm_squared() <= reach);
        let candidates = near.into_iter().chain([middle, *ends[0], *ends[1]]);
        let errors = candidates.map(held).map(|x| (x, self.mean_square(&x)));
        errors.min_by(|p, q| p.1.total_cmp(&q.1)).unwrap_or((middle, f64::INFINITY))
    }
}

/// Weight of the middle of an edge beside the planes.
const REGULAR: f64 = 1e-4;
/// Cosine of the largest turn of a triangle in one collapse.
const LEAST_COSINE: f64 = 0.5;
/// A triangle has at least this share of the area of an equilateral one of its longest side.
const LEAST_SHAPE: f64 = 0.02;

fn cross([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a))
}

/// Bits of the lower sides.
const LOWER: u8 = 0b01_0101;

/// `x` moved into the sides of a box that have bits.
fn put(mut x: Vec3, sides: u8, aabb: &Aabb) -> Vec3 {
    if sides == 0 {
        return x;
    }
    (0..6).filter(|bit| sides >> bit & 1 == 1).for_each(|bit| x[bit / 2] = aabb.end(bit));
    x
}

/// No vertex, at the first corner of a triangle that is gone.
const GONE: u32 = u32::MAX;
/// A pass takes the edges of the lowest errors, one of so many. Edges at a vertex that the pass has moved wait for the next
/// one, so a larger share would take them out of their order.
const PART: usize = 3;
/// A pass takes all edges where there are no more than this.
const FEW: usize = 2000;
/// A pass that collapses no more than one edge for so many triangles is not worth another.
const TRIANGLES_A_COLLAPSE: usize = 2000;

/// A surface while its edges are collapsed, in flat arrays. Coordinates are about the middle of its box, for precision.
struct Reduction {
    origin: Vec3,
    walls: Aabb,
    /// The sides of `walls` that each vertex has to stay in: a bit for each, lower and upper along x, y and z.
    held: Vec<u8>,
    points: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
    /// Mean square errors of the edges from each corner to the next one, mm2; NaN where they are to be computed.
    errors: Vec<[f32; 3]>,
    /// Where the triangles at each vertex begin and end in `around`. Some of them are gone.
    places: Vec<[u32; 2]>,
    around: Vec<u32>,
    /// The last pass that moved each vertex, and the last that moved it or a neighbour.
    moved: Vec<u32>,
    stirred: Vec<u32>,
    /// The last pass that tried all edges up to the limit: one that stayed will stay while no neighbour of its ends moves.
    complete: u32,
    /// Vertices, marked with the number of a collapse that is tried.
    marks: Vec<u32>,
    tried: u32,
    passes: u32,
}

impl Reduction {
    fn new(mesh: &TriangleMesh, walls: &Aabb) -> Self {
        let aabb = Aabb::around(&mesh.vertices);
        let origin = (aabb.min + aabb.max) / 2.0;
        let count = mesh.vertices.len();
        let held = |v: &Vec3| (0..6).fold(0, |bits, bit| bits | u8::from(v[bit / 2] == walls.end(bit)) << bit);
        let mut reduction = Self {
            origin,
            walls: *walls,
            held: mesh.vertices.iter().map(held).collect(),
            points: mesh.vertices.iter().map(|v| v - origin).collect(),
            quadrics: vec![Quadric::default(); count],
            triangles: mesh.triangles.clone(),
            errors: vec![[f32::NAN; 3]; mesh.triangles.len()],
            places: vec![[0; 2]; count],
            around: Vec::new(),
            moved: vec![0; count],
            stirred: vec![0; count],
            complete: 0,
            marks: vec![0; count],
            tried: 0,
            passes: 0,
        };
        for t in 0..mesh.triangles.len() as u32 {
            // A triangle in a side holds no vertex that is held there anyway: its area would only hide what others lose.
            if reduction.triangles[t as usize].iter().fold(u8::MAX, |sides, &v| sides & reduction.held[v as usize]) != 0
            {
                continue;
            }
            let quadric = Quadric::of_plane(&reduction.corners(t));
            for corner in reduction.triangles[t as usize] {
                let own = &mut reduction.quadrics[corner as usize];
                *own = own.with(&quadric);
            }
        }
        reduction
    }

    fn corners(&self, t: u32) -> [Vec3; 3] {
        self.triangles[t as usize].map(|i| self.points[i as usize])
    }

    /// The surfaces in which all edges are collapsed whose root mean square error stays within each of the ascending
    /// `limits`, mm: edges of lower errors come first, so that one surface goes on from the last.
    fn stages(mut self, limits: &[f64]) -> Vec<TriangleMesh> {
        limits.iter().map(|limit| self.collapsed((limit * limit) as f32)).collect()
    }

    /// The surface in which all edges are collapsed whose mean square error is at most `enough` mm2.
    fn collapsed(&mut self, enough: f32) -> TriangleMesh {
        self.complete = 0;
        // The edges of the lowest errors may be ones that have to stay, so all are tried before the end.
        while self.pass(enough, PART) || self.pass(enough, 1) {}
        self.rest()
    }

    /// Collapses one of `part` edges, those of the lowest errors, and none at a vertex that has moved; true where that is
    /// worth another pass.
    fn pass(&mut self, enough: f32, part: usize) -> bool {
        self.passes += 1;
        self.gather();
        let mut edges = self.edges(enough);
        let is_complete = part == 1 || edges.len() <= FEW;
        if !is_complete {
            let count = edges.len() / part;
            edges.select_nth_unstable(count);
            edges.truncate(count);
        }
        edges.sort_unstable();
        let mut collapsed = 0;
        for (_, a, b) in edges {
            stop::point();
            let ends = [a, b].map(|v| v as usize);
            let is_fresh = ends.iter().all(|&v| self.moved[v] != self.passes);
            let has_changed = ends.iter().any(|&v| self.stirred[v] >= self.complete);
            collapsed += usize::from(is_fresh && has_changed && self.collapse(a, b));
        }
        if is_complete {
            self.complete = self.passes;
        }
        collapsed * TRIANGLES_A_COLLAPSE > self.triangles.len()
    }

    /// Drops triangles that are gone, and lists those at each vertex.
    fn gather(&mut self) {
        let mut left = 0;
        for t in 0..self.triangles.len() {
            if self.triangles[t][0] != GONE {
                (self.triangles[left], self.errors[left]) = (self.triangles[t], self.errors[t]);
                left += 1;
            }
        }
        self.triangles.truncate(left);
        self.errors.truncate(left);
        self.places.fill([0; 2]);
        self.triangles.as_flattened().iter().for_each(|&corner| self.places[corner as usize][1] += 1);
        let mut start = 0;
        for place in &mut self.places {
            let count = place[1];
            *place = [start; 2];
            start += count;
        }
        self.around.clear();
        self.around.resize(3 * left, 0);
        for (number, &corner) in self.triangles.as_flattened().iter().enumerate() {
            let end = &mut self.places[corner as usize][1];
            self.around[*end as usize] = number as u32 / 3;
            *end += 1;
        }
    }

    /// Edges with at most this error, each by the bits of its error, which order like it.
    fn edges(&mut self, enough: f32) -> Vec<(u32, u32, u32)> {
        let mut edges = Vec::new();
        for t in 0..self.triangles.len() {
            let corners = self.triangles[t];
            for k in 0..3 {
                let (a, b) = (corners[k], corners[(k + 1) % 3]);
                if a > b {
                    continue;
                }
                if self.errors[t][k].is_nan() {
                    self.errors[t][k] = self.target(a, b).1 as f32;
                }
                let error = self.errors[t][k];
                if error <= enough {
                    edges.push((error.to_bits(), a, b));
                }
            }
        }
        edges
    }

    fn target(&self, a: u32, b: u32) -> (Vec3, f64) {
        let [p, q] = [a, b].map(|i| i as usize);
        let held = self.held[p] | self.held[q];
        // No edge spans the box.
        if held & held >> 1 & LOWER != 0 {
            return (self.points[p], f64::INFINITY);
        }
        let hold = |x| if held == 0 { x } else { put(x, held, &self.walls.moved(&-self.origin)) };
        self.quadrics[p].with(&self.quadrics[q]).best([&self.points[p], &self.points[q]], hold)
    }

    /// Triangles at a vertex, in their order.
    fn at(&self, vertex: u32) -> impl Iterator<Item = u32> + use<'_> {
        let [start, end] = self.places[vertex as usize].map(|at| at as usize);
        self.around[start..end].iter().copied().filter(|t| self.triangles[*t as usize][0] != GONE)
    }

    /// Neighbours of a vertex: the next corner of each of its triangles.
    fn neighbours(&self, vertex: u32) -> impl Iterator<Item = u32> + use<'_> {
        self.at(vertex).map(move |t| {
            let [a, b, c] = self.triangles[t as usize];
            if a == vertex {
                b
            } else if b == vertex {
                c
            } else {
                a
            }
        })
    }

    /// Puts `b` onto `a`, at the best position, where that leaves a closed surface without turned triangles.
    fn collapse(&mut self, a: u32, b: u32) -> bool {
        self.tried += 1;
        let (mut own, mut others, mut common, mut is_edge) = (0, 0, 0, false);
        let mut marks = std::mem::take(&mut self.marks);
        for vertex in self.neighbours(a) {
            marks[vertex as usize] = self.tried;
            own += 1;
            is_edge |= vertex == b;
        }
        for vertex in self.neighbours(b) {
            others += 1;
            common += usize::from(marks[vertex as usize] == self.tried);
        }
        self.marks = marks;
        // Two ends of valence three would leave two triangles on each other.
        if common != 2 || own + others <= 7 || !is_edge {
            return false;
        }
        let (position, _) = self.target(a, b);
        let has = |t: u32, vertex: u32| self.triangles[t as usize].contains(&vertex);
        let kept_at = |own: u32, other: u32| self.at(own).filter(move |t| !has(*t, other));
        let kept = || kept_at(a, b).map(|t| (t, a)).chain(kept_at(b, a).map(|t| (t, b)));
        if !kept().all(|(t, moved)| self.stays_upright(t, moved, &position)) {
            return false;
        }
        let start = self.around.len();
        let list: Vec<u32> = kept().map(|(t, _)| t).collect();
        for &t in &list {
            self.triangles[t as usize].iter().for_each(|&v| self.stirred[v as usize] = self.passes);
        }
        for at in self.places[a as usize][0]..self.places[a as usize][1] {
            let corners = &mut self.triangles[self.around[at as usize] as usize];
            // Those that are gone have no corner `b`.
            if corners.contains(&b) {
                *corners = [GONE; 3];
            }
        }
        for &t in &list {
            let corners = &mut self.triangles[t as usize];
            corners.iter_mut().filter(|corner| **corner == b).for_each(|corner| *corner = a);
            let at = corners.iter().position(|corner| *corner == a).unwrap_or_default();
            self.errors[t as usize][at] = f32::NAN;
            self.errors[t as usize][(at + 2) % 3] = f32::NAN;
        }
        self.around.extend(list);
        self.places[a as usize] = [start as u32, self.around.len() as u32];
        self.places[b as usize] = [0; 2];
        self.points[a as usize] = position;
        self.held[a as usize] |= self.held[b as usize];
        self.quadrics[a as usize] = self.quadrics[a as usize].with(&self.quadrics[b as usize]);
        [a, b].into_iter().for_each(|vertex| self.moved[vertex as usize] = self.passes);
        true
    }

    /// True when a triangle with its corner `moved` at `position` has about its normal, and a shape.
    fn stays_upright(&self, t: u32, moved: u32, position: &Vec3) -> bool {
        let before = self.corners(t);
        let at = |k: usize| if self.triangles[t as usize][k] == moved { *position } else { before[k] };
        let after = [at(0), at(1), at(2)];
        let (old, new) = (cross(&before), cross(&after));
        let longest = (0..3).map(|k| (after[k] - after[(k + 1) % 3]).norm_squared()).fold(0.0, f64::max);
        let size = new.norm_squared();
        let turn = new.dot(&old);
        turn > 0.0
            && turn * turn > LEAST_COSINE * LEAST_COSINE * size * old.norm_squared()
            && size > LEAST_SHAPE * LEAST_SHAPE * longest * longest
    }

    /// What is left, with vertices in their order.
    fn rest(&self) -> TriangleMesh {
        let left = || self.triangles.iter().filter(|t| t[0] != GONE);
        let mut number = vec![GONE; self.points.len()];
        left().flatten().for_each(|&vertex| number[vertex as usize] = 0);
        let mut vertices = Vec::new();
        for (vertex, number) in number.iter_mut().enumerate().filter(|(_, number)| **number != GONE) {
            *number = vertices.len() as u32;
            vertices.push(put(self.points[vertex] + self.origin, self.held[vertex], &self.walls));
        }
        TriangleMesh { triangles: left().map(|t| t.map(|i| number[i as usize])).collect(), vertices }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Polyhedron, Round};
    use crate::random::Stream;

    fn quartered(mesh: &TriangleMesh) -> TriangleMesh {
        let corners = |t: &[u32; 3]| t.map(|i| mesh.vertices[i as usize]);
        let quarters = mesh.triangles.iter().map(corners).flat_map(|[a, b, c]| {
            let [ab, bc, ca] = [(a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0];
            [a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca]
        });
        TriangleMesh::welded(&quarters.collect::<Vec<_>>())
    }

    /// An upright prism over an L of 10 mm, each triangle divided so many times: large plane faces in small triangles.
    fn angle(times: usize) -> TriangleMesh {
        let outline = [[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [4.0, 4.0], [4.0, 10.0], [0.0, 10.0]];
        let vertices = [0.0, 5.0].into_iter().flat_map(|z| outline.map(|[x, y]| Vec3::new(x, y, z))).collect();
        let ends = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
        let below = ends.map(|[a, b, c]| [a, c, b]);
        let above = ends.map(|t| t.map(|i| i + 6));
        let sides = (0..6).flat_map(|i| [[i, (i + 1) % 6, (i + 1) % 6 + 6], [i, (i + 1) % 6 + 6, i + 6]]);
        let mut mesh = TriangleMesh { vertices, triangles: below.into_iter().chain(above).chain(sides).collect() };
        (0..times).for_each(|_| mesh = quartered(&mesh));
        mesh
    }

    /// Found with a scan that stands on a plane foot: triangles of the foot were too large to be proved near it.
    #[test]
    fn large_plane_faces_are_reduced_to_few_triangles_at_any_distance() {
        let scan = angle(4);
        assert_eq!(scan.triangles.len(), 20 * 256);
        for distance in [0.05, 0.005] {
            let reduced = scan.reduced(distance).unwrap();
            assert!(reduced.triangles.len() <= 40, "{distance}: {}", reduced.triangles.len());
            assert!((reduced.volume() - scan.volume()).abs() < 1e-9 * scan.volume());
        }
        let block = angle(0);
        assert_eq!(block.reduced(1e-6).unwrap(), block);
        let mut crossing = block.clone();
        crossing.vertices[3] = Vec3::new(-1.0, 11.0, 0.0);
        let NotReduced::Crosses { at } = crossing.reduced(0.01).unwrap_err();
        assert!(crossing.vertices.iter().any(|v| <[f64; 3]>::from(*v) == at), "{at:?}");
    }

    /// A lumpy stone: the facets of a ball divided `times`, at radii that vary.
    fn stone(times: usize, noise: f64) -> TriangleMesh {
        let ball = Polyhedron::of_round(&Round::ball(10.0));
        let mut mesh = TriangleMesh { vertices: ball.vertices().to_vec(), triangles: ball.triangles().collect() };
        (0..times).for_each(|_| mesh = quartered(&mesh));
        let mut stream = Stream::new(3);
        for vertex in &mut mesh.vertices {
            let u = vertex.normalize();
            let dent = 1.0 - 0.35 * (-8.0 * (u - Vec3::x()).norm_squared()).exp()
                + 0.1 * (3.0 * u.y).sin() * (2.0 * u.z).cos();
            *vertex = u * (10.0 * dent + stream.uniform(-noise, noise));
        }
        mesh
    }

    #[test]
    fn a_reduced_stone_is_closed_and_as_near_as_stated() {
        for (times, noise) in [(2, 0.0), (3, 0.02)] {
            let given = stone(times, noise);
            let distance = 0.005 * 20.0;
            let reduced = given.reduced(distance).unwrap();
            reduced.check_closed().unwrap();
            assert_eq!(reduced.components().len(), 1);
            assert_eq!(reduced.triangles.len() + 4, 2 * reduced.vertices.len());
            assert!(reduced.triangles.len() < 1500, "{}", reduced.triangles.len());
            assert!((reduced.volume() / given.volume() - 1.0).abs() < 0.01);
            // By samples, which the proof does not use.
            let [own, other] = [&reduced, &given].map(TriangleMesh::facets);
            let farthest = |from: &TriangleMesh, to: &Triangles| {
                from.vertices.iter().map(|v| to.nearest(v).unwrap().1).fold(0.0, f64::max)
            };
            let found = farthest(&reduced, &other).max(farthest(&given, &own));
            assert!(found <= distance && found > 0.2 * distance, "{found}");
            let are_within = |most: f64| {
                reduced.vertices.iter().all(|v| other.is_within(v, most))
                    && given.vertices.iter().all(|v| own.is_within(v, most))
            };
            assert!(are_within(found * (1.0 + 1e-12)) && !are_within(found * 0.999));
        }
    }

    #[test]
    fn a_ring_keeps_its_hole_and_a_tetrahedron_its_faces() {
        let at = |a: usize, b: usize| (a % 40 * 20 + b % 20) as u32;
        let tau = std::f64::consts::TAU;
        let corner = |k: usize| {
            let [a, b] = [tau * (k / 20) as f64 / 40.0, tau * (k % 20) as f64 / 20.0];
            Vec3::new((6.0 + 2.0 * b.cos()) * a.cos(), (6.0 + 2.0 * b.cos()) * a.sin(), 2.0 * b.sin())
        };
        let squares = (0..40).flat_map(|a| (0..20).map(move |b| (a, b)));
        let pairs = |(a, b)| {
            let [p, q, r, s] = [at(a, b), at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)];
            [[p, q, r], [p, r, s]]
        };
        let ring =
            TriangleMesh { vertices: (0..800).map(corner).collect(), triangles: squares.flat_map(pairs).collect() };
        let reduced = ring.reduced(0.2).unwrap();
        reduced.check_closed().unwrap();
        assert_eq!(reduced.triangles.len(), 2 * reduced.vertices.len());
        assert!(reduced.triangles.len() < 600, "{}", reduced.triangles.len());
        let tetrahedron = crate::geometry::convex_hull(&[Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]).unwrap();
        let given =
            TriangleMesh { vertices: tetrahedron.vertices().to_vec(), triangles: tetrahedron.triangles().collect() };
        assert_eq!(given.reduced(10.0).unwrap(), given);
    }

    #[test]
    fn a_surface_beyond_the_distance_is_not_within_it() {
        let [small, large] = [1.0, 1.1].map(|size| {
            let ball = Polyhedron::of_round(&Round::ball(size));
            TriangleMesh { vertices: ball.vertices().to_vec(), triangles: ball.triangles().collect() }.facets()
        });
        assert!(Proof::of(&small, &large, 0.12) && Proof::of(&large, &small, 0.12));
        assert!(!Proof::of(&small, &large, 0.09) && !Proof::of(&large, &small, 0.09));
    }
}
