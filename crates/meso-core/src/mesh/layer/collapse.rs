//! Rails that collapse: the inner end becomes the outer one, and the cells that hold both are gone.
//!
//! A rail is an edge of one of the three tetrahedra of each prism around it, and of no other cell, so that neighbours
//! still match.

use super::blunt::{NO_RAIL, Task, star, stars, tetrahedra};
use crate::mesh::{Mesh, clip};

/// Collapses the rails of the `sharp` cells where that leaves blunter ones; cells that are gone become `dead`. Returns how
/// many rails did.
pub(super) fn collapse(mesh: &mut Mesh, task: &Task, sharp: &[u32], dead: &mut [bool]) -> usize {
    let mut nodes = task.nodes(mesh, sharp);
    nodes.retain(|&node| task.outer[node as usize] != NO_RAIL);
    let stars = stars(mesh, &nodes);
    let mut collapsed = 0;
    for &node in &nodes {
        let cells: Vec<u32> = stars.cells(node).iter().filter(|&&cell| !dead[cell as usize]).copied().collect();
        let end = task.outer[node as usize];
        let (gone, rest): (Vec<u32>, Vec<u32>) =
            cells.iter().partition(|&&cell| tetrahedra(mesh)[cell as usize].contains(&end));
        let before = star(mesh, node, &cells).sharpest_first();
        let after = star(mesh, node, &rest).worst(&mesh.points[end as usize], before);
        if before > task.limit && after < before {
            for cell in gone {
                dead[cell as usize] = true;
                // In no other node's star any more.
                mesh.cells[4 * cell as usize..][..4].fill(end);
            }
            for cell in rest {
                let nodes = &mut mesh.cells[4 * cell as usize..][..4];
                nodes.iter_mut().filter(|corner| **corner == node).for_each(|corner| *corner = end);
            }
            collapsed += 1;
        }
    }
    collapsed
}

/// Leaves out the `dead` cells, and the nodes that no other has.
pub(super) fn bury(mesh: &mut Mesh, dead: &[bool]) {
    if dead.contains(&true) {
        let alive: Vec<bool> = dead.iter().map(|dead| !dead).collect();
        clip::retain(mesh, &alive);
    }
}
