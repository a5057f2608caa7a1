//! A closed surface in fewer triangles, nowhere farther from the given one than a stated distance.
//!
//! Edges are collapsed in the order of their quadric error (M. Garland, P. Heckbert, Surface Simplification Using Quadric
//! Error Metrics, 1997), which ends at a limit. Only collapses that keep the surface closed and of its kind are done: the
//! two ends of the edge have two neighbours in common, and no triangle turns over. Afterwards both surfaces are proved to
//! lie within the distance of each other, and the reduced one not to cross itself; where either fails, the surface at a
//! lower limit is tried.

use super::SelfCrossing;
use crate::geometry::{TriangleMesh, Triangles};
use crate::math::{Aabb, Mat3, Vec3};
use crate::stop;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

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
const LIMITS: [f64; 5] = [0.08, 0.15, 0.25, 0.35, 0.5];
/// Surfaces of more triangles are reduced in two steps, so that further limits are tried on few triangles.
const MANY: usize = 40_000;
/// Share of the distance that the first of two steps takes.
const FIRST_STEP: f64 = 0.2;

impl TriangleMesh {
    /// The surface in fewer triangles, within `distance` mm of the given one, and the given one within that of it.
    ///
    /// The surface must be closed. The result is closed, has as many handles and parts, and does not cross itself. It is the
    /// given surface where no fewer triangles are proved to be near enough.
    ///
    /// # Errors
    /// See [`NotReduced`].
    pub fn reduced(&self, distance: f64) -> Result<Self, NotReduced> {
        if self.triangles.len() <= MANY {
            return self.reduced_within(distance, true);
        }
        let first = self.reduced_within(FIRST_STEP * distance, false)?;
        first.reduced_within((1.0 - FIRST_STEP) * distance, true)
    }

    /// The surface with all edges collapsed whose root mean square quadric error is at most `limit` mm: a few times faster
    /// than [`reduced`](Self::reduced), and nothing is proved. Vertices in a side of `walls` stay in it.
    pub fn simplified(&self, limit: f64, walls: &Aabb) -> Self {
        Reduction::new(self, walls).stages(&[limit]).pop().unwrap_or_else(|| self.clone())
    }

