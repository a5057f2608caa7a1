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
    let owners = Owners::of(mesh);
    let mut sides: Vec<([u32; 4], u32, u8)> =
        (0..mesh.cell_count()).into_par_iter().flat_map_iter(|cell| sides_of(mesh, cell, &owners)).collect();
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

/// Whose cells meet at every node: ids of aggregates, or [`NO_AGGREGATE`] for the mortar.
pub(crate) struct Owners {
    /// One of them.
    one: Vec<u32>,
    /// Another, where there is another; else the same.
    other: Vec<u32>,
    /// All further ones with their nodes, in order.
    further: Vec<(u32, u32)>,
}

impl Owners {
    /// The owners of all nodes, but for those in the middle of edges.
    pub(crate) fn of(mesh: &Mesh) -> Self {
        let corners = mesh.kind.corners();
        let owned = || {
            let cells = mesh.cells().zip(&mesh.aggregate);
            cells.flat_map(|(cell, &owner)| cell[..corners].iter().map(move |&node| (node, owner)))
        };
        let mut one = vec![NO_AGGREGATE; mesh.points.len()];
        owned().for_each(|(node, owner)| one[node as usize] = owner);
        let (mut other, mut further) = (one.clone(), Vec::new());
        for (node, owner) in owned().filter(|&(node, owner)| one[node as usize] != owner) {
            let seen = &mut other[node as usize];
            if *seen == one[node as usize] {
                *seen = owner;
            } else if *seen != owner {
                further.push((node, owner));
            }
        }
        further.sort_unstable();
        further.dedup();
        Self { one, other, further }
    }

    /// True where the cells are not all of one aggregate, nor all of the mortar.
    pub(crate) fn are_several(&self, node: u32) -> bool {
        self.one[node as usize] != self.other[node as usize]
    }

    /// Nodes with the aggregates that own them, each pair once, in order; only the nodes that `asked` picks.
    pub(crate) fn aggregates(&self, asked: impl Fn(u32) -> bool) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for (node, (&one, &other)) in (0..).zip(self.one.iter().zip(&self.other)).filter(|(node, _)| asked(*node)) {
            pairs.push((node, one.min(other)));
            if one != other {
                pairs.push((node, one.max(other)));
            }
        }
        pairs.extend(self.further.iter().filter(|(node, _)| asked(*node)));
        pairs.retain(|(_, owner)| *owner != NO_AGGREGATE);
        // Two runs in order: the stable sort merges them.
        pairs.sort();
        pairs
    }
}

/// The faces of a cell that may be an interface, by their sorted nodes.
fn sides_of<'a>(mesh: &'a Mesh, cell: usize, owners: &'a Owners) -> impl Iterator<Item = ([u32; 4], u32, u8)> + 'a {
    (0..mesh.kind.faces().len() as u8).filter_map(move |face| {
        let mut nodes = face_nodes(mesh, cell as u32, face);
        let all = nodes.iter().all(|&node| node == NO_NODE || owners.are_several(node));
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
