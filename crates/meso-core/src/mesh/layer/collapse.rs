//! Rails that collapse: the inner end becomes the outer one, and the cells that hold both are gone.
//!
//! A rail is an edge of one of the three tetrahedra of each prism around it, and of no other cell, so that neighbours
//! still match.

use super::blunt::{NO_RAIL, Task, star, stars, tetrahedra};
use crate::mesh::{Mesh, clip};

/// Collapses the rails of the `sharp` cells, with their images, where that leaves blunter ones; cells that are gone become
/// `dead`. Returns how many rails did.
pub(super) fn collapse(mesh: &mut Mesh, task: &Task, sharp: &[u32], dead: &mut [bool]) -> usize {
    let mut nodes = task.nodes(mesh, sharp);
    let is_rail = |node: u32| task.outer[node as usize] != NO_RAIL;
    nodes.retain(|&node| task.faces.images(node).into_iter().all(is_rail));
    let stars = stars(mesh, &nodes);
    let mut collapsed = 0;
    for &node in &nodes {
        let images = task.faces.images(node);
        // All at once, when their first comes up.
        if images[0] != node {
            continue;
        }
        let rail = |&image: &u32| Rail::new(mesh, task, image, stars.cells(image), dead);
        let rails: Vec<Rail> = images.iter().map(rail).collect();
        let before = rails.iter().map(|rail| rail.before(mesh)).fold(-1.0, f64::max);
        let after = rails.iter().map(|rail| rail.after(mesh, before)).fold(-1.0, f64::max);
        if before > task.limit && after < before {
            rails.iter().for_each(|rail| rail.collapse(mesh, dead));
            collapsed += rails.len();
        }
    }
    collapsed
}

/// The inner end of a rail with the cells around it.
struct Rail {
    node: u32,
    /// The outer end.
    end: u32,
    /// The cells that go with the rail.
    gone: Vec<u32>,
    rest: Vec<u32>,
}

impl Rail {
    fn new(mesh: &Mesh, task: &Task, node: u32, cells: &[u32], dead: &[bool]) -> Self {
        let end = task.outer[node as usize];
        let alive = cells.iter().filter(|&&cell| !dead[cell as usize]);
        let (gone, rest) = alive.partition(|&&cell| tetrahedra(mesh)[cell as usize].contains(&end));
        Self { node, end, gone, rest }
    }

    fn before(&self, mesh: &Mesh) -> f64 {
        star(mesh, self.node, &[self.gone.as_slice(), &self.rest].concat()).sharpest_first()
    }

    fn after(&self, mesh: &Mesh, limit: f64) -> f64 {
        star(mesh, self.node, &self.rest).worst(&mesh.points[self.end as usize], limit)
    }

    fn collapse(&self, mesh: &mut Mesh, dead: &mut [bool]) {
        for &cell in &self.gone {
            dead[cell as usize] = true;
            // In no other node's star any more.
            mesh.cells[4 * cell as usize..][..4].fill(self.end);
        }
        for &cell in &self.rest {
            let nodes = &mut mesh.cells[4 * cell as usize..][..4];
            nodes.iter_mut().filter(|corner| **corner == self.node).for_each(|corner| *corner = self.end);
        }
    }
}

/// Leaves out the `dead` cells, and the nodes that no other has.
pub(super) fn bury(mesh: &mut Mesh, dead: &[bool]) {
    if dead.contains(&true) {
        let alive: Vec<bool> = dead.iter().map(|dead| !dead).collect();
        clip::retain(mesh, &alive);
    }
}
