//! Rails that collapse together, where the collapse of each alone would turn a neighbour over.
//!
//! A group begins with the rails of one sharp cell. Where their collapse leaves cells as sharp as those that it mends, the
//! rails of these join the group, for [`WAVES`] times: with all rails around gone the aggregate's cells are nearly the old
//! ones, none of which was sharp.

use super::blunt::{NO_RAIL, Task, stars, tetrahedra};
use crate::mesh::Mesh;
use crate::mesh::lattice::{Stars, sharpness};

/// How often a group grows.
const WAVES: usize = 4;

/// Collapses groups of rails around the `sharp` cells, with their images, where that leaves blunter ones; cells that are
/// gone become `dead`. Returns how many rails did, and adds the cells around them to `suspects`.
pub(super) fn collapse_together(
    mesh: &mut Mesh,
    task: &Task,
    sharp: &[u32],
    dead: &mut [bool],
    suspects: &mut Vec<u32>,
) -> usize {
    let mut groups: Vec<Group> = sharp.iter().map(|&cell| Group { nodes: rails(mesh, task, &[cell]) }).collect();
    let mut collapsed = 0;
    for _ in 0..WAVES {
        let mut nodes: Vec<u32> = groups.iter().flat_map(|group| group.nodes.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let stars = stars(mesh, &nodes);
        groups.retain_mut(|group| match group.tried(mesh, task, &stars, dead, suspects) {
            Tried::Collapsed => {
                collapsed += group.nodes.len();
                false
            }
            Tried::Grown => true,
            Tried::InVain => false,
        });
    }
    collapsed
}

/// Inner ends of rails.
struct Group {
    nodes: Vec<u32>,
}

/// What came of a group.
enum Tried {
    Collapsed,
    Grown,
    InVain,
}

impl Group {
    /// Collapses, or grows by the rails of the cells that forbid it.
    fn tried(
        &mut self,
        mesh: &mut Mesh,
        task: &Task,
        stars: &Stars,
        dead: &mut [bool],
        suspects: &mut Vec<u32>,
    ) -> Tried {
        let mut cells: Vec<u32> = self.nodes.iter().flat_map(|&node| stars.cells(node)).copied().collect();
        cells.sort_unstable();
        cells.dedup();
        cells.retain(|&cell| !dead[cell as usize]);
        // Another group may have taken some of them.
        self.nodes.retain(|node| cells.iter().any(|&cell| tetrahedra(mesh)[cell as usize].contains(node)));
        let sharpness_of = |nodes: [u32; 4]| sharpness(nodes.map(|node| mesh.points[node as usize]));
        let now = |cell: u32| tetrahedra(mesh)[cell as usize];
        let before = cells.iter().map(|&cell| sharpness_of(now(cell))).fold(-1.0, f64::max);
        if before <= task.limit {
            return Tried::InVain;
        }
        let then = |cell: u32| self.collapsed(task, now(cell));
        let forbids = |cell: &u32| then(*cell).is_some_and(|nodes| sharpness_of(nodes) >= before);
        let forbidding: Vec<u32> = cells.iter().copied().filter(forbids).collect();
        if forbidding.is_empty() {
            let all: Vec<(u32, Option<[u32; 4]>)> = cells.iter().map(|&cell| (cell, then(cell))).collect();
            for (cell, nodes) in all {
                dead[cell as usize] |= nodes.is_none();
                // What is gone keeps an outer end alone: it is in no moving node's star any more.
                let nodes = nodes.unwrap_or([task.outer[self.nodes[0] as usize]; 4]);
                mesh.cells[4 * cell as usize..][..4].copy_from_slice(&nodes);
            }
            suspects.extend(cells);
            return Tried::Collapsed;
        }
        let count = self.nodes.len();
        self.nodes.extend(rails(mesh, task, &forbidding));
        self.nodes.sort_unstable();
        self.nodes.dedup();
        if self.nodes.len() > count { Tried::Grown } else { Tried::InVain }
    }

    /// The cell's nodes after the collapse; `None` where it is gone with a rail of its own.
    fn collapsed(&self, task: &Task, nodes: [u32; 4]) -> Option<[u32; 4]> {
        let ends = nodes.map(|node| match self.nodes.binary_search(&node) {
            Ok(_) => task.outer[node as usize],
            Err(_) => node,
        });
        let twice = (0..4).any(|i| ends[..i].contains(&ends[i]));
        (!twice).then_some(ends)
    }
}

/// The inner ends of the rails that `cells` hold an end of, with their images, ascending.
fn rails(mesh: &Mesh, task: &Task, cells: &[u32]) -> Vec<u32> {
    let mut nodes = task.nodes(mesh, cells);
    nodes.retain(|&node| task.faces.images(node).into_iter().all(|image| task.outer[image as usize] != NO_RAIL));
    nodes
}