    fn reduced_within(&self, distance: f64, is_last: bool) -> Result<Self, NotReduced> {
        let given = self.facets();
        let stages = Reduction::new(self, &Aabb::everywhere()).stages(&LIMITS.map(|limit| limit * distance));
        let is_accepted = |reduced: &Self| {
            let found = reduced.facets();
            let crosses = || (SelfCrossing { mesh: reduced, facets: &found }).find().is_some();
            Proof::of(&given, &found, distance) && Proof::of(&found, &given, distance) && !(is_last && crosses())
        };
        if let Some(reduced) = stages.into_iter().rev().find(is_accepted) {
            return Ok(reduced);
        }
        match (SelfCrossing { mesh: self, facets: &given }).find() {
            Some([first, _]) => Err(NotReduced::Crosses { at: first[0].into() }),
            None => Ok(self.clone()),
        }
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
}

impl<'a> Proof<'a> {
    fn of(surface: &Triangles, other: &'a Triangles, distance: f64) -> bool {
        let mut proof = Self { other, distance, last: 0 };
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
        if self.is_near_one(triangle, &middle) {
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
    a: Mat3,
    b: Vec3,
    c: f64,
    area: f64,
}

impl Quadric {
    fn of_plane(corners: &[Vec3; 3]) -> Self {
        let cross = cross(corners);
        let length = cross.norm();
        let normal = if length > 0.0 { cross / length } else { Vec3::zeros() };
        let (offset, area) = (-normal.dot(&corners[0]), length / 2.0);
        Self { a: normal * normal.transpose() * area, b: normal * (offset * area), c: offset * offset * area, area }
    }

    fn with(&self, other: &Self) -> Self {
        Self { a: self.a + other.a, b: self.b + other.b, c: self.c + other.c, area: self.area + other.area }
    }

    /// Mean square distance of `x` from the planes, mm2.
    fn mean_square(&self, x: &Vec3) -> f64 {
        ((x.dot(&(self.a * x)) + 2.0 * self.b.dot(x) + self.c) / self.area.max(f64::MIN_POSITIVE)).max(0.0)
    }

    /// The position of the least error near an edge, and that error. Flat regions leave it to the edge. `held` puts a position
    /// where its vertex has to stay.
    fn best(&self, ends: [&Vec3; 2], held: impl Fn(Vec3) -> Vec3) -> (Vec3, f64) {
        let middle = (ends[0] + ends[1]) / 2.0;
        let reach = (ends[0] - ends[1]).norm();
        // A little of the identity keeps the position near the middle where planes do not determine it.
        let system = self.a + Mat3::identity() * (REGULAR * self.area);
        let solved = system.try_inverse().map(|inverse| inverse * (middle * (REGULAR * self.area) - self.b));
        let near = solved.filter(|x| (x - middle).norm() <= reach);
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

/// A surface while its edges are collapsed. Coordinates are about the middle of its box, for precision.
struct Reduction {
    origin: Vec3,
    walls: Aabb,
    /// The sides of `walls` that each vertex has to stay in: a bit for each, lower and upper along x, y and z.
    held: Vec<u8>,
    points: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    triangles: Vec<[u32; 3]>,
    /// Triangles at each vertex; none at one that is gone.
    around: Vec<Vec<u32>>,
    /// Number of changes at each vertex: older entries of the queue are void.
    changes: Vec<u32>,
    /// Edges by the bits of their error, which order like it.
    queue: BinaryHeap<Reverse<(u64, u32, u32, u32)>>,
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
            around: vec![Vec::new(); count],
            changes: vec![0; count],
            queue: BinaryHeap::new(),
        };
        for t in 0..mesh.triangles.len() as u32 {
            let quadric = Quadric::of_plane(&reduction.corners(t));
            for corner in reduction.triangles[t as usize] {
                reduction.around[corner as usize].push(t);
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
        let most = limits.last().map_or(0.0, |limit| limit * limit);
        for t in 0..self.triangles.len() {
            let [a, b, c] = self.triangles[t];
            [[a, b], [b, c], [c, a]].into_iter().filter(|[p, q]| p < q).for_each(|edge| self.enqueue(edge, most));
        }
        limits.iter().map(|limit| self.collapsed(limit * limit, most)).collect()
    }

    /// The surface in which all edges are collapsed whose mean square error is at most `enough` mm2.
    fn collapsed(&mut self, enough: f64, most: f64) -> TriangleMesh {
        while let Some(&Reverse((error, a, b, changes))) = self.queue.peek()
            && f64::from_bits(error) <= enough
        {
            stop::point();
            self.queue.pop();
            if changes == self.changes_of(a, b) {
                self.collapse(a, b, most);
            }
        }
        self.rest()
    }

    fn changes_of(&self, a: u32, b: u32) -> u32 {
        self.changes[a as usize].wrapping_add(self.changes[b as usize])
    }

    fn target(&self, a: u32, b: u32) -> (Vec3, f64) {
        let [p, q] = [a, b].map(|i| i as usize);
        let held = self.held[p] | self.held[q];
        // No edge spans the box.
        if held & held >> 1 & LOWER != 0 {
            return (self.points[p], f64::INFINITY);
        }
        let walls = self.walls.moved(&-self.origin);
        let hold = |x| put(x, held, &walls);
        self.quadrics[p].with(&self.quadrics[q]).best([&self.points[p], &self.points[q]], hold)
    }

    fn enqueue(&mut self, [a, b]: [u32; 2], most: f64) {
        let error = self.target(a, b).1;
        if error <= most {
            self.queue.push(Reverse((error.to_bits(), a.min(b), a.max(b), self.changes_of(a, b))));
        }
    }

    /// The vertices that share a triangle with `a`, ascending.
    fn neighbours(&self, a: u32) -> Vec<u32> {
        let corners = self.around[a as usize].iter().flat_map(|&t| self.triangles[t as usize]);
        let mut neighbours: Vec<u32> = corners.filter(|&corner| corner != a).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// Puts `b` onto `a`, at the best position, where that leaves a closed surface without turned triangles.
    fn collapse(&mut self, a: u32, b: u32, most: f64) {
        let (own, others) = (self.neighbours(a), self.neighbours(b));
        let common = own.iter().filter(|&vertex| others.binary_search(vertex).is_ok()).count();
        // Two ends of valence three would leave two triangles on each other.
        if common != 2 || own.len() + others.len() <= 7 || own.binary_search(&b).is_err() {
            return;
        }
        let (position, _) = self.target(a, b);
        let is_kept =
            |t: &&u32| !(self.triangles[**t as usize].contains(&a) && self.triangles[**t as usize].contains(&b));
        let both = self.around[a as usize].iter().chain(&self.around[b as usize]);
        let kept: Vec<u32> = both.clone().filter(is_kept).copied().collect();
        if !kept.iter().all(|&t| self.stays_upright(t, [a, b], &position)) {
            return;
        }
        let gone: Vec<u32> = self.around[a as usize].iter().copied().filter(|t| !kept.contains(t)).collect();
        for &t in &gone {
            for corner in self.triangles[t as usize] {
                self.around[corner as usize].retain(|other| *other != t);
            }
            self.triangles[t as usize] = [u32::MAX; 3];
        }
        for t in std::mem::take(&mut self.around[b as usize]) {
            let corners = &mut self.triangles[t as usize];
            corners.iter_mut().filter(|corner| **corner == b).for_each(|corner| *corner = a);
            self.around[a as usize].push(t);
        }
        self.points[a as usize] = position;
        self.held[a as usize] |= self.held[b as usize];
        self.quadrics[a as usize] = self.quadrics[a as usize].with(&self.quadrics[b as usize]);
        self.changes[a as usize] += 1;
        self.changes[b as usize] += 1;
        for neighbour in self.neighbours(a) {
            self.enqueue([a, neighbour], most);
        }
    }

    /// True when a triangle with its corner among `moved` at `position` has about its normal, and a shape.
    fn stays_upright(&self, t: u32, moved: [u32; 2], position: &Vec3) -> bool {
        let before = self.corners(t);
        let at = |k: usize| if moved.contains(&self.triangles[t as usize][k]) { *position } else { before[k] };
        let after = [at(0), at(1), at(2)];
        let (old, new) = (cross(&before), cross(&after));
        let longest = (0..3).map(|k| (after[k] - after[(k + 1) % 3]).norm_squared()).fold(0.0, f64::max);
        new.dot(&old) > LEAST_COSINE * new.norm() * old.norm() && new.norm() > LEAST_SHAPE * longest
    }

    /// What is left, with vertices in their order.
    fn rest(&self) -> TriangleMesh {
        let mut number = vec![u32::MAX; self.points.len()];
        let mut vertices = Vec::new();
        for (vertex, around) in self.around.iter().enumerate().filter(|(_, around)| !around.is_empty()) {
            number[vertex] = vertices.len() as u32;
            debug_assert!(around.len() > 2);
            vertices.push(put(self.points[vertex] + self.origin, self.held[vertex], &self.walls));
        }
        let left = self.triangles.iter().filter(|t| t[0] != u32::MAX);
        TriangleMesh { triangles: left.map(|t| t.map(|i| number[i as usize])).collect(), vertices }
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
