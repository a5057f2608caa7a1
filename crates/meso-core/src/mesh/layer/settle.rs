//! How far every node goes towards its image, so that no tetrahedron turns over or goes flat.
//!
//! All start with the whole way. The nodes of a tetrahedron that comes out bad go [`STEP_BACK`] of their way, and after
//! [`STEPS`] of these none of it. The end is sure: with all nodes in place the aggregate's cells are the old ones, and
//! a layer cell is left out with its rail.

use super::LayerCell;
use super::sound::{least_of_core, least_of_layer, volume};
use super::ties::Ties;
use crate::math::Vec3;
use crate::mesh::Mesh;
use rayon::prelude::*;

/// Share of its way that a node keeps at each step back.
const STEP_BACK: f64 = 0.7;
/// Steps back before a node stays where it is: 0.7^10 is 3 %.
const STEPS: u8 = 10;

/// Steps back of every node.
pub(super) struct Ways(Vec<u8>);

impl Ways {
    /// Where the node comes to between its place and its image.
    pub(super) fn place(&self, node: u32, from: &Vec3, image: &Vec3) -> Vec3 {
        match self.0[node as usize] {
            0 => *image,
            STEPS => *from,
            steps => from + (image - from) * (0..steps).fold(1.0, |share, _| share * STEP_BACK),
        }
    }

    /// The node stopped before its image.
    pub(super) fn is_short(&self, node: u32) -> bool {
        self.0[node as usize] > 0
    }

    /// The node did not move.
    pub(super) fn is_pinched(&self, node: u32) -> bool {
        self.0[node as usize] == STEPS
    }
}

/// Ways from `mesh`'s points to `images` such that all its cells and `layer`'s keep a positive volume; nodes that are tied
/// go the same share.
pub(super) fn settle(mesh: &Mesh, images: &[Vec3], layer: &[LayerCell], ties: &Ties) -> Ways {
    let start = |node: u32| if ties.is_pinned(node) { STEPS } else { 0 };
    let mut ways = Ways((0..images.len() as u32).map(start).collect());
    let moving = |cell: &&[u32]| cell.iter().any(|&node| images[node as usize] != mesh.points[node as usize]);
    loop {
        let place = |node: u32| ways.place(node, &mesh.points[node as usize], &images[node as usize]);
        let worse = |cell: &&[u32]| {
            let at = |place: &dyn Fn(u32) -> Vec3| [0, 1, 2, 3].map(|i| place(cell[i]));
            let (before, now) = (at(&|node| mesh.points[node as usize]), at(&place));
            let fine = volume(now) > least_of_core(before, now);
            !fine
        };
        let fallen = |cell: &&LayerCell| {
            let least = least_of_layer(cell, cell.rail.map(place));
            let fine = ways.is_pinched(cell.rail[0]) || volume(cell.nodes.map(place)) > least;
            !fine
        };
        let cells = mesh.cells.par_chunks_exact(4).filter(moving).filter(worse).flatten().copied();
        let mut bad: Vec<u32> = cells.collect();
        bad.par_extend(layer.par_iter().filter(fallen).flat_map_iter(|cell| cell.nodes));
        bad.par_iter_mut().for_each(|node| *node = ties.lead(*node));
        bad.par_sort_unstable();
        bad.dedup();
        bad.retain(|&node| images[node as usize] != mesh.points[node as usize] && !ways.is_pinched(node));
        if bad.is_empty() {
            return ways;
        }
        bad.iter().for_each(|&node| ways.0[node as usize] += 1);
        ties.share(&mut ways.0);
    }
}
