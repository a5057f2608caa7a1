//! A surface of facets as triangles of a given size, every facet kept exactly.
//!
//! A plane facet's edges are halved. The number of parts depends on the edge's own length alone, so that surfaces with a common
//! edge divide it alike; the facet between them is filled as a [`plane`](super::plane). Curved facets are fans whose longest edges of all
//! are bisected, which keeps every angle above half the smallest one of the fan (Rosenberg and Stenger 1975), then flipped
//! to Delaunay's.

use super::nodes::Nodes;
use super::plane::{Frame, region};
use super::{Triangles, Untriangulated};
use meso_collision::geometry::Polyhedron;
use meso_collision::math::Vec3;
use meso_concrete::stop;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Edges longer than this share of the element size are bisected: the mean edge then is about the size.
pub(crate) const LONGEST: f64 = 4.0 / 3.0;
/// Passes of flips; Delaunay's state is usually reached in three.
const PASSES: usize = 10;

/// The facets of `body` with edges of about `size` mm.
///
/// # Errors
/// Fails like [`facets`].
pub(crate) fn of_body(body: &Polyhedron, size: f64) -> Result<Triangles, Untriangulated> {
    facets(body.vertices(), body.faces().map(|face| face.to_vec()), LONGEST * size)
}

/// Convex plane facets, their corners in `points` counter-clockwise from outside; no edge is longer than `limit` mm by much.
///
/// # Errors
/// Where a facet has no area, or its edges cross: those of a convex one do not.
pub(crate) fn facets(
    points: &[Vec3],
    polygons: impl IntoIterator<Item = Vec<u32>>,
    limit: f64,
) -> Result<Triangles, Untriangulated> {
    let (mut nodes, mut triangles) = (Nodes::default(), Vec::new());
    for polygon in polygons {
        let corners: Vec<Vec3> = polygon.iter().map(|&corner| points[corner as usize]).collect();
        let frame = Frame::of(&corners);
        if !frame.is_plane() {
            return Err(Untriangulated::new("a facet has no area", &corners[0]));
        }
        triangles.extend(nodes.triangles(&region(frame, &[corners], limit)?));
    }
    Ok(Triangles { points: nodes.points, triangles })
}

/// A curved surface, closed or with a rim, its triangles given with their facets, cut until no edge is longer than `limit` mm.
/// `onto(facet, position)` is where a new node of the facet goes.
pub(crate) fn refined(
    points: Vec<Vec3>,
    triangles: impl IntoIterator<Item = ([u32; 3], u32)>,
    limit: f64,
    onto: impl Fn(u32, Vec3) -> Vec3,
) -> Triangles {
    let mut surface = Refinement::new(points, triangles, onto);
    surface.bisect(limit);
    for _ in 0..PASSES {
        if surface.flip() == 0 {
            break;
        }
    }
    Triangles { points: surface.points, triangles: surface.triangles.into_iter().map(|t| t.0).collect() }
}

/// A surface in the making.
struct Refinement<F> {
    points: Vec<Vec3>,
    /// With their facets.
    triangles: Vec<([u32; 3], u32)>,
    /// The triangle on the left of every directed edge. Looked up, never walked through: its order is no one's.
    left: HashMap<(u32, u32), u32>,
    onto: F,
}

impl<F: Fn(u32, Vec3) -> Vec3> Refinement<F> {
    fn new(points: Vec<Vec3>, triangles: impl IntoIterator<Item = ([u32; 3], u32)>, onto: F) -> Self {
        let triangles: Vec<_> = triangles.into_iter().collect();
        let mut surface = Self { points, triangles, left: HashMap::new(), onto };
        (0..surface.triangles.len()).for_each(|index| surface.enter(index));
        surface
    }

    fn enter(&mut self, index: usize) {
        let [a, b, c] = self.triangles[index].0;
        for edge in [(a, b), (b, c), (c, a)] {
            self.left.insert(edge, index as u32);
        }
    }

    fn squared(&self, a: u32, b: u32) -> f64 {
        (self.points[a as usize] - self.points[b as usize]).norm_squared()
    }

    /// Bisects the longest edge until none is longer than `limit`; of equal ones the one with the lowest nodes.
    fn bisect(&mut self, limit: f64) {
        // Squares of lengths are positive: their bits are in their order.
        let entry = |s: &Self, a: u32, b: u32| (s.squared(a, b).to_bits(), Reverse((a.min(b), a.max(b))));
        let corners = self.triangles.iter().flat_map(|&([a, b, c], _)| [(a, b), (b, c), (c, a)]);
        let once = corners.filter(|&(a, b)| a < b || !self.left.contains_key(&(b, a)));
        let mut heap: BinaryHeap<_> = once.map(|(a, b)| entry(self, a, b)).collect();
        while let Some((bits, Reverse((a, b)))) = heap.pop() {
            if f64::from_bits(bits) <= limit * limit {
                break;
            }
            stop::point();
            for (u, v) in self.split(a, b) {
                heap.push(entry(self, u, v));
            }
        }
    }

    /// Bisects an edge with its two triangles, on a rim the one; returns the new edges.
    fn split(&mut self, a: u32, b: u32) -> Vec<(u32, u32)> {
        let middle = self.points.len() as u32;
        let straight = (self.points[a as usize] + self.points[b as usize]) / 2.0;
        let sides = [(a, b), (b, a)].into_iter().filter_map(|side| self.left.get(&side));
        let facets = sides.map(|&triangle| self.triangles[triangle as usize].1);
        self.points.push(facets.fold(straight, |position, facet| (self.onto)(facet, position)));
        let mut edges = vec![(a, middle), (b, middle)];
        for (u, v) in [(a, b), (b, a)] {
            let Some(index) = self.left.remove(&(u, v)).map(|index| index as usize) else { continue };
            let (nodes, facet) = self.triangles[index];
            let apex = third(nodes, u, v);
            self.triangles[index].0 = [u, middle, apex];
            self.triangles.push(([middle, v, apex], facet));
            self.enter(index);
            self.enter(self.triangles.len() - 1);
            edges.push((middle, apex));
        }
        edges
    }

