//! Tetrahedra without volume that gmsh leaves on the plane faces of a periodic box, where it had to recover an edge.
//!
//! Such a one has both diagonals of a quadrilateral on the face: one is an edge of the surface, the other was Delaunay's.
//! A node where they cross divides every cell of the two, and the flat one is gone; the opposite face gets the same node.

use crate::math::{Aabb, Vec3};
use crate::mesh::tet::TetMesh;
use crate::packing::Period;
use std::collections::BTreeMap;

/// Most tetrahedra that are opened on a pair of faces: before the faces' nodes were smoothed one of 35 meshes of 40,000
/// cells had some.
const MOST: usize = 10_000;

/// Opens the flat tetrahedra of `mesh` on the faces of `domain` across which the box repeats itself.
pub(super) fn open(mesh: &mut TetMesh, period: &Period, domain: &Aabb) {
    for axis in (0..3).filter(|&axis| period.along(axis).is_some()) {
        let faces = Faces { axis, places: [domain.min[axis], domain.max[axis]] };
        let flat: Vec<u32> = (0..mesh.cells.len() as u32).rev().filter(|&cell| faces.have(mesh, cell)).collect();
        if !flat.is_empty() {
            Opened::new(mesh, faces).open(flat);
        }
    }
}

/// Two opposite faces.
struct Faces {
    axis: usize,
    places: [f64; 2],
}

impl Faces {
    /// True when a cell lies in one of them with all its corners.
    fn have(&self, mesh: &TetMesh, cell: u32) -> bool {
        let [first, rest @ ..] = mesh.cells[cell as usize].map(|node| mesh.points[node as usize][self.axis]);
        self.places.contains(&first) && rest.iter().all(|place| *place == first)
    }

    /// The corners of a flat tetrahedron, those of its edges that cross first and last.
    fn quad(&self, [a, b, c, d]: [Vec3; 4]) -> Option<[Vec3; 4]> {
        [[a, b, c, d], [a, c, b, d], [a, d, b, c]].into_iter().find(|quad| do_cross(quad, self.axis))
    }
}

/// The mesh, and what finds its nodes and cells at a pair of faces.
struct Opened<'a> {
    mesh: &'a mut TetMesh,
    faces: Faces,
    /// The nodes on the faces by their places.
    nodes: BTreeMap<[u64; 3], u32>,
    /// The cells of each of these, and some that are removed.
    cells: BTreeMap<u32, Vec<u32>>,
}

impl<'a> Opened<'a> {
    fn new(mesh: &'a mut TetMesh, faces: Faces) -> Self {
        let on = |node: &u32| faces.places.contains(&mesh.points[*node as usize][faces.axis]);
        let nodes = (0..mesh.points.len() as u32).filter(on).map(|node| (key(&mesh.points[node as usize]), node));
        let nodes: BTreeMap<[u64; 3], u32> = nodes.collect();
        let mut cells: BTreeMap<u32, Vec<u32>> = nodes.values().map(|node| (*node, Vec::new())).collect();
        for (number, cell) in (0..).zip(&mesh.cells) {
            for node in cell {
                if let Some(own) = cells.get_mut(node) {
                    own.push(number);
                }
            }
        }
        Self { mesh, faces, nodes, cells }
    }

    /// Opens the cells in `flat`, the last first, and what becomes flat by that.
    fn open(mut self, mut flat: Vec<u32>) {
        let mut left = MOST;
        while let Some(cell) = flat.pop().filter(|_| left > 0) {
            if self.mesh.is_removed(cell) {
                continue;
            }
            let Some(quad) = self.faces.quad(self.mesh.corners(self.mesh.cell(cell))) else { continue };
            let middle = crossing(quad, self.faces.axis);
            for place in self.faces.places {
                let moved = |point: Vec3| Vec3::from_fn(|i, _| if i == self.faces.axis { place } else { point[i] });
                let first = self.mesh.cells.len() as u32;
                self.divide(quad.map(moved), moved(middle));
                flat.extend((first..self.mesh.cells.len() as u32).filter(|&new| self.faces.have(self.mesh, new)));
            }
            left -= 1;
        }
        self.mesh.drop_removed();
    }

