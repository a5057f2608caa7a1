//! The last of the fit: tetrahedra still sharper than the guard, one by one.
//!
//! Their nodes look further around than [`smooth`](super::smooth) does, and volume counts no more. Where that does not
//! help, the nodes of surfaces are let off them: angles come first ([`back`](super::back) brings back what it can).

use super::fit::{Fit, GUARD_DEG};
use super::roles::Role;
use super::smooth::Track;
use super::star::sharpness_of;
use crate::math::Vec3;
use rayon::prelude::*;

/// Tries with the nodes on their surfaces, then off them.
const TRIES: usize = 12;
/// Lengths of the steps tried, in elements.
const STEPS: [f64; 4] = [0.3, 0.1, 0.03, 0.01];

/// Mends what can be mended of `suspects`, tetrahedra, and of those around; returns the nodes that were let off the surfaces for it.
pub(super) fn mend(fit: &Fit, mut suspects: Vec<u32>) -> Vec<u32> {
    let limit = sharpness_of(GUARD_DEG);
    let mut released = Vec::new();
    for turn in 0..2 * TRIES {
        suspects = sharper(fit, suspects, limit);
        if suspects.is_empty() {
            break;
        }
        let mut nodes: Vec<u32> = suspects.iter().flat_map(|&cell| fit.mesh.cells[cell as usize]).collect();
        nodes.sort_unstable();
        nodes.dedup();
        for &node in &nodes {
            let off = turn >= TRIES;
            if better(fit, node, off) && off && fit.roles[node as usize] != Role::Free {
                released.push(node);
            }
        }
        suspects = nodes.iter().flat_map(|&node| fit.cells_around(node)).collect();
        suspects.sort_unstable();
        suspects.dedup();
    }
    released.sort_unstable();
    released.dedup();
    released
}

/// Those of `cells` that are sharper than `limit`.
fn sharper(fit: &Fit, cells: Vec<u32>, limit: f64) -> Vec<u32> {
    cells.into_par_iter().filter(|&cell| fit.sharpness(cell) > limit).collect()
}

/// Moves the node to the best place around it; false where it is there already.
pub(super) fn better(fit: &Fit, node: u32, released: bool) -> bool {
    let role = fit.roles[node as usize];
    if role == Role::Fixed || fit.stars.cells(node).is_empty() {
        return false;
    }
    let mut star = fit.star(node);
    let track = match role {
        Role::Twin(axes) => Track::Twin(node, axes),
        _ => Track::of(fit, &star, role),
    };
    let track = if released { track.released() } else { track };
    let mut best = (star.sharpest_first(), None);
    for length in STEPS {
        for way in ways() {
            let Some(place) = track.after(fit, &star.centre, &(way * length * fit.size)) else { continue };
            let worst = star.worst(&place, best.0);
            if worst < best.0 {
                best = (worst, Some(place));
            }
        }
    }
    if let Some(place) = best.1 {
        fit.go(node, &place);
    }
    best.1.is_some()
}

/// To the 26 neighbours in a grid.
pub(in crate::mesh) fn ways() -> impl Iterator<Item = Vec3> {
    let way = |i: i32| Vec3::new(f64::from(i % 3 - 1), f64::from(i / 3 % 3 - 1), f64::from(i / 9 - 1));
    (0..27).map(way).filter_map(|way| way.try_normalize(0.5))
}
