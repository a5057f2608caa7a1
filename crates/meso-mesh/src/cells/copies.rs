//! The nodes that bodies get of their own at an interface, for a layer or cohesive elements to go between.

use super::interface::InterfaceFace;
use super::mesh::{Cells, NO_BODY};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use rayon::prelude::*;

/// The nodes that bodies have of their own.
pub(crate) struct Copies {
    /// (body, original node), ascending; the copy's number is `first` plus the index here.
    keys: Vec<(u32, u32)>,
    first: u32,
}

impl Copies {
    /// The node that `body` has for `node`: its copy, or the node itself where it has none.
    pub(crate) fn of(&self, body: u32, node: u32) -> u32 {
        self.keys.binary_search(&(body, node)).map_or(node, |index| self.first + index as u32)
    }

    /// The number of the first copy; all nodes from there on are copies.
    pub(crate) fn first(&self) -> u32 {
        self.first
    }

    /// The body that has a copy.
    pub(crate) fn body(&self, copy: u32) -> u32 {
        self.keys[(copy - self.first) as usize].0
    }

    /// (body, original node, copy).
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = (u32, u32, u32)> {
        self.keys.iter().enumerate().map(|(index, &(body, node))| (body, node, self.first + index as u32))
    }

    /// Adds the copies to `points`, and gives the bodies' cells, of so many nodes each, these in place of the originals.
    pub(crate) fn part(&self, points: &mut Vec<Vec3>, per_cell: usize, cells: &mut [u32], owner: &[u32]) {
        points.extend(self.keys.iter().map(|&(_, node)| points[node as usize]).collect::<Vec<_>>());
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
/// ([`Copies::part`]). Mortar and fibres keep the originals; `owned` tells of every node whether such cells have it: where none
/// do, the lowest body keeps the original.
pub(crate) fn copies(mesh: Cells, faces: &[InterfaceFace], owned: Option<Vec<bool>>) -> Copies {
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
