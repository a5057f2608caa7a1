//! After the cut: interface nodes slide along their grain onto its edges and corners, where that brings back volume.
//!
//! The triangles between nodes on a convex surface lie inside it, so the cut loses what lies over them, most at edges
//! and corners. Every move keeps all dihedral angles around the node above [`GUARD_DEG`], or at least does not worsen
//! them, and must gain volume; nodes off the surfaces move to make room. Nodes go in patches, eight colours of them, such
//! that patches of one colour share no tetrahedron: the result does not depend on the number of threads.

use super::Tetrahedra;
use super::star::{Moved, Star, Stars};
use super::surface::Surface;
use crate::math::{Aabb, Vec3};
use crate::mesh::NO_AGGREGATE;
use rayon::prelude::*;
use std::collections::HashMap;

/// The smallest dihedral angle a move may leave, degrees.
const GUARD_DEG: f64 = 10.0;
/// Nodes whose worst angle is below this are moved to better it, degrees.
const POOR_DEG: f64 = 22.0;
/// Rounds of features and smoothing.
const ROUNDS: usize = 5;
/// Edge of a patch, in elements; more than twice the longest edge of a tetrahedron, so that colours stay apart.
const PATCH: f64 = 6.0;

/// What a node may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Nothing: it lies on the box's faces.
    Fixed,
    /// Leave its place, where a gap was closed between several grains, only to lift an angle above the guard.
    Contact,
    /// Slide along the surface of this grain.
    Surface(u32),
    /// Move freely: all its tetrahedra are of one grain, or of the mortar.
    Free,
}

/// Fits `mesh`, with elements of about `size` mm, to the surfaces.
pub(super) fn fit(mesh: &mut Tetrahedra, surfaces: &[Surface], domain: &Aabb, size: f64) {
    let roles = roles(mesh, domain);
    let active = near_surface(mesh, &roles);
    let stars = Stars::new(mesh, &active);
    let colours = patches(mesh, &active, domain, size * PATCH);
    for round in 0..ROUNDS {
        for step in [slide, smooth] {
            for patches in &colours {
                let view = &*mesh;
                let moves: Vec<HashMap<u32, Vec3>> = patches
                    .par_iter()
                    .map(|nodes| {
                        let mut moved = Moved { points: &view.points, moves: HashMap::new() };
                        for &node in nodes {
                            let star = Star::new(view, &stars, node, &moved);
                            if let Some(to) = step(&star, roles[node as usize], surfaces, size, round) {
                                moved.moves.insert(node, to);
                            }
                        }
                        moved.moves
                    })
                    .collect();
                for (nodes, moves) in patches.iter().zip(&moves) {
                    for node in nodes {
                        if let Some(to) = moves.get(node) {
                            mesh.points[*node as usize] = *to;
                        }
                    }
                }
            }
        }
    }
}

