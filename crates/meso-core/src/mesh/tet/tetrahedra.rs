//! The mesh itself: nodes, cells, and the body that owns each cell.

use super::quality::{min_dihedral_cos2, volume};
use crate::math::Vec3;
use crate::mesh::cells::{CellKind, Cells};
use rayon::prelude::*;

/// A cell that was removed; [`TetMesh::drop_removed`] takes it out.
const REMOVED: [u32; 4] = [u32::MAX; 4];
/// The new number of a node that is dropped.
pub(in crate::mesh) const DROPPED: u32 = u32::MAX;

/// A tetrahedral mesh.
#[derive(Clone, Debug, Default)]
pub(in crate::mesh) struct TetMesh {
    /// Positions, mm.
    pub(in crate::mesh) points: Vec<Vec3>,
    /// Node indices; positive volume in Abaqus' order.
    pub(in crate::mesh) cells: Vec<[u32; 4]>,
    /// Index of the body (an aggregate, a fibre, a void, or an image of one) that each cell lies in, or
    /// [`NO_BODY`](crate::mesh::cells::NO_BODY) in the mortar.
    pub(in crate::mesh) owner: Vec<u32>,
}

impl TetMesh {
    /// The cells by their bodies' indices.
    pub(in crate::mesh) fn by_body(&self) -> Cells<'_> {
        Cells {
            kind: CellKind::Tetrahedron,
            points: &self.points,
            nodes: self.cells.as_flattened(),
            owner: &self.owner,
        }
    }

    pub(in crate::mesh) fn position(&self, node: u32) -> Vec3 {
        self.points[node as usize]
    }

    pub(in crate::mesh) fn cell(&self, cell: u32) -> [u32; 4] {
        self.cells[cell as usize]
    }

    /// The nodes of a cell, and its owner.
    pub(in crate::mesh) fn owned(&self, cell: u32) -> ([u32; 4], u32) {
        (self.cells[cell as usize], self.owner[cell as usize])
    }

    pub(in crate::mesh) fn corners(&self, nodes: [u32; 4]) -> [Vec3; 4] {
        nodes.map(|node| self.points[node as usize])
    }

    /// The [`min_dihedral_cos2`] of a cell.
    pub(in crate::mesh) fn cos2(&self, cell: u32) -> f64 {
        min_dihedral_cos2(self.corners(self.cell(cell)))
    }

    /// Volume of a cell, mm3.
    pub(in crate::mesh) fn volume(&self, cell: u32) -> f64 {
        volume(self.corners(self.cell(cell)))
    }

    /// The numbers of all cells.
    pub(in crate::mesh) fn numbers(&self) -> std::ops::Range<u32> {
        0..self.cells.len() as u32
    }

    /// Adds a cell; its number.
    pub(in crate::mesh) fn push(&mut self, nodes: [u32; 4], owner: u32) -> u32 {
        self.cells.push(nodes);
        self.owner.push(owner);
        self.cells.len() as u32 - 1
    }

    /// Removes a cell; its number stays taken until [`drop_removed`](Self::drop_removed).
    pub(in crate::mesh) fn remove(&mut self, cell: u32) {
        self.cells[cell as usize] = REMOVED;
    }

    pub(in crate::mesh) fn is_removed(&self, cell: u32) -> bool {
        self.cells[cell as usize] == REMOVED
    }

    /// Contracts `node` onto `into`, `around` being the cells of `node`: those that have both are removed.
    pub(in crate::mesh) fn contract(&mut self, node: u32, into: u32, around: &[u32]) {
        for &cell in around {
            let nodes = &mut self.cells[cell as usize];
            if nodes.contains(&into) {
                *nodes = REMOVED;
            } else {
                nodes.iter_mut().filter(|of| **of == node).for_each(|of| *of = into);
            }
        }
    }

    /// Takes the removed cells out; for every cell whether it stayed.
    pub(in crate::mesh) fn drop_removed(&mut self) -> Vec<bool> {
        let kept: Vec<bool> = self.cells.iter().map(|cell| *cell != REMOVED).collect();
        let mut keep = kept.iter();
        self.owner.retain(|_| keep.next() == Some(&true));
        self.cells.retain(|cell| *cell != REMOVED);
        kept
    }

    /// Takes the nodes without cells out, and numbers the others anew in their order; the new numbers, or [`DROPPED`].
    pub(in crate::mesh) fn drop_lone_nodes(&mut self) -> Vec<u32> {
        let mut number = vec![DROPPED; self.points.len()];
        self.cells.iter().flatten().for_each(|&node| number[node as usize] = 0);
        for (count, number) in (0..).zip(number.iter_mut().filter(|number| **number != DROPPED)) {
            *number = count;
        }
        let mut old = number.iter();
        self.points.retain(|_| old.next() != Some(&DROPPED));
        self.cells.par_iter_mut().flatten().for_each(|node| *node = number[*node as usize]);
        number
    }
}

/// The same nodes in the order of positive volume.
pub(in crate::mesh) fn oriented(cell: [u32; 4], points: &[Vec3]) -> [u32; 4] {
    let [a, b, c, d] = cell;
    let p = |node: u32| points[node as usize] - points[a as usize];
    if p(b).cross(&p(c)).dot(&p(d)) < 0.0 { [a, c, b, d] } else { cell }
}