    /// Divides the cells that have the edge ab or cd at a new node in the `middle` of both; those that have both go.
    fn divide(&mut self, quad: [Vec3; 4], middle: Vec3) {
        let [Some(a), Some(b), Some(c), Some(d)] = quad.map(|place| self.nodes.get(&key(&place)).copied()) else {
            return;
        };
        let new = self.mesh.points.len() as u32;
        self.mesh.points.push(middle);
        self.nodes.insert(key(&middle), new);
        self.cells.insert(new, Vec::new());
        let mut around = [&self.cells[&a][..], &self.cells[&c][..]].concat();
        around.sort_unstable();
        around.dedup();
        for number in around.into_iter().filter(|number| !self.mesh.is_removed(*number)).collect::<Vec<_>>() {
            let (cell, owner) = self.mesh.owned(number);
            let has = |p: u32, q: u32| cell.contains(&p) && cell.contains(&q);
            let half = |end: u32| cell.map(|node| if node == end { new } else { node });
            let parts = match (has(a, b), has(c, d)) {
                (false, false) => continue,
                (true, false) => vec![half(a), half(b)],
                (false, true) => vec![half(c), half(d)],
                (true, true) => vec![],
            };
            self.mesh.remove(number);
            parts.into_iter().for_each(|part| self.add(part, owner));
        }
    }

    fn add(&mut self, cell: [u32; 4], owner: u32) {
        let number = self.mesh.push(cell, owner);
        cell.iter().for_each(|node| {
            if let Some(own) = self.cells.get_mut(node) {
                own.push(number);
            }
        });
    }
}

/// A place as what can be looked up: -0 and 0 are one.
fn key(place: &Vec3) -> [u64; 3] {
    [0, 1, 2].map(|axis| (place[axis] + 0.0).to_bits())
}

/// Twice the area of the triangle from a over b to c, seen along `axis`.
pub(super) fn turn(axis: usize, a: &Vec3, b: &Vec3, c: &Vec3) -> f64 {
    (b - a).cross(&(c - a))[axis]
}

/// Whether ab and cd cross, seen along `axis`.
pub(super) fn do_cross([a, b, c, d]: &[Vec3; 4], axis: usize) -> bool {
    turn(axis, a, b, c) * turn(axis, a, b, d) < 0.0 && turn(axis, c, d, a) * turn(axis, c, d, b) < 0.0
}

/// Where ab and cd cross, seen along `axis`; across it the place is on ab.
pub(super) fn crossing([a, b, c, d]: [Vec3; 4], axis: usize) -> Vec3 {
    let turn = |p: Vec3, q: Vec3| p.cross(&q)[axis];
    a + (b - a) * (turn(c - a, d - c) / turn(b - a, d - c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packing::Periodic;

    #[test]
    fn a_flat_tetrahedron_on_a_face_is_opened_there_and_opposite_to_it() {
        let square = |z: f64| [[1.0, 0.0, z], [0.0, 1.0, z], [0.2, 0.1, z], [1.0, 1.0, z]].map(Vec3::from);
        let apexes = [Vec3::new(0.5, 0.5, 1.0), Vec3::new(0.5, 0.5, 3.0)];
        // The lower face has the edge 0-1, under which gmsh took 2-3; the upper one has 0-1 alone.
        let cells = vec![[2, 3, 0, 8], [2, 3, 1, 8], [0, 1, 2, 3], [4, 5, 6, 9], [4, 5, 7, 9]];
        let points = [&square(0.0)[..], &square(4.0), &apexes].concat();
        let mut mesh = TetMesh { points, cells, owner: vec![1, 1, 1, 2, 2] };
        let size = Vec3::repeat(4.0);
        let domain = Aabb { min: Vec3::zeros(), max: size };
        let volume = |mesh: &TetMesh| -> [f64; 2] {
            [1, 2].map(|tag| {
                let own = mesh.cells.iter().zip(&mesh.owner).filter(|(_, volume)| **volume == tag);
                own.map(|(cell, _)| {
                    let [a, b, c, d] = cell.map(|node| mesh.points[node as usize]);
                    (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
                })
                .sum()
            })
        };
        let before = volume(&mesh);
        open(&mut mesh, &Period::new(&size, Periodic([false, false, true])), &domain);
        assert_eq!((mesh.cells.len(), mesh.points.len()), (8, 12));
        assert!(volume(&mesh).iter().zip(before).all(|(after, before)| (after - before).abs() < 1e-15));
        let [low, high] = [mesh.points[10], mesh.points[11]];
        assert!(low.z == 0.0 && high.z == 4.0 && low.xy() == high.xy());
        assert!((low.x + low.y - 1.0).abs() < 1e-15, "on the edge 0-1: {low}");
        let flat = |cell: &[u32; 4]| cell.iter().all(|&node| mesh.points[node as usize].z == 0.0);
        assert!(!mesh.cells.iter().any(flat));
    }
}
