//! What the nodes of a cut lattice may do, by the bodies of the tetrahedra around them.

use super::boundary::{Boundary, Hold};
use crate::math::{Aabb, Vec3};
use crate::mesh::cells::NO_BODY;
use crate::mesh::location::Locator;
use crate::mesh::tet::TetMesh;
use rayon::prelude::*;

/// What a node may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Role {
    /// None: it lies on a side of a box that has to match the opposite one.
    Fixed,
    /// The same at the end of the fit: slide in the sides across these axes, together with its images.
    Paired([bool; 3]),
    /// Slide along a body it lies on, where a gap was closed between several bodies.
    Contact,
    /// Slide along the surface of this body.
    Surface(u32),
    /// Slide along the specimen's own surface.
    Boundary(Hold),
    /// Move freely: all its tetrahedra are of one body, or of the mortar.
    Free,
}

/// The roles of all nodes.
///
/// Nodes on sides that have to match opposite ones stay where they are, those on other flat sides slide in these.
pub(super) fn roles(mesh: &TetMesh, domain: &Aabb, boundary: &Boundary) -> Vec<Role> {
    let wall = |p: &Vec3| [0, 1, 2].map(|i| p[i] <= domain.min[i] || p[i] >= domain.max[i]);
    let role = |(node, (point, around)): (usize, (&Vec3, &Around))| match around {
        _ if let Some(hold) = boundary.hold(node, wall(point)) => {
            if boundary.fixes(hold) {
                Role::Fixed
            } else {
                Role::Boundary(hold)
            }
        }
        Around::Unseen | Around::One(_) => Role::Free,
        Around::Two(NO_BODY, body) | Around::Two(body, NO_BODY) => Role::Surface(*body),
        Around::Two(..) | Around::Many => Role::Contact,
    };
    mesh.points.par_iter().zip(&around(mesh)).enumerate().map(role).collect()
}

/// Gives the tetrahedra whose nodes all lie between materials the body of their centroid: no interface moves, but
/// the mortar gets gaps back that were closed, and a body what lies under its faces.
pub(super) fn relabel(mesh: &mut TetMesh, locator: &Locator) {
    let around = around(mesh);
    let between = |node: &u32| matches!(around[*node as usize], Around::Two(..) | Around::Many);
    let TetMesh { points, cells, owner } = mesh;
    cells.par_iter().zip(owner).filter(|(cell, _)| cell.iter().all(between)).for_each(|(cell, owner)| {
        let centroid = cell.iter().map(|&node| points[node as usize]).sum::<Vec3>() / 4.0;
        *owner = locator.find(&centroid).map_or(NO_BODY, |(found, _)| found as u32);
    });
}

/// The materials of the tetrahedra around a node.
#[derive(Clone, Copy)]
enum Around {
    Unseen,
    One(u32),
    Two(u32, u32),
    Many,
}

fn around(mesh: &TetMesh) -> Vec<Around> {
    let mut all = vec![Around::Unseen; mesh.points.len()];
    for (cell, &body) in mesh.cells.iter().zip(&mesh.owner) {
        for &node in cell {
            let around = &mut all[node as usize];
            *around = match *around {
                Around::Unseen => Around::One(body),
                Around::One(a) if a != body => Around::Two(a, body),
                Around::Two(a, b) if a != body && b != body => Around::Many,
                same => same,
            };
        }
    }
    all
}

/// Nodes on a surface, free ones that share a tetrahedron with them, and all on faces across which a box repeats itself.
pub(super) fn near_surface(mesh: &TetMesh, roles: &[Role]) -> Vec<bool> {
    let on = |node: u32| match roles[node as usize] {
        Role::Surface(_) | Role::Contact => true,
        Role::Boundary(hold) => hold.outer,
        Role::Fixed | Role::Paired(_) | Role::Free => false,
    };
    let mut active: Vec<bool> = (0..roles.len() as u32).map(on).collect();
    for cell in mesh.cells.iter().filter(|cell| cell.iter().any(|&node| on(node))) {
        let free = cell.iter().filter(|&&node| matches!(roles[node as usize], Role::Free | Role::Boundary(_)));
        free.for_each(|&node| active[node as usize] = true);
    }
    // Those that are moved at last, together with their images.
    active.iter_mut().zip(roles).filter(|(_, role)| **role == Role::Fixed).for_each(|(active, _)| *active = true);
    active
}
