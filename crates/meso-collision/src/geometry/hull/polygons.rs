//! Polygonal faces of triangles: coplanar neighbours merge, points inside edges and faces drop out.
//!
//! On a convex surface the triangles of one plane are connected. A surface point with fewer than three planes around
//! it lies inside a face (one) or an edge (two): it is not extreme.

use super::surface::{Surface, Triangle};
use crate::math::Vec3;

/// Faces as loops of point indices, counter-clockwise from outside.
#[derive(Clone, Debug, Default)]
pub(super) struct Polygons {
    /// Corners of all faces, one face after the other.
    pub(super) corners: Vec<u32>,
    /// One past the last corner of each face.
    pub(super) ends: Vec<u32>,
    /// Union-find parents of the coplanar triangles, by facet.
    plane: Vec<u32>,
    /// Number of edges between two planes at a point, by point.
    degree: Vec<u32>,
    traced: Vec<bool>,
    /// By point, where in the order the next face is to stand whose smallest corner it is.
    next: Vec<u32>,
    /// Second corner, start and end of each face, in order.
    order: Vec<[u32; 3]>,
    sorted: Vec<u32>,
}

impl Polygons {
    /// Collects the faces of a finished surface.
    pub(super) fn collect(&mut self, surface: &Surface, points: &[Vec3]) {
        self.corners.clear();
        self.ends.clear();
        if self.join_coplanar(surface, points) {
            self.count_edges(surface, points.len());
            self.trace_all(surface);
        } else {
            for (_, facet) in surface.facets() {
                self.corners.extend(facet.vertices);
                self.ends.push(self.corners.len() as u32);
            }
        }
    }

    /// Rotates every face to begin with its smallest index, and sorts the faces by their first two; there are
    /// `points` points.
    pub(super) fn sort(&mut self, points: usize) {
        let Self { corners, ends, next, order, sorted, .. } = self;
        next.clear();
        next.resize(points + 1, 0);
        let mut start = 0;
        for &end in &*ends {
            let face = &mut corners[start as usize..end as usize];
            turn_to_smallest(face);
            next[face[0] as usize + 1] += 1;
            start = end;
        }
        for point in 0..points {
            next[point + 1] += next[point];
        }
        order.resize(ends.len(), [0; 3]);
        start = 0;
        for &end in &*ends {
            let slot = &mut next[corners[start as usize] as usize];
            order[*slot as usize] = [corners[start as usize + 1], start, end];
            *slot += 1;
            start = end;
        }
        // Every entry now says where its point's faces end. A directed edge belongs to one face alone: no two are equal.
        let mut begin = 0;
        for &end in &next[..points] {
            order[begin as usize..end as usize].sort_unstable_by_key(|face| face[0]);
            begin = end;
        }
        sorted.clear();
        ends.clear();
        for &[_, start, end] in &*order {
            sorted.extend_from_slice(&corners[start as usize..end as usize]);
            ends.push(sorted.len() as u32);
        }
        std::mem::swap(corners, sorted);
    }

    /// Joins coplanar neighbours; false where there are none.
    fn join_coplanar(&mut self, surface: &Surface, points: &[Vec3]) -> bool {
        self.plane.clear();
        self.plane.extend(0..surface.facet_bound() as u32);
        let mut joined = false;
        for (f, facet) in surface.facets() {
            for (k, &g) in facet.neighbours.iter().enumerate().filter(|(_, g)| f < **g) {
                if surface.in_plane(points, f, beyond(facet, k, surface.facet(g))) {
                    let (f, g) = (self.find(f), self.find(g));
                    self.plane[f.max(g) as usize] = f.min(g);
                    joined = true;
                }
            }
        }
        for (f, _) in surface.facets().filter(|_| joined) {
            self.plane[f as usize] = self.find(f);
        }
        joined
    }

    fn find(&mut self, mut f: u32) -> u32 {
        while self.plane[f as usize] != f {
            let parent = self.plane[f as usize];
            self.plane[f as usize] = self.plane[parent as usize];
            f = parent;
        }
        f
    }

    fn between_planes(&self, f: u32, g: u32) -> bool {
        self.plane[f as usize] != self.plane[g as usize]
    }

    fn count_edges(&mut self, surface: &Surface, points: usize) {
        self.degree.clear();
        self.degree.resize(points, 0);
        for (f, facet) in surface.facets() {
            for k in 0..3 {
                // The neighbour counts the same edge at its other end.
                if self.between_planes(f, facet.neighbours[k]) {
                    self.degree[facet.vertices[k] as usize] += 1;
                }
            }
        }
    }

    fn trace_all(&mut self, surface: &Surface) {
        self.traced.clear();
        self.traced.resize(surface.facet_bound(), false);
        for (f, facet) in surface.facets() {
            let plane = self.plane[f as usize] as usize;
            if self.traced[plane] {
                continue;
            }
            if let Some(k) = (0..3).find(|&k| self.between_planes(f, facet.neighbours[k])) {
                self.traced[plane] = true;
                self.trace(surface, f, k);
            }
        }
    }

    /// Follows the rim of a plane's triangles from the edge `k` of facet `f`, and keeps its extreme points.
    fn trace(&mut self, surface: &Surface, f: u32, k: usize) {
        let mut edge = (f, k);
        loop {
            let corner = surface.facet(edge.0).vertices[edge.1];
            if self.degree[corner as usize] >= 3 {
                self.corners.push(corner);
            }
            edge = self.next_rim_edge(surface, edge);
            if edge == (f, k) {
                break;
            }
        }
        self.ends.push(self.corners.len() as u32);
    }

    /// The next edge of the rim: around the end of this one, through triangles of the same plane.
    fn next_rim_edge(&self, surface: &Surface, (mut f, k): (u32, usize)) -> (u32, usize) {
        let end = surface.facet(f).vertices[(k + 1) % 3];
        let mut k = (k + 1) % 3;
        loop {
            let g = surface.facet(f).neighbours[k];
            if self.between_planes(f, g) {
                return (f, k);
            }
            f = g;
            k = surface.facet(f).vertices.iter().position(|&v| v == end).expect("neighbours share an edge");
        }
    }
}

/// Nearly all faces are triangles; these are turned without a search.
fn turn_to_smallest(face: &mut [u32]) {
    if let [a, b, c] = *face {
        let turned = if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        };
        face.copy_from_slice(&turned);
    } else if let Some((smallest, _)) = face.iter().enumerate().min_by_key(|(_, corner)| **corner) {
        face.rotate_left(smallest);
    }
}

/// The vertex that `neighbour` does not share with edge `k` of `facet`: all five in exclusive or leave it alone.
fn beyond(facet: &Triangle, k: usize, neighbour: &Triangle) -> u32 {
    let [a, b, c] = neighbour.vertices;
    a ^ b ^ c ^ facet.vertices[k] ^ facet.vertices[(k + 1) % 3]
}
