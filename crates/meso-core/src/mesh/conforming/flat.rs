//! Tetrahedra without volume that gmsh leaves on the plane faces of a periodic box, where it had to recover an edge.
//!
//! Such a one has both diagonals of a quadrilateral on the face: one is an edge of the surface, the other was Delaunay's.
//! A node where they cross divides every cell of the two, and the flat one is gone; the opposite face gets the same node.

use super::msh::Volumes;
use crate::math::{Aabb, Vec3};
use crate::packing::Period;

/// Most tetrahedra that are opened: before the faces' nodes were smoothed one of 35 meshes of 40,000 cells had some.
const MOST: usize = 10_000;

/// Opens the flat tetrahedra of `mesh` on the faces of `domain` across which the box repeats itself.
pub(super) fn open(mesh: &mut Volumes, period: &Period, domain: &Aabb) {
    for axis in (0..3).filter(|&axis| period.along(axis).is_some()) {
        let faces = Faces { axis, places: [domain.min[axis], domain.max[axis]] };
        for _ in 0..MOST {
            let Some(quad) = faces.flat(mesh) else { break };
            let middle = crossing(quad, axis);
            for place in faces.places {
                let moved = |point: Vec3| Vec3::from_fn(|i, _| if i == axis { place } else { point[i] });
                divide(mesh, quad.map(moved), moved(middle));
            }
        }
    }
}

/// Two opposite faces.
struct Faces {
    axis: usize,
    places: [f64; 2],
}

impl Faces {
    /// The corners of a flat tetrahedron, those of its edges that cross first and last.
    fn flat(&self, mesh: &Volumes) -> Option<[Vec3; 4]> {
        let corners = |cell: &[u32; 4]| cell.map(|node| mesh.points[node as usize]);
        let on = |cell: &[Vec3; 4]| {
            let first = cell[0][self.axis];
            self.places.contains(&first) && cell.iter().all(|corner| corner[self.axis] == first)
        };
        mesh.cells.iter().map(corners).filter(on).find_map(|[a, b, c, d]| {
            [[a, b, c, d], [a, c, b, d], [a, d, b, c]].into_iter().find(|quad| self.cross(quad))
        })
    }

    fn cross(&self, &[a, b, c, d]: &[Vec3; 4]) -> bool {
        let turn = |p: Vec3, q: Vec3, r: Vec3| (q - p).cross(&(r - p))[self.axis];
        turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
    }
}

/// Divides the cells that have the edge ab or cd at a new node in the `middle` of both; those that have both go.
fn divide(mesh: &mut Volumes, quad: [Vec3; 4], middle: Vec3) {
    let node = |place: Vec3| mesh.points.iter().position(|point| *point == place).map(|node| node as u32);
    let [Some(a), Some(b), Some(c), Some(d)] = quad.map(node) else { return };
    let new = mesh.points.len() as u32;
    mesh.points.push(middle);
    let old = (std::mem::take(&mut mesh.cells), std::mem::take(&mut mesh.volume));
    for (cell, volume) in old.0.into_iter().zip(old.1) {
        let has = |p: u32, q: u32| cell.contains(&p) && cell.contains(&q);
        let half = |end: u32| cell.map(|node| if node == end { new } else { node });
        let parts = match (has(a, b), has(c, d)) {
            (false, false) => vec![cell],
            (true, false) => vec![half(a), half(b)],
            (false, true) => vec![half(c), half(d)],
            (true, true) => vec![],
        };
        mesh.volume.extend(std::iter::repeat_n(volume, parts.len()));
        mesh.cells.extend(parts);
    }
}

/// Where ab and cd cross, seen along `axis`.
fn crossing([a, b, c, d]: [Vec3; 4], axis: usize) -> Vec3 {
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
        let mut mesh = Volumes { points, cells, volume: vec![1, 1, 1, 2, 2] };
        let size = Vec3::repeat(4.0);
        let domain = Aabb { min: Vec3::zeros(), max: size };
        let volume = |mesh: &Volumes| -> [f64; 2] {
            [1, 2].map(|tag| {
                let own = mesh.cells.iter().zip(&mesh.volume).filter(|(_, volume)| **volume == tag);
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