    /// Flips edges within facets whose opposite angles sum to more than 180 degrees; returns their number.
    fn flip(&mut self) -> usize {
        let mut flips = 0;
        for index in 0..self.triangles.len() {
            for corner in 0..3 {
                let nodes = self.triangles[index].0;
                flips += usize::from(self.flip_edge(nodes[corner], nodes[(corner + 1) % 3]));
            }
        }
        flips
    }

    fn flip_edge(&mut self, a: u32, b: u32) -> bool {
        let [here, there] = [(a, b), (b, a)].map(|edge| self.left.get(&edge).map(|index| *index as usize));
        let Some((here, there)) = here.zip(there) else { return false };
        let facet = self.triangles[here].1;
        if self.triangles[there].1 != facet {
            return false;
        }
        let (c, d) = (third(self.triangles[here].0, a, b), third(self.triangles[there].0, b, a));
        if !self.angles_exceed_a_straight(c, d, a, b) {
            return false;
        }
        self.left.remove(&(a, b));
        self.left.remove(&(b, a));
        self.triangles[here].0 = [a, d, c];
        self.triangles[there].0 = [d, b, c];
        self.enter(here);
        self.enter(there);
        true
    }

    /// Whether the angles at c and d over the edge ab sum to more than 180 degrees: sin(c + d) < 0.
    fn angles_exceed_a_straight(&self, c: u32, d: u32, a: u32, b: u32) -> bool {
        let opening = |apex: u32| {
            let [u, v] = [a, b].map(|end| self.points[end as usize] - self.points[apex as usize]);
            (u.cross(&v).norm(), u.dot(&v))
        };
        let ((c_sine, c_cosine), (d_sine, d_cosine)) = (opening(c), opening(d));
        let scale = (c_sine.abs() + c_cosine.abs()) * (d_sine.abs() + d_cosine.abs());
        c_sine * d_cosine + c_cosine * d_sine < -1e-9 * scale
    }
}

fn third(nodes: [u32; 3], a: u32, b: u32) -> u32 {
    *nodes.iter().find(|node| **node != a && **node != b).expect("a triangle has three nodes")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(surface: &Triangles) -> f64 {
        let of = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|node| surface.points[node as usize]);
            (b - a).cross(&(c - a)).norm() / 2.0
        };
        surface.triangles.iter().map(of).sum()
    }

    /// A facet, turned in space, of which a plane has cut a corner off.
    #[test]
    fn nodes_of_a_facet_with_one_short_edge_are_no_nearer_to_each_other_than_that_edge_makes_them() {
        let (short, limit) = (0.003, 2.0);
        let [u, v] = [Vec3::new(0.6, 0.64, 0.48), Vec3::new(-0.8, 0.48, 0.36)];
        let flat = [[0.0, 0.0], [9.0, 0.0], [9.0, short], [0.0, 6.0]];
        let corners: Vec<Vec3> = flat.iter().map(|[x, y]| Vec3::new(3.0, 4.0, 5.0) + u * *x + v * *y).collect();
        let surface = facets(&corners, [vec![0, 1, 2, 3]], limit).unwrap();
        assert!((area(&surface) - 9.0 * (6.0 + short) / 2.0).abs() < 1e-11);
        let normal = u.cross(&v);
        assert!(surface.points.iter().all(|point| (point - corners[0]).dot(&normal).abs() < 1e-11));
        let mut gaps = Vec::new();
        for (i, a) in surface.points.iter().enumerate() {
            gaps.extend(surface.points[..i].iter().map(|b| (a - b).norm()));
        }
        gaps.sort_by(f64::total_cmp);
        // A fan's halves had nodes 0.0015 and 0.0008 mm apart.
        assert!(surface.points.len() > 20 && (gaps[0] - short).abs() < 1e-12 && gaps[1] > 0.5, "{:?}", &gaps[..3]);
    }

    #[test]
    fn a_facet_without_area_is_named() {
        let corners = [0.0, 1.0, 3.0].map(|x| Vec3::new(x, 0.0, 2.0));
        let error = facets(&corners, [vec![0, 1, 2]], 1.0).unwrap_err().to_string();
        assert_eq!(error, "a facet has no area at 0.000000, 0.000000, 2.000000 mm");
    }

    #[test]
    fn facets_that_share_an_edge_have_the_same_nodes_on_it_and_no_edge_is_much_too_long() {
        let cube = (0..8).map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)) * 7.3);
        let body = meso_collision::geometry::convex_hull(&cube.collect::<Vec<_>>()).unwrap();
        let surface = of_body(&body, 2.0).unwrap();
        assert!((area(&surface) - 6.0 * 7.3 * 7.3).abs() < 1e-10);
        let sides = |[a, b, c]: &[u32; 3]| [[*a, *b], [*b, *c], [*c, *a]];
        let edges: std::collections::BTreeSet<[u32; 2]> = surface.triangles.iter().flat_map(sides).collect();
        assert_eq!(edges.len(), 3 * surface.triangles.len());
        assert!(edges.iter().all(|[a, b]| edges.contains(&[*b, *a])), "closed, and every triangle the same way round");
        let length = |[a, b]: &[u32; 2]| (surface.points[*a as usize] - surface.points[*b as usize]).norm();
        let longest = edges.iter().map(length).fold(0.0, f64::max);
        assert!(longest < 1.5 * LONGEST * 2.0, "{longest}");
    }
}
