//! Other nodes in the same room: one becomes one with a neighbour, or an edge gets one, where that leaves what is around less
//! sharp. Surfaces stay as they are ([`Seat`]).
//!
//! Contraction and insertion as of Klingner and Shewchuk, "Aggressive tetrahedral mesh improvement" (2007).

use super::seat::{Seat, between_materials};
use crate::math::Vec3;
use crate::mesh::NO_AGGREGATE;
use crate::mesh::lattice::{Star, sharpness_of};
use crate::mesh::swaps::are_in_a_plane;
use crate::mesh::web::Web;

/// Steps tried for a new node, in lengths of the edge that it divides.
const STEPS: [f64; 3] = [0.3, 0.1, 0.03];
/// A new node is worth it where the square of the smallest angle grows by this factor,
const WORTH: f64 = 2.0;
/// or by this one where that angle is below so many degrees.
const WORTH_WHERE_SHARP: (f64, f64) = (1.2, 2.0);
/// Share of what is to be reached that is reached by the first steps, or not at all.
const NEAR: f64 = 0.5;
/// Stands for a node that is not there yet.
const NEW: u32 = u32::MAX;

/// Makes `node` one with one of its neighbours `others` where that leaves no angle as sharp as the sharpest around it and no
/// altitude shorter; whether it did.
pub(super) fn join(web: &mut Web, node: u32, others: &[u32], seat: &Seat) -> bool {
    if !others.iter().any(|&into| seat.may_join(node, into)) {
        return false;
    }
    let old = web.star(node).to_vec();
    // The nodes inside a grain stay there: without any its solid ITZ would have nothing to go in to.
    if matches!(seat, Seat::Free) && web.grain(old[0]) != NO_AGGREGATE {
        return false;
    }
    let sharpest = web.sharpest(&old);
    for &into in others.iter().filter(|&&into| seat.may_join(node, into)) {
        let renamed = |&cell: &u32| (web.cell(cell).map(|n| if n == node { into } else { n }), web.grain(cell));
        let new = old.iter().filter(|&&cell| !web.cell(cell).contains(&into)).map(renamed);
        if new.clone().all(|(cell, _)| web.sharpness(cell) < sharpest) {
            let new: Vec<_> = new.collect();
            if web.replace_thicker(&old, &new) {
                return true;
            }
        }
    }
    false
}

/// Divides the edge from a to b by a new node at the best place around it where that makes the smallest angle there much
/// larger and no altitude shorter; whether it did.
pub(super) fn divide(web: &mut Web, a: u32, b: u32) -> bool {
    let old = web.around(&[a, b]);
    let Some(seat) = seat_on(web, &old, a, b) else { return false };
    let half = |cell: u32, end: u32| (web.cell(cell).map(|node| if node == end { NEW } else { node }), web.grain(cell));
    let halves: Vec<([u32; 4], u32)> = old.iter().flat_map(|&cell| [half(cell, a), half(cell, b)]).collect();
    let middle = (web.point(a) + web.point(b)) / 2.0;
    let mut star =
        Star::of_cells(NEW, halves.iter().copied(), |node| if node == NEW { middle } else { web.point(node) });
    let sharpest = web.sharpest(&old);
    let worth = if sharpest > sharpness_of(WORTH_WHERE_SHARP.1) { WORTH_WHERE_SHARP.0 } else { WORTH };
    let limit = 1.0 - worth * (1.0 - sharpest);
    let Some(place) = best(&mut star, (web.point(b) - web.point(a)).norm(), &seat, limit) else { return false };
    let node = web.add(place);
    let new: Vec<_> =
        halves.iter().map(|(cell, grain)| (cell.map(|n| if n == NEW { node } else { n }), *grain)).collect();
    let done = web.replace_thicker(&old, &new);
    if !done {
        web.take_back(node);
    }
    done
}

/// The best place found for the node of `star`, where it leaves no cell as sharp as `limit`; the first steps must come near that.
fn best(star: &mut Star, length: f64, seat: &Seat, limit: f64) -> Option<Vec3> {
    let (ways, mut best) = (seat.ways(), (star.sharpest_first(), star.centre()));
    for step in STEPS {
        let from = best.1;
        for place in ways.iter().map(|way| from + way * (step * length)) {
            let worst = star.worst(&place, best.0);
            if worst < best.0 {
                best = (worst, place);
            }
        }
        if 1.0 - best.0 < NEAR * (1.0 - limit) {
            return None;
        }
    }
    (best.0 < limit).then_some(best.1)
}

