//! Gaps that a mesh closes, since its elements cannot show them: between aggregates, and to the specimen's sides.
//!
//! Counted in the finished mesh, whatever its method: a node is such a place when it has cells of two aggregates, or of
//! one and lies on a flat side of the specimen across which this does not repeat itself.

use super::cells::Mesh;
use super::interface::Owners;
use super::sides::FlatSides;
use crate::aggregate::Aggregate;
use crate::gjk;
use rayon::prelude::*;

/// Notes where `mesh`, before its materials are parted, joins `bodies`, and how wide the gaps between these are.
pub(super) fn note(mesh: &mut Mesh, bodies: &[Aggregate], sides: &FlatSides) {
    let owners = Owners::of(mesh.by_aggregate());
    let on_side = |node: u32| sides.have(&mesh.points[node as usize]);
    let members = owners.bodies(|node| owners.are_several(node) || on_side(node));
    let bodies = ById::new(bodies);
    let (mut pairs, mut at_sides) = (Vec::new(), Vec::new());
    let notes = &mut mesh.notes;
    for place in members.chunk_by(|a, b| a.0 == b.0) {
        let node = place[0].0;
        if place.len() > 1 {
            notes.closed_gaps += 1;
        }
        for (i, (_, higher)) in place.iter().enumerate() {
            pairs.extend(place[..i].iter().map(|(_, lower)| (*lower, *higher)));
        }
        let x = &mesh.points[node as usize];
        if sides.have(x) {
            notes.closed_side_gaps += 1;
            at_sides.extend(place.iter().map(|(_, id)| (*id, sides.across(x))));
        }
    }
    pairs.par_sort_unstable();
    pairs.dedup();
    notes.closed_gap_pairs = pairs.len();
    notes.widest_closed_gap_mm = bodies.widest(&pairs);
    at_sides.sort_unstable();
    at_sides.dedup();
    notes.closed_side_gap_aggregates = at_sides.chunk_by(|a, b| a.0 == b.0).count();
    let gaps = at_sides.iter().map(|(id, across)| bodies.gap_to_side(*id, *across, sides));
    notes.widest_closed_side_gap_mm = gaps.fold(0.0, f64::max);
}

/// Pairs whose widest gap is kept together.
const RUN: usize = 1 << 12;

/// Bodies, those of one id beside each other: images have the id of their body.
struct ById<'a>(Vec<&'a Aggregate>);

impl<'a> ById<'a> {
    fn new(bodies: &'a [Aggregate]) -> Self {
        let mut by_id: Vec<&Aggregate> = bodies.iter().collect();
        by_id.sort_by_key(|body| body.id);
        Self(by_id)
    }

    fn images(&self, id: u32) -> impl Iterator<Item = &'a Aggregate> {
        let start = self.0.partition_point(|body| body.id < id);
        self.0[start..].iter().copied().take_while(move |body| body.id == id)
    }

    /// The widest gap between the bodies of a pair, mm.
    fn widest(&self, pairs: &[(u32, u32)]) -> f64 {
        let wider = |widest: f64, &(a, b): &(u32, u32)| {
            let all =
                || self.images(a).flat_map(|a| self.images(b).map(move |b| [a, b].map(|body| body.body.vertices())));
            // Bodies have vertices, so that there are answers. Most pairs are done with by the first, which is much cheaper.
            let is_wider = all().all(|[a, b]| gjk::farther(a, b, widest).unwrap_or(false));
            let gap = || all().map(|[a, b]| gjk::distance(a, b).unwrap_or(0.0)).fold(f64::INFINITY, f64::min);
            if is_wider { gap() } else { widest }
        };
        pairs.par_chunks(RUN).map(|run| run.iter().fold(0.0, wider)).reduce(|| 0.0, f64::max)
    }

    /// Between a body and the farthest of the sides `across`, mm.
    fn gap_to_side(&self, id: u32, across: u8, sides: &FlatSides) -> f64 {
        let gaps = self.images(id).map(|body| sides.gap(&body.body.aabb(), across));
        gaps.fold(f64::INFINITY, f64::min)
    }
}
