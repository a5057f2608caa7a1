//! Every aggregate gets nodes of its own where it meets other materials: what a layer or cohesive elements go between.

use super::interface::InterfaceFace;
use super::{Mesh, NO_AGGREGATE, Phase};
use rayon::prelude::*;

/// The nodes that aggregates have of their own.
pub(super) struct Copies {
    /// (aggregate id, original node), ascending; the copy's number is `first` plus the index here.
    keys: Vec<(u32, u32)>,
    first: u32,
}

impl Copies {
    /// The node that `aggregate` has for `node`: its copy, or the node itself where it has none.
    pub(super) fn of(&self, aggregate: u32, node: u32) -> u32 {
        self.keys.binary_search(&(aggregate, node)).map_or(node, |index| self.first + index as u32)
    }

    /// The number of the first copy; all nodes from there on are copies.
    pub(super) fn first(&self) -> u32 {
        self.first
    }

    /// The aggregate that has a copy.
    pub(super) fn body(&self, copy: u32) -> u32 {
        self.keys[(copy - self.first) as usize].0
    }

    /// (aggregate id, original node, copy).
    pub(super) fn iter(&self) -> impl ExactSizeIterator<Item = (u32, u32, u32)> {
        self.keys.iter().enumerate().map(|(index, &(aggregate, node))| (aggregate, node, self.first + index as u32))
    }
}

/// Gives each aggregate copies of its interface nodes, at the same places, and its cells the copies. Mortar and fibres keep
/// the originals; with `keep_lone`, so does the lowest aggregate at a node that no such cell has.
pub(super) fn separate(mesh: &mut Mesh, faces: &[InterfaceFace], keep_lone: bool) -> Copies {
    let mut keys: Vec<(u32, u32)> = faces
        .iter()
        .flat_map(|face| face.nodes().iter().map(|&node| (mesh.aggregate[face.cell as usize], node)))
        .collect();
    keys.par_sort_unstable();
    keys.dedup();
    if keep_lone {
        drop_lone(mesh, &mut keys);
    }
    let copies = Copies { keys, first: mesh.points.len() as u32 };
    let points: Vec<_> = copies.keys.iter().map(|&(_, node)| mesh.points[node as usize]).collect();
    mesh.points.extend(points);
    let mut touched = vec![false; copies.first as usize];
    copies.keys.iter().for_each(|&(_, node)| touched[node as usize] = true);
    let nodes = mesh.kind.nodes();
    mesh.cells.par_chunks_exact_mut(nodes).zip(&mesh.aggregate).for_each(|(cell, &aggregate)| {
        if aggregate != NO_AGGREGATE {
            for node in cell.iter_mut().filter(|node| touched[**node as usize]) {
                *node = copies.of(aggregate, *node);
            }
        }
    });
    copies
}

/// Leaves the original to the lowest aggregate where nothing else keeps it, so that no node is left without cells.
fn drop_lone(mesh: &Mesh, keys: &mut Vec<(u32, u32)>) {
    let mut owned = vec![false; mesh.points.len()];
    let keeps = |phase: &Phase| matches!(phase, Phase::Mortar | Phase::Fibre);
    for (cell, _) in mesh.cells().zip(&mesh.phase).filter(|(_, phase)| keeps(phase)) {
        cell.iter().for_each(|&node| owned[node as usize] = true);
    }
    keys.retain(|&(_, node)| std::mem::replace(&mut owned[node as usize], true));
}
