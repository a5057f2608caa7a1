//! Aggregates that a mesh joins: the gaps between them are thinner than its elements can show.
//!
//! Counted in the finished mesh, whatever its method: a node is such a place when it has cells of two aggregates.

use super::{Mesh, distance};
use crate::aggregate::Aggregate;
use crate::gjk;
use rayon::prelude::*;

/// Notes where `mesh`, before its materials are parted, joins `bodies`, and how wide the gaps between these are.
pub(super) fn note(mesh: &mut Mesh, bodies: &[Aggregate]) {
    let members = distance::interface_nodes(mesh);
    let mut pairs = Vec::new();
    for place in members.chunk_by(|a, b| a.0 == b.0).filter(|place| place.len() > 1) {
        mesh.notes.closed_gaps += 1;
        for (i, (_, higher)) in place.iter().enumerate() {
            pairs.extend(place[..i].iter().map(|(_, lower)| (*lower, *higher)));
        }
    }
    pairs.par_sort_unstable();
    pairs.dedup();
    mesh.notes.closed_gap_pairs = pairs.len();
    mesh.notes.widest_closed_gap_mm = widest(&pairs, bodies);
}

/// Pairs whose widest gap is kept together.
const RUN: usize = 1 << 12;

/// The widest gap between the bodies of a pair, mm; images have the id of their body.
fn widest(pairs: &[(u32, u32)], bodies: &[Aggregate]) -> f64 {
    let mut by_id: Vec<&Aggregate> = bodies.iter().collect();
    by_id.sort_by_key(|body| body.id);
    let images = |id: u32| {
        let start = by_id.partition_point(|body| body.id < id);
        by_id[start..].iter().take_while(move |body| body.id == id)
    };
    let wider = |widest: f64, &(a, b): &(u32, u32)| {
        let all = || images(a).flat_map(|a| images(b).map(move |b| [a, b].map(|body| body.body.vertices())));
        // Bodies have vertices, so that there are answers. Most pairs are done with by the first, which is much cheaper.
        let is_wider = all().all(|[a, b]| gjk::farther(a, b, widest).unwrap_or(false));
        let gap = || all().map(|[a, b]| gjk::distance(a, b).unwrap_or(0.0)).fold(f64::INFINITY, f64::min);
        if is_wider { gap() } else { widest }
    };
    pairs.par_chunks(RUN).map(|run| run.iter().fold(0.0, wider)).reduce(|| 0.0, f64::max)
}
