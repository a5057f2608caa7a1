//! The tetrahedra around one node: what a move of the node does to them.

use super::Tetrahedra;
use crate::math::Vec3;
use crate::mesh::quality::dihedral_cosines;
use std::collections::HashMap;

/// For every node the tetrahedra around it, as indices.
pub(super) struct Stars {
    start: Vec<u32>,
    cells: Vec<u32>,
}

impl Stars {
    /// The stars of the nodes that `wanted` marks; the others' are empty.
    pub(super) fn new(mesh: &Tetrahedra, wanted: &[bool]) -> Self {
        let mut start = vec![0_u32; mesh.points.len() + 1];
        let corners = || mesh.cells.iter().flatten().filter(|&&node| wanted[node as usize]);
        corners().for_each(|&node| start[node as usize + 1] += 1);
        (1..start.len()).for_each(|i| start[i] += start[i - 1]);
        let mut next = start.clone();
        let mut cells = vec![0; corners().count()];
        for (index, cell) in mesh.cells.iter().enumerate() {
            for &node in cell.iter().filter(|&&node| wanted[node as usize]) {
                cells[next[node as usize] as usize] = index as u32;
                next[node as usize] += 1;
            }
        }
        Self { start, cells }
    }

    pub(super) fn cells(&self, node: u32) -> &[u32] {
        &self.cells[self.start[node as usize] as usize..self.start[node as usize + 1] as usize]
    }
}

/// Positions with the moves made so far in one patch.
pub(super) struct Moved<'a> {
    pub(super) points: &'a [Vec3],
    pub(super) moves: HashMap<u32, Vec3>,
}

impl Moved<'_> {
    pub(super) fn at(&self, node: u32) -> Vec3 {
        self.moves.get(&node).copied().unwrap_or(self.points[node as usize])
    }
}

/// The star of one node: its tetrahedra as the opposite faces (a, b, c), with positive volume over the node.
pub(super) struct Star {
    pub(super) centre: Vec3,
    faces: Vec<([Vec3; 3], u32)>,
}

impl Star {
    pub(super) fn new(mesh: &Tetrahedra, stars: &Stars, node: u32, moved: &Moved) -> Self {
        let face = |&cell: &u32| {
            let nodes = mesh.cells[cell as usize];
            let at = nodes.iter().position(|&n| n == node).expect("a star's cells hold its node");
            // Even permutations that bring the node to the front.
            let [i, j, k] = [[1, 2, 3], [0, 3, 2], [3, 0, 1], [2, 1, 0]][at];
            ([nodes[i], nodes[j], nodes[k]].map(|n| moved.at(n)), mesh.grain[cell as usize])
        };
        Self { centre: moved.at(node), faces: stars.cells(node).iter().map(face).collect() }
    }

    /// Cosine of the smallest dihedral angle with the node at `x`, 2 where a tetrahedron has no positive volume. The search
    /// ends at the first angle whose cosine exceeds `limit`.
    pub(super) fn worst(&self, x: &Vec3, limit: f64) -> f64 {
        let mut worst: f64 = -1.0;
        for ([a, b, c], _) in &self.faces {
            if (a - x).cross(&(b - x)).dot(&(c - x)) <= 0.0 {
                return 2.0;
            }
            worst = worst.max(dihedral_cosines([*x, *a, *b, *c])[1]);
            if worst > limit {
                break;
            }
        }
        worst
    }

    /// Six times the volume that the star's tetrahedra of `grain` gain for a move of the node by a unit vector: the
    /// volume is linear in the node's place.
    pub(super) fn gain(&self, grain: u32) -> Vec3 {
        let faces = self.faces.iter().filter(|(_, label)| *label == grain);
        -faces.map(|([a, b, c], _)| (b - a).cross(&(c - a))).sum::<Vec3>()
    }

    /// Mean of the surrounding nodes, each as often as it occurs.
    pub(super) fn mean(&self) -> Vec3 {
        let sum: Vec3 = self.faces.iter().flat_map(|(face, _)| face).sum();
        sum / (3 * self.faces.len()) as f64
    }
}
