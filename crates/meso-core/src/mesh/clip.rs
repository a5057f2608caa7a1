//! What is left out of a mesh: voids, and mortar outside a specimen that does not fill its bounding box.
//!
//! That is mortar whose cell has its centroid outside; the surface that is left is one of whole cells: as far as half an
//! element from the specimen's own. (A fitted lattice is cut at the specimen's surface instead.)

use super::{Mesh, NO_AGGREGATE};
use crate::aggregate::{Aggregate, Kind};
use crate::math::Vec3;
use crate::packing::Container;
use rayon::prelude::*;

/// Keeps the aggregates' cells and the mortar's inside `room`, and the nodes they have.
pub(super) fn clip(mesh: &mut Mesh, room: &dyn Container) {
    if room.is_box() {
        return;
    }
    let (nodes, points) = (mesh.kind.nodes(), &mesh.points);
    let centroid = |cell: &[u32]| cell.iter().map(|&node| points[node as usize]).sum::<Vec3>() / nodes as f64;
    let keep = |(cell, &id): (&[u32], &u32)| id != NO_AGGREGATE || room.contains(&centroid(cell));
    let inside: Vec<bool> = mesh.cells.par_chunks_exact(nodes).zip(&mesh.aggregate).map(keep).collect();
    retain(mesh, &inside);
}

/// Keeps all cells but those of voids.
pub(super) fn leave_out_voids(mesh: &mut Mesh, bodies: &[Aggregate]) {
    let mut voids: Vec<u32> = bodies.iter().filter(|body| body.kind == Kind::Void).map(|body| body.id).collect();
    if voids.is_empty() {
        return;
    }
    voids.sort_unstable();
    let solid: Vec<bool> = mesh.aggregate.par_iter().map(|id| voids.binary_search(id).is_err()).collect();
    retain(mesh, &solid);
}

/// Keeps some of the cells, and the nodes they have.
pub(super) fn retain(mesh: &mut Mesh, cells: &[bool]) {
    let mut kept = cells.iter().flat_map(|kept| std::iter::repeat_n(*kept, mesh.kind.nodes()));
    mesh.cells.retain(|_| kept.next().unwrap_or(true));
    let mut kept = cells.iter();
    mesh.phase.retain(|_| *kept.next().unwrap_or(&true));
    let mut kept = cells.iter();
    mesh.aggregate.retain(|_| *kept.next().unwrap_or(&true));
    drop_lone_nodes(mesh);
}

/// Leaves out the nodes without cells and numbers the others anew, in their order.
fn drop_lone_nodes(mesh: &mut Mesh) {
    const LONE: u32 = u32::MAX;
    let mut number = vec![LONE; mesh.points.len()];
    mesh.cells.iter().for_each(|&node| number[node as usize] = 0);
    for (count, number) in (0..).zip(number.iter_mut().filter(|number| **number != LONE)) {
        *number = count;
    }
    let mut old = number.iter();
    mesh.points.retain(|_| *old.next().unwrap_or(&LONE) != LONE);
    mesh.cells.par_iter_mut().for_each(|node| *node = number[*node as usize]);
}
