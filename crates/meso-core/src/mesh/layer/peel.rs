//! Flat cells under the surface, with all nodes on it, that the map onto the offset would turn over: they become the layer's.
//!
//! Such a cell stands under two interface triangles that meet at a flat ridge. On the offset the ridge may run along the
//! cell's other diagonal; without the cell, the layer begins at the two triangles below it, which then look the right way.

use super::settle::shape;
use super::shrink::Shrink;
use crate::mesh::interface;
use crate::mesh::{Mesh, Phase};
use rayon::prelude::*;
use std::collections::HashMap;

/// In place of the aggregate of a peeled cell until the layer is there.
const PEELED: u32 = u32::MAX - 1;
/// A cell is peeled where its image keeps less than this share of its shape.
const KEPT_SHAPE: f64 = 0.1;

/// Rounds; a peeled cell may bare another one.
const ROUNDS: usize = 3;

/// Gives the cells to the layer, as no aggregate's; returns them with their aggregates.
pub(super) fn peel(mesh: &mut Mesh, shrinks: &HashMap<u32, Shrink>) -> Vec<(u32, u32)> {
    let mut peeled = Vec::new();
    for _ in 0..ROUNDS {
        let cells = turned_over(mesh, shrinks);
        if cells.is_empty() {
            break;
        }
        for cell in cells {
            mesh.phase[cell as usize] = Phase::Itz;
            peeled.push((cell, std::mem::replace(&mut mesh.aggregate[cell as usize], PEELED)));
        }
    }
    peeled
}

/// The cells with two or three faces on the surface, all nodes on it, and a bad image.
fn turned_over(mesh: &Mesh, shrinks: &HashMap<u32, Shrink>) -> Vec<u32> {
    let faces = interface::faces(mesh);
    let mixed = interface::mixed_nodes(mesh);
    let over = |cell: &u32| {
        let nodes = &mesh.cells[4 * *cell as usize..][..4];
        let from = [0, 1, 2, 3].map(|i| mesh.points[nodes[i] as usize]);
        let bad = |shrink: &Shrink| shape(from.map(|p| shrink.apply(&p))) < KEPT_SHAPE * shape(from);
        let shrink = shrinks.get(&mesh.aggregate[*cell as usize]);
        shrink.is_some_and(bad) && nodes.iter().all(|&node| mixed[node as usize])
    };
    // Faces come cell by cell.
    let cells = faces.chunk_by(|a, b| a.cell == b.cell).filter(|faces| matches!(faces.len(), 2 | 3));
    let cells: Vec<u32> = cells.map(|faces| faces[0].cell).collect();
    cells.into_par_iter().filter(over).collect()
}
