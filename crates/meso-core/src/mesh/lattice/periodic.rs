//! Nodes on faces across which a box repeats itself: they are one with their images, and move with them.
//!
//! While all nodes move they stay where the cut put them ([`Role::Fixed`]). During the repair they slide within the face,
//! along the bodies that they lie on, together with their images: both faces of a pair stay alike, and a move is judged by the
//! cells behind all of them.

use super::boundary::Boundary;
use super::nodes::{Nodes, PeriodicPairs};
use super::roles::Role;
use super::surface::Surface;
use crate::math::{Aabb, Vec3};
use crate::mesh::cells::NO_BODY;
use crate::mesh::tet::{TetMesh, ascending, directions};

/// Lets nodes that stayed where they are, and have images, move with these.
pub(super) fn release(roles: &mut [Role], mesh: &TetMesh, pairs: &PeriodicPairs, domain: &Aabb) {
    for node in pairs.nodes() {
        let p = &mesh.position(node);
        roles[node as usize] = Role::Paired([0, 1, 2].map(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i]));
    }
}

/// The bodies whose cells `node` has, and whether it has cells of several materials.
fn bodies(nodes: &Nodes, node: u32) -> (Vec<u32>, bool) {
    let mut owners = ascending(nodes.cells(node).iter().map(|&cell| nodes.mesh.owner[cell as usize]));
    let several = owners.len() > 1;
    owners.retain(|owner| *owner != NO_BODY);
    (owners, several)
}

/// Whether a node with images lies on none of the bodies whose cells it has, were it at `x`.
pub(super) fn is_off(nodes: &Nodes, node: u32, x: &Vec3) -> bool {
    let (bodies, several) = bodies(nodes, node);
    let at_side = matches!(nodes.role(node), Role::Paired(axes) if nodes.exact.boundary.ends(axes));
    several && !at_side && !bodies.iter().any(|&body| nodes.surface(body).has(x))
}

/// Whether no image of `node` leaves its bodies when this goes from where it is to `position`.
pub(super) fn stays_on(nodes: &Nodes, node: u32, position: &Vec3) -> bool {
    let stays = |(image, shift): (u32, Vec3)| {
        !is_off(nodes, image, &(position + shift)) || is_off(nodes, image, &nodes.position(image))
    };
    nodes.pairs.class(node).all(stays)
}

/// Where `node` is after the part of `step` that its faces allow, and a body that it or an image lies on.
pub(super) fn after(nodes: &Nodes, node: u32, axes: [bool; 3], step: &Vec3) -> Option<Vec3> {
    let x = nodes.position(node);
    let along = nodes.pairs.class(node).find_map(|(image, shift)| {
        let own = bodies(nodes, image).0.into_iter().find(|&body| nodes.surface(body).has(&(x + shift)));
        own.map(|body| (nodes.surface(body), shift))
    });
    let position = match along {
        Some((surface, shift)) => surface.along_face_within(&(x + shift), step, axes)? - shift,
        None => x + Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { step[axis] }),
    };
    // Neither rounding nor the way there and back take it off the faces.
    let position = Vec3::from_fn(|axis, _| if axes[axis] { x[axis] } else { position[axis] });
    stays_on(nodes, node, &position).then_some(position)
}

/// Positions near the node, in its faces, on the bodies whose cells it has, that leave no image off its own: those nearest to
/// it, and to points so many elements around it.
pub(super) fn positions(nodes: &Nodes, node: u32, axes: [bool; 3], reaches: &[f64]) -> Vec<Vec3> {
    let (x, size) = (nodes.position(node), nodes.exact.size);
    let around = reaches.iter().flat_map(|reach| directions().map(move |direction| direction * *reach * size));
    let within = |step: Vec3| x + Vec3::from_fn(|axis, _| if axes[axis] { 0.0 } else { step[axis] });
    let starts: Vec<Vec3> = std::iter::once(x).chain(around.map(within)).collect();
    let mut positions = Vec::new();
    for body in bodies(nodes, node).0 {
        let surface = nodes.surface(body);
        starts.iter().for_each(|start| surface.nearest_within(start, axes, size, |position| positions.push(position)));
    }
    positions.retain(|position| stays_on(nodes, node, position));
    positions
}

/// How many nodes on faces across which the box repeats itself lie off all bodies whose cells they have.
pub(super) fn count_off(mesh: &TetMesh, surfaces: &[Surface], domain: &Aabb, boundary: &Boundary) -> usize {
    if boundary.repeats == [false; 3] {
        return 0;
    }
    let axes = |p: &Vec3| [0, 1, 2].map(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i]);
    let counts = |p: &Vec3| axes(p).contains(&true) && !boundary.ends(axes(p));
    let mut owned: Vec<(u32, u32)> = Vec::new();
    for (cell, &owner) in mesh.cells.iter().zip(&mesh.owner) {
        owned.extend(cell.iter().filter(|&&node| counts(&mesh.position(node))).map(|&node| (node, owner)));
    }
    owned.sort_unstable();
    owned.dedup();
    let is_off = |around: &&[(u32, u32)]| {
        let on = |&(node, owner): &(u32, u32)| owner != NO_BODY && surfaces[owner as usize].has(&mesh.position(node));
        around.len() > 1 && !around.iter().any(on)
    };
    owned.chunk_by(|a, b| a.0 == b.0).filter(is_off).count()
}
