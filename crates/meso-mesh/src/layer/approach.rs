//! Nodes that are short of their targets go nearer to them, one after the other.
//!
//! All nodes of a bad cell step back together, though most need not have: the others made room. So each goes to the nearest
//! position to its target, straight ahead or beside, at which the cells around it are fine while all others stay where they
//! are; then those around that have more room now (layers of 1 mm on polyhedra in elements of 0.5 mm: 22 to 2.8 % rms).

use super::periodic::PeriodicConstraint;
use super::prisms::{LayerCell, least_of_core, least_of_layer};
use crate::tet::{Incidence, TetMesh, directions, volume};
use meso_collision::math::Vec3;
use meso_concrete::{parallel, stop};

/// Rounds over the nodes that are short.
const ROUNDS: usize = 60;
/// Shares of the way to the target that are tried straight ahead, and as steps beside it.
const AHEAD: [f64; 5] = [1.0, 0.8, 0.6, 0.4, 0.2];
const BESIDE: [f64; 4] = [0.8, 0.5, 0.25, 0.1];
/// A node goes nowhere where more than this share of the way would be left.
const LEFT: f64 = 0.995;

/// The position nearest to `target` for a node at `x` among those tried that `allows` holds for; `None` where it is hardly nearer.
/// A node moves `along` its faces only.
pub(super) fn nearer(
    x: &Vec3,
    target: &Vec3,
    along: impl Fn(&Vec3) -> Vec3,
    mut allows: impl FnMut(&Vec3) -> bool,
) -> Option<Vec3> {
    let way = target - x;
    let length = way.norm();
    let beside = |step: f64| directions().map(move |direction| direction * (step * length));
    let steps = AHEAD.iter().map(|share| way * *share).chain(BESIDE.into_iter().flat_map(beside));
    let positions = steps.map(|step| x + along(&step));
    let mut tried: Vec<(f64, Vec3)> = positions.map(|position| ((target - position).norm(), position)).collect();
    tried.retain(|(left, _)| *left < LEFT * length);
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried.into_iter().map(|(_, position)| position).find(|position| allows(position))
}

/// Moves nodes from their positions `at` nearer to their `targets`, so that all cells of `mesh` and of `layer` stay fine.
pub(super) fn approach(
    mesh: &TetMesh,
    layer: &[LayerCell],
    constraint: &PeriodicConstraint,
    targets: &[Vec3],
    at: &mut [Vec3],
) {
    let is_short = |node: u32| at[node as usize] != targets[node as usize] && !constraint.is_pinned(node);
    let short = parallel::filter(at.len(), |node| constraint.leads(node as u32) && is_short(node as u32));
    if short.is_empty() {
        return;
    }
    let around = Around::new(mesh, layer, constraint, &short);
    let mut stirred = vec![true; at.len()];
    for _ in 0..ROUNDS {
        let mut stirred_now = vec![false; at.len()];
        for &lead in &short {
            stop::point();
            let tied = constraint.tied(lead);
            if !around.nodes(&tied).any(|node| stirred[node as usize]) {
                continue;
            }
            let allows = |x: &Vec3| around.are_fine(&tied, lead, x, at);
            let along = |step: &Vec3| constraint.flat(lead).along(step);
            if let Some(x) = nearer(&at[lead as usize], &targets[lead as usize], along, allows) {
                for &node in &tied {
                    at[node as usize] = constraint.faces.put(node, &x);
                    stirred_now[node as usize] = true;
                }
            }
        }
        if !stirred_now.contains(&true) {
            break;
        }
        stirred = stirred_now;
    }
}

/// The cells around the nodes that are short, and those tied to them.
struct Around<'a> {
    mesh: &'a TetMesh,
    constraint: &'a PeriodicConstraint,
    of_mesh: Incidence,
    /// The layer's cells that have one of the nodes.
    layer: Vec<LayerCell>,
    of_layer: Incidence,
}

impl<'a> Around<'a> {
    fn new(mesh: &'a TetMesh, layer: &[LayerCell], constraint: &'a PeriodicConstraint, short: &[u32]) -> Self {
        let tied = || short.iter().flat_map(|&lead| constraint.tied(lead));
        let of_mesh = Incidence::around(&mesh.cells, mesh.points.len(), tied());
        let layer = parallel::pick(layer, |cell| cell.nodes.iter().any(|&node| of_mesh.tracks(node)));
        let cells: Vec<[u32; 4]> = layer.iter().map(|cell| cell.nodes).collect();
        let of_layer = Incidence::around(&cells, mesh.points.len(), tied());
        Self { mesh, constraint, of_mesh, layer, of_layer }
    }

    fn cells(&self, node: u32) -> impl Iterator<Item = [u32; 4]> {
        self.of_mesh.cells(node).iter().map(|&cell| self.mesh.cell(cell))
    }

    fn layer_cells(&self, node: u32) -> impl Iterator<Item = &LayerCell> {
        self.of_layer.cells(node).iter().map(|&cell| &self.layer[cell as usize])
    }

    /// The nodes of all cells around these.
    fn nodes(&self, of: &[u32]) -> impl Iterator<Item = u32> {
        let around = |&node: &u32| self.cells(node).chain(self.layer_cells(node).map(|cell| cell.nodes));
        of.iter().flat_map(around).flatten()
    }

    /// Whether all cells around the nodes `tied` to a lead are fine with the lead at `x` and the other nodes `at` their positions.
    fn are_fine(&self, tied: &[u32], lead: u32, x: &Vec3, at: &[Vec3]) -> bool {
        let now = |node: u32| match self.constraint.lead(node) == lead {
            true => self.constraint.faces.put(node, x),
            false => at[node as usize],
        };
        let is_fine = |cell: [u32; 4]| volume(cell.map(now)) > least_of_core(self.mesh.corners(cell), cell.map(now));
        let is_fine_in_layer = |cell: &LayerCell| {
            let rail = cell.rail.map(now);
            rail[0] == rail[1] || volume(cell.nodes.map(now)) > least_of_layer(cell, rail)
        };
        tied.iter().all(|&node| self.cells(node).all(is_fine) && self.layer_cells(node).all(is_fine_in_layer))
    }
}
