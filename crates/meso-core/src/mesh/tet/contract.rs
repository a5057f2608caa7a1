//! Contraction and insertion: one node less, or one more, in the same volume.
//!
//! Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement" (2007).

use super::topology::{NEW, Replacement, Topology};

/// The cells around `node` once it is contracted onto `into`, where that leaves all of them better than `limit`: those that have
/// both nodes are gone, the others fill their volume.
pub(in crate::mesh) fn contraction(topology: &Topology, node: u32, into: u32, limit: f64) -> Option<Replacement> {
    let old = topology.star(node).to_vec();
    let renamed = |&cell: &u32| (topology.cell(cell).map(|n| if n == node { into } else { n }), topology.owner(cell));
    let rest = old.iter().filter(|&&cell| !topology.cell(cell).contains(&into)).map(renamed);
    if !rest.clone().all(|(nodes, _)| topology.cos2(nodes) < limit) {
        return None;
    }
    let new = rest.collect();
    Some(Replacement { old, new })
}

/// The cells around the edge from a to b, each halved at a [`NEW`] node on it.
pub(in crate::mesh) fn insertion(topology: &Topology, a: u32, b: u32) -> Replacement {
    let old = topology.around(&[a, b]);
    let half = |cell: u32, end: u32| {
        (topology.cell(cell).map(|node| if node == end { NEW } else { node }), topology.owner(cell))
    };
    let new = old.iter().flat_map(|&cell| [half(cell, a), half(cell, b)]).collect();
    Replacement { old, new }
}
