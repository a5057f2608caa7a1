//! The element faces where one owner meets mortar or another; and the nodes that owners get of their own there, for a layer or
//! cohesive elements to go between.

use super::cells::{Cells, Mesh, NO_AGGREGATE, NO_BODY, Phase};
use super::tet::TetMesh;
use crate::math::Vec3;
use crate::parallel;
use crate::stop;
use rayon::prelude::*;

/// A face of a cell in a body, with another owner behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct InterfaceFace {
    /// The face's nodes, counter-clockwise seen from outside the body; the fourth is [`NO_NODE`] for triangles.
    pub(crate) nodes: [u32; 4],
    /// The cell on the body's side.
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

/// All interface faces; where two bodies touch, the face is there once for each of them. By cell, then by face.
pub(crate) fn faces(mesh: Cells) -> Vec<InterfaceFace> {
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

impl Mesh {
    /// Whose cells meet at every node, of the cells alone whose numbers `counts` picks.
    #[doc(hidden)]
    pub fn owners(&self, counts: impl Fn(usize) -> bool) -> Owners {
        Owners::among(self.by_aggregate(), counts)
    }
}

/// Whose cells meet at every node.
pub struct Owners {
    /// One of them, [`NO_BODY`] where no cell counts.
    one: Vec<u32>,
    /// Another, where there is another; else the same.
    other: Vec<u32>,
    /// All further ones with their nodes, in order.
    further: Vec<(u32, u32)>,
}

impl Owners {
    /// The owners of all nodes, but for those in the middle of edges.
    pub(crate) fn of(mesh: Cells) -> Self {
        Self::among(mesh, |_| true)
    }

    /// The same where only the cells count whose numbers `counts` picks.
    pub(crate) fn among(mesh: Cells, counts: impl Fn(usize) -> bool) -> Self {
        let corners = mesh.kind.corners();
        let owned = || {
            let cells = mesh.iter().zip(mesh.owner).enumerate().filter(|(cell, _)| counts(*cell));
            cells.flat_map(|(_, (cell, &owner))| {
                stop::point();
                cell[..corners].iter().map(move |&node| (node, owner))
            })
        };
        let mut one = vec![NO_BODY; mesh.points.len()];
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

    /// True where the cells are not all of one owner.
    pub fn are_several(&self, node: u32) -> bool {
        self.one[node as usize] != self.other[node as usize]
    }

    /// The owner of the last cell around a node that counts.
    pub fn last(&self, node: u32) -> u32 {
        self.one[node as usize]
    }

    /// The body of a node that has cells of it and of the mortar, and no others.
    pub(crate) fn beside_mortar(&self, node: u32) -> Option<u32> {
        let has_further = || self.further.binary_search_by_key(&node, |(node, _)| *node).is_ok();
        match [self.one[node as usize], self.other[node as usize]] {
            [one, other] if one == other || has_further() => None,
            [NO_BODY, body] | [body, NO_BODY] => Some(body),
            _ => None,
        }
    }

    /// The body of a node that has one alone; none for nodes that came after.
    pub(crate) fn only(&self, node: u32) -> Option<u32> {
        let one = *self.one.get(node as usize).filter(|one| **one != NO_BODY)?;
        (!self.are_several(node)).then_some(one)
    }

    /// Pairs of bodies that share a node, each once, in order.
    pub fn pairs(&self) -> Vec<(u32, u32)> {
        pairs(&self.bodies(|node| self.are_several(node)))
    }

    /// Nodes with the bodies that own them, each pair once, in order; only the nodes that `asked` picks.
    pub(crate) fn bodies(&self, asked: impl Fn(u32) -> bool) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for (node, (&one, &other)) in (0..).zip(self.one.iter().zip(&self.other)).filter(|(node, _)| asked(*node)) {
            pairs.push((node, one.min(other)));
            if one != other {
                pairs.push((node, one.max(other)));
            }
        }
        pairs.extend(self.further.iter().filter(|(node, _)| asked(*node)));
        pairs.retain(|(_, owner)| *owner != NO_BODY);
        // Two runs in order: the stable sort merges them.
        pairs.sort();
        pairs
    }
}

/// The pairs of bodies at the same node of `members`, nodes with their bodies in order; each once, in order.
pub(crate) fn pairs(members: &[(u32, u32)]) -> Vec<(u32, u32)> {
    fn each(meet: &[(u32, u32)]) -> impl Iterator<Item = (u32, u32)> {
        meet.iter().enumerate().flat_map(|(i, higher)| meet[..i].iter().map(move |lower| (lower.1, higher.1)))
    }
    let mut pairs: Vec<(u32, u32)> = members.chunk_by(|a, b| a.0 == b.0).flat_map(each).collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs
}

/// The faces of all cells whose nodes `count`, by their sorted nodes, with the cell and the face's number in it.
pub(super) fn by_nodes(mesh: Cells, counts: impl Fn(u32) -> bool + Sync) -> Vec<([u32; 4], u32, u8)> {
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

/// The nodes that bodies have of their own.
pub(super) struct Copies {
    /// (body, original node), ascending; the copy's number is `first` plus the index here.
    keys: Vec<(u32, u32)>,
    first: u32,
}

impl Copies {
    /// The node that `body` has for `node`: its copy, or the node itself where it has none.
    pub(super) fn of(&self, body: u32, node: u32) -> u32 {
        self.keys.binary_search(&(body, node)).map_or(node, |index| self.first + index as u32)
    }

    /// The number of the first copy; all nodes from there on are copies.
    pub(super) fn first(&self) -> u32 {
        self.first
    }

    /// The body that has a copy.
    pub(super) fn body(&self, copy: u32) -> u32 {
        self.keys[(copy - self.first) as usize].0
    }

    /// (body, original node, copy).
    pub(super) fn iter(&self) -> impl ExactSizeIterator<Item = (u32, u32, u32)> {
        self.keys.iter().enumerate().map(|(index, &(body, node))| (body, node, self.first + index as u32))
    }

    /// Where the copies are: at their originals.
    fn positions(&self, points: &[Vec3]) -> Vec<Vec3> {
        self.keys.iter().map(|&(_, node)| points[node as usize]).collect()
    }

    /// Gives the bodies' cells, of so many nodes each, the copies in place of the originals.
    fn take(&self, per_cell: usize, cells: &mut [u32], owner: &[u32]) {
        let mut touched = vec![false; self.first as usize];
        self.keys.iter().for_each(|&(_, node)| touched[node as usize] = true);
        parallel::chunks_mut(cells, per_cell, |cell, nodes| {
            if owner[cell] != NO_BODY {
                for node in nodes.iter_mut().filter(|node| touched[**node as usize]) {
                    *node = self.of(owner[cell], *node);
                }
            }
        });
    }
}

/// Gives each body copies of its interface nodes in `mesh`, at the same positions; the cells are to take them
/// ([`Copies::take`]). Mortar and fibres keep the originals; `owned` tells of every node whether such cells have it: where none
/// do, the lowest body keeps the original.
fn copies(mesh: Cells, faces: &[InterfaceFace], owned: Option<Vec<bool>>) -> Copies {
    let of_face =
        |face: &InterfaceFace| face.nodes().iter().map(|&node| (mesh.owner[face.cell as usize], node)).collect();
    let mut keys: Vec<(u32, u32)> = faces.iter().flat_map::<Vec<_>, _>(of_face).collect();
    keys.par_sort_unstable();
    keys.dedup();
    if let Some(mut owned) = owned {
        keys.retain(|&(_, node)| std::mem::replace(&mut owned[node as usize], true));
    }
    Copies { keys, first: mesh.points.len() as u32 }
}

/// Parts the bodies of a tetrahedral mesh, at `faces`, from everything else.
pub(crate) fn separate(mesh: &mut TetMesh, faces: &[InterfaceFace]) -> Copies {
    let copies = copies(mesh.by_body(), faces, None);
    mesh.points.extend(copies.positions(&mesh.points));
    copies.take(4, mesh.cells.as_flattened_mut(), &mesh.owner);
    copies
}

/// Parts the aggregates from the mortar and from each other, and joins them by zero-thickness cohesive elements; fibres are
/// bonded.
///
/// Node order as Abaqus wants COH3D6 and COH3D8: the bottom face, here the aggregate's, then the top face's nodes over
/// them. The bottom face is counter-clockwise seen from the top, so that its normal, the thickness direction, points out
/// of the aggregate. Between two aggregates the bottom is that of the lower id.
pub(super) fn add_cohesive(mesh: &mut Mesh) {
    let mut faces = faces(mesh.by_aggregate());
    faces.retain(|face| mesh.phase[face.cell as usize] != Phase::Fibre);
    let copies = copies(mesh.by_aggregate(), &faces, Some(kept(mesh)));
    mesh.points.extend(copies.positions(&mesh.points));
    copies.take(mesh.kind.nodes(), &mut mesh.cells, &mesh.aggregate);
    faces.retain(|face| mesh.aggregate[face.cell as usize] < mesh.aggregate[face.behind as usize]);
    let join = |face: &InterfaceFace| {
        let [inside, outside] = [face.cell, face.behind].map(|cell| mesh.aggregate[cell as usize]);
        let own = |aggregate: u32| face.nodes().iter().map(move |&node| (aggregate, node));
        let nodes = own(inside).chain(own(outside));
        nodes.map(|(aggregate, node)| copies.of(aggregate, node)).collect::<Vec<u32>>()
    };
    mesh.cohesive = faces.iter().flat_map(join).collect();
    mesh.cohesive_aggregate = faces.iter().map(|face| mesh.aggregate[face.cell as usize]).collect();
}

/// Whether mortar or fibres have a node: they keep the original.
fn kept(mesh: &Mesh) -> Vec<bool> {
    let mut kept = vec![false; mesh.points.len()];
    let keeps = |phase: &Phase| matches!(phase, Phase::Mortar | Phase::Fibre);
    for (cell, _) in mesh.cells().zip(&mesh.phase).filter(|(_, phase)| keeps(phase)) {
        cell.iter().for_each(|&node| kept[node as usize] = true);
    }
    kept
}

/// Smears the ITZ over the mortar's cells that share a face with an aggregate's: their phase is the ITZ, and they belong to
/// no aggregate still.
pub(super) fn smear_itz(mesh: &mut Mesh) {
    for face in faces(mesh.by_aggregate()) {
        let [inside, outside] = [face.cell, face.behind].map(|cell| cell as usize);
        if mesh.phase[inside] == Phase::Aggregate && mesh.aggregate[outside] == NO_AGGREGATE {
            mesh.phase[outside] = Phase::Itz;
        }
    }
}
