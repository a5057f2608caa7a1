//! The element faces where one owner meets mortar or another.

use super::mesh::{Cells, NO_BODY};
use super::owners::Owners;
use meso_concrete::parallel;
use rayon::prelude::*;

/// A face of a cell in a body, with another owner behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InterfaceFace {
    /// The face's nodes, counter-clockwise seen from outside the body; the fourth is `u32::MAX` for triangles.
    pub nodes: [u32; 4],
    /// The cell on the body's side.
    pub cell: u32,
    /// The cell behind the face.
    pub behind: u32,
}

/// The fourth node of a triangle.
pub(crate) const NO_NODE: u32 = u32::MAX;

impl InterfaceFace {
    pub(crate) fn nodes(&self) -> &[u32] {
        &self.nodes[..if self.nodes[3] == NO_NODE { 3 } else { 4 }]
    }
}

/// All interface faces; where two bodies touch, the face is there once for each of them. By cell, then by face.
pub fn faces(mesh: Cells) -> Vec<InterfaceFace> {
    let owners = Owners::of(mesh);
    let mut sides = by_nodes(mesh, |node| owners.are_several(node));
    sides.par_sort_unstable();
    let meets = |pair: &[([u32; 4], u32, u8)]| {
        pair.len() == 2 && mesh.owner[pair[0].1 as usize] != mesh.owner[pair[1].1 as usize]
    };
    let pairs = sides.chunk_by(|a, b| a.0 == b.0).filter(|pair| meets(pair));
    let mut found: Vec<(u32, u8, u32)> =
        pairs.flat_map(|pair| [(pair[0].1, pair[0].2, pair[1].1), (pair[1].1, pair[1].2, pair[0].1)]).collect();
    found.retain(|side| mesh.owner[side.0 as usize] != NO_BODY);
    found.sort_unstable();
    found
        .into_iter()
        .map(|(cell, face, behind)| InterfaceFace { nodes: face_nodes(mesh, cell, face), cell, behind })
        .collect()
}

/// The faces of all cells whose nodes `count`, by their sorted nodes, with the cell and the face's number in it.
pub(crate) fn by_nodes(mesh: Cells, counts: impl Fn(u32) -> bool + Sync) -> Vec<([u32; 4], u32, u8)> {
    let face = |cell: u32, face: u8| {
        let mut nodes = face_nodes(mesh, cell, face);
        let all = nodes.iter().all(|&node| node == NO_NODE || counts(node));
        nodes.sort_unstable();
        all.then_some((nodes, cell, face))
    };
    let (face, faces) = (&face, mesh.kind.faces().len() as u8);
    let of_cell = |cell: usize| (0..faces).filter_map(move |number| face(cell as u32, number));
    parallel::flat_map(mesh.owner.len(), of_cell)
}

fn face_nodes(mesh: Cells, cell: u32, face: u8) -> [u32; 4] {
    let mut nodes = [NO_NODE; 4];
    nodes.iter_mut().zip(mesh.face(cell, face as usize)).for_each(|(node, corner)| *node = corner);
    nodes
}
