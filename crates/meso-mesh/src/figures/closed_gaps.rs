//! The gaps that a mesh closes, where its elements cannot show them: between aggregates, and to the specimen's sides.
//!
//! They are counted in the finished mesh, whatever its method: a node closes one when it has cells of two aggregates, or of one and
//! lies on a flat side of the specimen across which this does not repeat itself. Where a cap lies in the side, there was no gap.

use crate::body_images::BodyImages;
use crate::cells::{FlatSides, Mesh, Owners, pairs};
use meso_collision::posed::{Posed, WithTree};
use meso_concrete::parallel;

/// Notes where `mesh`, before its materials are parted, joins `bodies`, and how wide the gaps between these are.
pub(crate) fn note_closed_gaps(mesh: &mut Mesh, bodies: &BodyImages, sides: &FlatSides) {
    let owners = Owners::of(mesh.by_owner());
    let on_side = |node: u32| sides.have(&mesh.points[node as usize]);
    let members = owners.bodies(|node| owners.are_several(node) || on_side(node));
    let (pairs, mut at_sides) = (pairs(&members), Vec::new());
    let notes = &mut mesh.notes;
    for meet in members.chunk_by(|a, b| a.0 == b.0) {
        let node = meet[0].0;
        if meet.len() > 1 {
            notes.closed_gaps += 1;
        }
        let across = sides.across(&mesh.points[node as usize]);
        let gaps = |&(_, body): &(u32, u32)| (body, across & !bodies.caps(body));
        let first = at_sides.len();
        at_sides.extend(meet.iter().map(gaps).filter(|(_, across)| *across != 0));
        notes.closed_side_gaps += usize::from(at_sides.len() > first);
    }
    notes.closed_gap_pairs = pairs.len();
    notes.widest_closed_gap_mm = widest(bodies, &pairs);
    at_sides.sort_unstable();
    at_sides.dedup();
    notes.closed_side_gap_aggregates = at_sides.chunk_by(|a, b| a.0 == b.0).count();
    let gap = |&(body, across): &(u32, u8)| {
        bodies.images(body).iter().map(|body| sides.gap(&body.body.aabb(), across)).fold(f64::INFINITY, f64::min)
    };
    notes.widest_closed_side_gap_mm = at_sides.iter().map(gap).fold(0.0, f64::max);
}

/// Pairs whose widest gap is kept together.
const RUN: usize = 1 << 12;

/// The widest gap between the `bodies` of a pair, mm.
fn widest(bodies: &BodyImages, pairs: &[(u32, u32)]) -> f64 {
    let wider = |widest: f64, &(a, b): &(u32, u32)| {
        let all = || {
            bodies
                .images(a)
                .iter()
                .flat_map(|a| bodies.images(b).iter().map(move |b| [&a.body, &b.body].map(WithTree::new)))
        };
        // Bodies have vertices, so that there are answers. Most pairs are done with by the first, which is much cheaper.
        let is_wider = all().all(|[a, b]| a.is_farther(&b, widest).unwrap_or(false));
        let gap = || all().map(|[a, b]| a.distance(&b).unwrap_or(0.0)).fold(f64::INFINITY, f64::min);
        if is_wider { gap() } else { widest }
    };
    let runs: Vec<&[(u32, u32)]> = pairs.chunks(RUN).collect();
    parallel::map_each(&runs, |run| run.iter().fold(0.0, wider)).into_iter().fold(0.0, f64::max)
}