/// The place on the grain's edges and corners near the node that gains the most volume.
fn slide(star: &Star, role: Role, surfaces: &[Surface], size: f64, _: usize) -> Option<Vec3> {
    let Role::Surface(grain) = role else { return None };
    let gain = star.gain(grain);
    let least = 1e-6 * size * size * size;
    let mut places = Vec::new();
    surfaces[grain as usize].features_near(&star.centre, 0.7 * size, |place| {
        let gained = gain.dot(&(place - star.centre));
        if gained > least {
            places.push((gained, place));
        }
    });
    if places.is_empty() {
        return None;
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    let limit = guard().max(star.worst(&star.centre, 2.0));
    places.into_iter().map(|(_, place)| place).find(|place| star.worst(place, limit) <= limit)
}

/// A place that betters the worst angle around a poor node; nodes of a surface stay on their face and lose no volume.
fn smooth(star: &Star, role: Role, surfaces: &[Surface], size: f64, round: usize) -> Option<Vec3> {
    let gain = match role {
        Role::Fixed => return None,
        Role::Surface(grain) => star.gain(grain),
        Role::Contact | Role::Free => Vec3::zeros(),
    };
    let before = star.worst(&star.centre, 2.0);
    if before < if role == Role::Contact { guard() } else { cos_deg(POOR_DEG) } {
        return None;
    }
    let mut best = (before - 1e-3, None);
    let reach = 0.15 * size / (1 + round) as f64;
    let towards = (star.mean() - star.centre) * 0.5;
    let around = (0..6).map(|i| Vec3::from_fn(|axis, _| if axis == i / 2 { [reach, -reach][i % 2] } else { 0.0 }));
    for step in std::iter::once(towards).chain(around) {
        let place = match role {
            Role::Surface(grain) => surfaces[grain as usize].along_face(&star.centre, &step),
            _ => Some(star.centre + step),
        };
        let Some(place) = place.filter(|place| gain.dot(&(place - star.centre)) >= 0.0) else { continue };
        let worst = star.worst(&place, best.0);
        if worst < best.0 {
            best = (worst, Some(place));
        }
    }
    best.1
}

fn cos_deg(degrees: f64) -> f64 {
    libm::cos(degrees.to_radians())
}

fn guard() -> f64 {
    cos_deg(GUARD_DEG)
}

/// Roles from the grains of the tetrahedra around every node.
pub(super) fn roles(mesh: &Tetrahedra, domain: &Aabb) -> Vec<Role> {
    const UNSEEN: u32 = u32::MAX - 1;
    let mut seen = vec![[UNSEEN; 2]; mesh.points.len()];
    let mut many = vec![false; mesh.points.len()];
    for (cell, &grain) in mesh.cells.iter().zip(&mesh.grain) {
        for &node in cell {
            let labels = &mut seen[node as usize];
            match labels.iter().position(|l| *l == grain || *l == UNSEEN) {
                Some(place) => labels[place] = grain,
                None => many[node as usize] = true,
            }
        }
    }
    let wall = |p: &Vec3| (0..3).any(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i]);
    let role = |node: usize| match seen[node] {
        _ if wall(&mesh.points[node]) => Role::Fixed,
        _ if many[node] => Role::Contact,
        [_, UNSEEN] => Role::Free,
        [NO_AGGREGATE, grain] | [grain, NO_AGGREGATE] => Role::Surface(grain),
        _ => Role::Contact,
    };
    (0..mesh.points.len()).into_par_iter().map(role).collect()
}

/// Nodes on a surface, and free ones that share a tetrahedron with them.
fn near_surface(mesh: &Tetrahedra, roles: &[Role]) -> Vec<bool> {
    let mut active: Vec<bool> = roles.iter().map(|role| matches!(role, Role::Surface(_) | Role::Contact)).collect();
    for cell in &mesh.cells {
        if cell.iter().any(|&node| matches!(roles[node as usize], Role::Surface(_) | Role::Contact)) {
            cell.iter()
                .filter(|&&node| roles[node as usize] == Role::Free)
                .for_each(|&node| active[node as usize] = true);
        }
    }
    active
}

/// The active nodes by patch, the patches by colour; nodes ascending.
fn patches(mesh: &Tetrahedra, active: &[bool], domain: &Aabb, edge: f64) -> [Vec<Vec<u32>>; 8] {
    let counts = [0, 1, 2].map(|i| (domain.size()[i] / edge).floor().max(1.0) as usize);
    let mut blocks = vec![Vec::new(); counts.iter().product()];
    for (node, point) in (0..).zip(&mesh.points).filter(|(node, _)| active[*node as usize]) {
        let [i, j, k] = [0, 1, 2].map(|a| {
            let share = (point[a] - domain.min[a]) / domain.size()[a];
            ((share * counts[a] as f64) as usize).min(counts[a] - 1)
        });
        blocks[(k * counts[1] + j) * counts[0] + i].push(node);
    }
    let mut colours: [Vec<Vec<u32>>; 8] = Default::default();
    for (b, nodes) in blocks.into_iter().enumerate().filter(|(_, nodes)| !nodes.is_empty()) {
        let [i, j, k] = [b % counts[0], b / counts[0] % counts[1], b / (counts[0] * counts[1])];
        colours[i % 2 + 2 * (j % 2) + 4 * (k % 2)].push(nodes);
    }
    colours
}