/// Where a node on the edge with the cells `around` may go; `None` on the outside of the mesh, or where these are not known.
fn seat_on(web: &Web, around: &[u32], a: u32, b: u32) -> Option<Seat> {
    let mut faces = Vec::with_capacity(2 * around.len());
    for &cell in around {
        let others = web.cell(cell).into_iter().filter(|node| ![a, b].contains(node));
        faces.extend(others.map(|other| (other, web.grain(cell))));
    }
    let sides = between_materials(faces)?;
    let [p, q] = [a, b].map(|end| web.point(end));
    match sides[..] {
        [] => (!around.is_empty()).then_some(Seat::Free),
        [x, y] if are_in_a_plane([p, q, web.point(x), web.point(y)]) => {
            let normal = (q - p).cross(&(web.point(x) - p));
            Some(Seat::Facet(normal / normal.norm(), vec![a, b, x, y]))
        }
        [_, _] => Some(Seat::Edge((q - p) / (q - p).norm(), [a, b])),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::lattice::{Tetrahedra, oriented};

    fn mesh(points: &[[f64; 3]], cells: &[[u32; 4]], grain: Vec<u32>) -> Tetrahedra {
        let points: Vec<Vec3> = points.iter().map(|place| Vec3::from(*place)).collect();
        let cells = cells.iter().map(|cell| oriented(*cell, &points)).collect();
        Tetrahedra { points, cells, grain }
    }

    fn volume(mesh: &Tetrahedra, grain: u32) -> f64 {
        let of = |(cell, _): (&[u32; 4], &u32)| {
            let [a, b, c, d] = cell.map(|node| mesh.points[node as usize]);
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        };
        mesh.cells.iter().zip(&mesh.grain).filter(|(_, own)| **own == grain).map(of).sum()
    }

    /// A flat cell under a blunt edge of a surface, 0-1, and what is below it down to node 4.
    fn under_a_blunt_edge() -> Tetrahedra {
        let points = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, -0.02], [0.0, 1.0, -0.02], [0.0, 0.0, -2.0]];
        mesh(&points, &[[0, 1, 2, 3], [2, 3, 1, 4], [2, 3, 4, 0]], vec![5; 3])
    }

    #[test]
    fn the_edge_that_makes_a_cell_flat_gets_a_node_far_from_it() {
        let mut mesh = under_a_blunt_edge();
        let before = volume(&mesh, 5);
        let mut web = Web::new(&mut mesh, &[0, 1, 2]);
        let sharpest = web.sharpest(&[0, 1, 2]);
        assert!(!divide(&mut web, 0, 1), "an edge on the outside stays");
        assert!(divide(&mut web, 2, 3));
        assert!(1.0 - web.sharpest(&[0, 1, 2, 3, 4, 5]) > 10.0 * (1.0 - sharpest));
        web.finish();
        assert_eq!((mesh.cells.len(), mesh.points.len()), (6, 6));
        assert!(mesh.points[5].z < -0.2 && (volume(&mesh, 5) - before).abs() < 1e-15);
    }

    /// A node on the edge between two facets of grain 5, 0.01 from that edge's end, all within grain 6.
    #[test]
    fn a_node_close_to_the_end_of_an_edge_becomes_one_with_it_and_the_facets_stay() {
        let ring = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].map(|[x, y]| [x, y, 0.3]);
        // The edge is 4-5-6, from the bottom to the top, and grain 5 between the first two of the ring.
        let line = [[0.0, 0.0, -1.0], [0.0, 0.0, 0.99], [0.0, 0.0, 1.0]];
        let cells: Vec<[u32; 4]> = (0..4).flat_map(|i| [[i, (i + 1) % 4, 4, 5], [i, (i + 1) % 4, 5, 6]]).collect();
        let mut mesh = mesh(&[&ring[..], &line].concat(), &cells, vec![5, 5, 6, 6, 6, 6, 6, 6]);
        let before = [5, 6].map(|grain| volume(&mesh, grain));
        let mut web = Web::new(&mut mesh, &[0, 1, 2, 3, 4, 5, 6, 7]);
        let seat = Seat::of(&web, 5);
        assert!(!join(&mut web, 5, &[0, 1, 2, 3], &seat), "not off its edge");
        assert!(join(&mut web, 5, &[0, 4, 5, 6], &seat));
        web.finish();
        assert_eq!((mesh.cells.len(), mesh.points.len()), (4, 6));
        assert!([5, 6].iter().zip(before).all(|(grain, before)| (volume(&mesh, *grain) - before).abs() < 1e-15));
    }

    #[test]
    fn a_new_node_between_two_materials_stays_in_their_facet_or_on_their_edge() {
        let seat = |height: f64| {
            let square = [[-1.0, 0.0, height], [1.0, 0.0, height], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
            let apexes = [[0.0, 0.0, -2.0], [0.0, 0.0, 2.0]];
            let cells = [[2, 3, 1, 4], [2, 3, 4, 0], [2, 3, 0, 5], [2, 3, 5, 1]];
            let mut mesh = mesh(&[&square[..], &apexes].concat(), &cells, vec![5, 5, 6, 6]);
            let web = Web::new(&mut mesh, &[0, 1, 2, 3]);
            seat_on(&web, &[0, 1, 2, 3], 2, 3)
        };
        assert!(matches!(seat(0.0), Some(Seat::Facet(normal, _)) if normal.z.abs() == 1.0));
        assert!(matches!(seat(0.3), Some(Seat::Edge(along, [2, 3])) if along.y.abs() == 1.0));
    }
}
