//! What the nodes of a cut lattice may do, by the grains of the tetrahedra around them.

use super::Tetrahedra;
use super::places::Places;
use super::skin::{Hold, Skin};
use crate::math::{Aabb, Vec3};
use crate::mesh::NO_AGGREGATE;
use crate::mesh::grains::Locator;
use rayon::prelude::*;

/// What a node may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// Nothing: it lies on a side of a box that has to match the opposite one.
    Fixed,
    /// The same at the end of the fit: slide in the sides across these axes, together with its images.
    Twin([bool; 3]),
    /// Slide along a grain it lies on, where a gap was closed between several grains.
    Contact,
    /// Slide along the surface of this grain.
    Surface(u32),
    /// Slide along the specimen's own surface.
    Skin(Hold),
    /// Move freely: all its tetrahedra are of one grain, or of the mortar.
    Free,
}

/// The roles of all nodes.
///
/// Nodes on sides that have to match opposite ones stay where they are, those on other flat sides slide in these.
pub(super) fn roles(mesh: &Tetrahedra, domain: &Aabb, skin: &Skin) -> Vec<Role> {
    let wall = |p: &Vec3| [0, 1, 2].map(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i]);
    let role = |(node, (point, around)): (usize, (&Vec3, &Around))| match around {
        _ if let Some(hold) = skin.hold(node, wall(point)) => {
            if skin.fixes(hold) {
                Role::Fixed
            } else {
                Role::Skin(hold)
            }
        }
        Around::Unseen | Around::One(_) => Role::Free,
        Around::Two(NO_AGGREGATE, grain) | Around::Two(grain, NO_AGGREGATE) => Role::Surface(*grain),
        Around::Two(..) | Around::Many => Role::Contact,
    };
    mesh.points.par_iter().zip(&around(mesh)).enumerate().map(role).collect()
}

/// Gives the tetrahedra whose nodes all lie between materials the grain of their centroid: no interface moves, but
/// the mortar gets gaps back that were closed, and a grain what lies under its faces.
pub(super) fn relabel(mesh: &mut Tetrahedra, places: &Places, locator: &Locator) {
    let around = around(mesh);
    let between = |node: &u32| matches!(around[*node as usize], Around::Two(..) | Around::Many);
    mesh.cells.par_iter().zip(&mut mesh.grain).filter(|(cell, _)| cell.iter().all(between)).for_each(
        |(cell, grain)| {
            let centroid = cell.iter().map(|&node| places.get(node)).sum::<Vec3>() / 4.0;
            *grain = locator.find(&centroid).map_or(NO_AGGREGATE, |(found, _)| found as u32);
        },
    );
}

/// The materials of the tetrahedra around a node.
#[derive(Clone, Copy)]
enum Around {
    Unseen,
    One(u32),
    Two(u32, u32),
    Many,
}

fn around(mesh: &Tetrahedra) -> Vec<Around> {
    let mut all = vec![Around::Unseen; mesh.points.len()];
    for (cell, &grain) in mesh.cells.iter().zip(&mesh.grain) {
        for &node in cell {
            let around = &mut all[node as usize];
            *around = match *around {
                Around::Unseen => Around::One(grain),
                Around::One(a) if a != grain => Around::Two(a, grain),
                Around::Two(a, b) if a != grain && b != grain => Around::Many,
                same => same,
            };
        }
    }
    all
}

/// Nodes on a surface, free ones that share a tetrahedron with them, and all on faces across which a box repeats itself.
pub(super) fn near_surface(mesh: &Tetrahedra, roles: &[Role]) -> Vec<bool> {
    let on = |node: u32| match roles[node as usize] {
        Role::Surface(_) | Role::Contact => true,
        Role::Skin(hold) => hold.outer,
        Role::Fixed | Role::Twin(_) | Role::Free => false,
    };
    let mut active: Vec<bool> = (0..roles.len() as u32).map(on).collect();
    for cell in mesh.cells.iter().filter(|cell| cell.iter().any(|&node| on(node))) {
        let free = cell.iter().filter(|&&node| matches!(roles[node as usize], Role::Free | Role::Skin(_)));
        free.for_each(|&node| active[node as usize] = true);
    }
    // Those that are moved at last, together with their images.
    active.iter_mut().zip(roles).filter(|(_, role)| **role == Role::Fixed).for_each(|(active, _)| *active = true);
    active
}
