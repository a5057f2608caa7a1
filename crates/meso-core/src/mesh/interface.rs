//! The element faces where one aggregate meets mortar or another aggregate.

use super::{Mesh, NO_AGGREGATE};
use rayon::prelude::*;

/// A face of a cell in an aggregate, with another material behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InterfaceFace {
    /// The face's nodes, counter-clockwise seen from outside the aggregate; the fourth is [`NO_NODE`] for triangles.
    pub(crate) nodes: [u32; 4],
    /// The cell on the aggregate's side.
    pub(crate) cell: u32,
    /// The cell behind the face.
    pub(crate) behind: u32,
}

/// The fourth node of a triangle.
pub(crate) const NO_NODE: u32 = u32::MAX;

impl InterfaceFace {
    pub(crate) fn nodes(&self) -> &[u32] {
        &self.nodes[..if self.nodes[3] == NO_NODE { 3 } else { 4 }]
    }
}

/// All interface faces; where two aggregates touch, the face is there once for each of them. By cell, then by face.
pub(crate) fn faces(mesh: &Mesh) -> Vec<InterfaceFace> {
    let mixed = mixed_nodes(mesh);
    let mut sides: Vec<([u32; 4], u32, u8)> =
        (0..mesh.cell_count()).into_par_iter().flat_map_iter(|cell| sides_of(mesh, cell, &mixed)).collect();
    sides.par_sort_unstable();
    let meets = |pair: &[([u32; 4], u32, u8)]| {
        pair.len() == 2 && mesh.aggregate[pair[0].1 as usize] != mesh.aggregate[pair[1].1 as usize]
    };
    let pairs = sides.chunk_by(|a, b| a.0 == b.0).filter(|pair| meets(pair));
    let mut found: Vec<(u32, u8, u32)> =
        pairs.flat_map(|pair| [(pair[0].1, pair[0].2, pair[1].1), (pair[1].1, pair[1].2, pair[0].1)]).collect();
    found.retain(|side| mesh.aggregate[side.0 as usize] != NO_AGGREGATE);
    found.sort_unstable();
    found
        .into_iter()
        .map(|(cell, face, behind)| InterfaceFace { nodes: face_nodes(mesh, cell, face), cell, behind })
        .collect()
}

/// Nodes whose cells are not all of one aggregate, or all of the mortar.
pub(crate) fn mixed_nodes(mesh: &Mesh) -> Vec<bool> {
    let mut first = vec![None; mesh.points.len()];
    let mut mixed = vec![false; mesh.points.len()];
    for (cell, &aggregate) in mesh.cells().zip(&mesh.aggregate) {
        for &node in cell {
            let seen = first[node as usize].get_or_insert(aggregate);
            mixed[node as usize] |= *seen != aggregate;
        }
    }
    mixed
}

/// The faces of a cell that may be an interface, by their sorted nodes.
fn sides_of<'a>(mesh: &'a Mesh, cell: usize, mixed: &'a [bool]) -> impl Iterator<Item = ([u32; 4], u32, u8)> + 'a {
    (0..mesh.kind.faces().len() as u8).filter_map(move |face| {
        let mut nodes = face_nodes(mesh, cell as u32, face);
        let all = nodes.iter().all(|&node| node == NO_NODE || mixed[node as usize]);
        nodes.sort_unstable();
        all.then_some((nodes, cell as u32, face))
    })
}

fn face_nodes(mesh: &Mesh, cell: u32, face: u8) -> [u32; 4] {
    let per_cell = mesh.kind.nodes();
    let cell = &mesh.cells[cell as usize * per_cell..][..per_cell];
    let mut nodes = [NO_NODE; 4];
    for (node, &at) in nodes.iter_mut().zip(mesh.kind.faces()[face as usize]) {
        *node = cell[at];
    }
    nodes
}
