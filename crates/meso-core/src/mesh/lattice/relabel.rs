//! Cells at nodes that lie off their grain go to the other material, where that leaves fewer nodes off.
//!
//! At closed gaps a node may keep cells of a grain that it does not lie on, when the cells of the one that it lies on have
//! gone to the mortar. These cells stand out of their grain, or the mortar's into it: their label changes, and no angle.

use super::fit::Fit;
use super::roles::Role;
use crate::mesh::NO_AGGREGATE;

/// Cells with the label that they are to get, and the roles of their nodes after that.
pub(super) struct Change {
    pub(super) cells: Vec<u32>,
    pub(super) label: u32,
    pub(super) roles: Vec<(u32, Role)>,
}

/// A change of labels after which `node`, which lies off its grains, has cells of one material, and no other node is off
/// that was not before. The mortar comes first.
pub(super) fn relabelled(fit: &Fit, node: u32) -> Option<Change> {
    if !matches!(fit.roles[node as usize], Role::Surface(_) | Role::Contact) {
        return None;
    }
    labels(fit, node, &[], NO_AGGREGATE).into_iter().rev().find_map(|label| {
        let all = fit.stars.cells(node).iter().copied();
        let cells: Vec<u32> = all.filter(|&cell| fit.mesh.grain[cell as usize] != label).collect();
        let mut nodes: Vec<u32> = cells.iter().flat_map(|&cell| fit.mesh.cells[cell as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let role = |&other: &u32| {
            let between = matches!(fit.roles[other as usize], Role::Surface(_) | Role::Contact);
            let (now, then) = (labels(fit, other, &[], label), labels(fit, other, &cells, label));
            let fine = !is_off(fit, other, &then) || other != node && is_off(fit, other, &now);
            (between && fine).then_some((other, role(&then)))
        };
        nodes.iter().map(role).collect::<Option<Vec<_>>>().map(|roles| Change { cells, label, roles })
    })
}

/// The labels around a node once `changed` cells have `label`, ascending.
fn labels(fit: &Fit, node: u32, changed: &[u32], label: u32) -> Vec<u32> {
    let of = |cell: &u32| if changed.contains(cell) { label } else { fit.mesh.grain[*cell as usize] };
    let mut labels: Vec<u32> = fit.stars.cells(node).iter().map(of).collect();
    labels.sort_unstable();
    labels.dedup();
    labels
}

/// Whether a node between these materials lies on none of the grains.
fn is_off(fit: &Fit, node: u32, labels: &[u32]) -> bool {
    let on = |grain: &u32| *grain != NO_AGGREGATE && fit.surfaces[*grain as usize].has(&fit.places.get(node));
    labels.len() > 1 && !labels.iter().any(on)
}

fn role(labels: &[u32]) -> Role {
    match *labels {
        [_] => Role::Free,
        [grain, NO_AGGREGATE] => Role::Surface(grain),
        _ => Role::Contact,
    }
}
