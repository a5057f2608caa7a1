//! Nodes moved a little where their seats spoil a tetrahedron.
//!
//! The flat tetrahedra that a mesher leaves under a surface stand on nodes that go to different faces' offsets, and small
//! faces' seats come out of order: a few microns turn such a cell over, and a few set it right. Each node of a bad cell
//! goes the way that gains the cell its volume with the least moves; a node of several cells takes the mean. (In packings
//! of 30 mm at 1.2, 2 and 3 mm some 80 triangles of 12,900 come out of order, and all are set right in 30 rounds; nodes
//! that step back instead, 0.4 mm in one place, made most of the layer's error.)

use super::LayerCell;
use super::sound::{least_of_core, least_of_layer, volume};
use super::ties::Ties;
use crate::math::Vec3;
use crate::mesh::Mesh;
use rayon::prelude::*;

/// After each try the nodes of cells that are still bad leave their seats for their images along the ray, which are in
/// order everywhere (in a 60 mm cube at 2 mm one more try frees all of 58,987 nodes, where 33 were stuck).
const TRIES: usize = 4;
const ROUNDS: usize = 30;
/// The volume aimed at, in least ones: moves of other nodes take some of it again.
const AIM: f64 = 1.6;
/// A node moves at most this share of its way from its old place in one round.
const FARTHEST: f64 = 0.2;

/// Moves `seats` until no cell is bad, or until the tries are over; `images` are those along the nodes' rays.
pub(super) fn nudge(mesh: &Mesh, layer: &[LayerCell], ties: &Ties, images: &[Vec3], seats: &mut [Vec3]) {
    for _ in 0..TRIES {
        let stuck = set_right(mesh, layer, ties, seats);
        if stuck.is_empty() {
            return;
        }
        stuck.into_iter().for_each(|node| seats[node as usize] = images[node as usize]);
        ties.spread(seats);
    }
}

/// Moves `images` until no cell is bad, or until the rounds are over; the nodes of cells that still are.
fn set_right(mesh: &Mesh, layer: &[LayerCell], ties: &Ties, images: &mut [Vec3]) -> Vec<u32> {
    let mut stirred = vec![true; images.len()];
    for _ in 0..ROUNDS {
        let mut moves = moves(mesh, layer, ties, images, &stirred);
        if moves.is_empty() {
            return Vec::new();
        }
        // Stable: a node's moves stay in the order of the cells.
        moves.sort_by_key(|(node, _)| *node);
        stirred.fill(false);
        for group in moves.chunk_by(|a, b| a.0 == b.0) {
            let node = group[0].0 as usize;
            let mean = group.iter().map(|(_, way)| *way).sum::<Vec3>() / group.len() as f64;
            let farthest = FARTHEST * (images[node] - mesh.points[node]).norm();
            images[node] += mean * (farthest / mean.norm()).min(1.0);
            stirred[node] = true;
        }
        ties.spread(images);
        ties.share(&mut stirred);
    }
    moves(mesh, layer, ties, images, &stirred).into_iter().map(|(node, _)| node).collect()
}

/// Leads of the nodes of bad cells with the way that each should go; of the cells that have a `stirred` node.
fn moves(mesh: &Mesh, layer: &[LayerCell], ties: &Ties, images: &[Vec3], stirred: &[bool]) -> Vec<(u32, Vec3)> {
    let now = |nodes: [u32; 4]| nodes.map(|node| images[node as usize]);
    let near = |nodes: &[u32]| nodes.iter().any(|&node| stirred[node as usize]);
    let core = |cell: &[u32]| {
        let nodes = [0, 1, 2, 3].map(|i| cell[i]);
        (nodes, least_of_core(nodes.map(|node| mesh.points[node as usize]), now(nodes)))
    };
    let layer_cell = |cell: &LayerCell| (cell.nodes, least_of_layer(cell, cell.rail.map(|node| images[node as usize])));
    let all = mesh.cells.par_chunks_exact(4).filter(|cell| near(cell)).map(core);
    let all = all.chain(layer.par_iter().filter(|cell| near(&cell.nodes)).map(layer_cell));
    let bad = all.filter(|(nodes, least)| volume(now(*nodes)) <= *least);
    let free = |node: u32| images[node as usize] != mesh.points[node as usize];
    let led = |(node, way): (u32, Vec3)| (ties.lead(node), way);
    bad.flat_map_iter(|(nodes, least)| ways(nodes, now(nodes), AIM * least, free, ties).into_iter().map(led)).collect()
}

/// The least moves of the nodes that are `free` which together give the cell the volume `aim`, mm3, to first order.
fn ways(
    nodes: [u32; 4],
    [a, b, c, d]: [Vec3; 4],
    aim: f64,
    free: impl Fn(u32) -> bool,
    ties: &Ties,
) -> Vec<(u32, Vec3)> {
    let gradients =
        [(c - b).cross(&(d - b)) * -1.0, (c - a).cross(&(d - a)), (d - a).cross(&(b - a)), (b - a).cross(&(c - a))];
    let ways = nodes.into_iter().zip(gradients).filter(|(node, _)| free(*node));
    let ways: Vec<(u32, Vec3)> = ways.map(|(node, way)| (node, ties.flat(node).along(&way))).collect();
    // Volume is a sixth of node times gradient.
    let gain = 6.0 * (aim - volume([a, b, c, d])) / ways.iter().map(|(_, way)| way.norm_squared()).sum::<f64>();
    ways.into_iter().map(|(node, way)| (node, way * gain)).filter(|(_, way)| way.norm() > 0.0).collect()
}
