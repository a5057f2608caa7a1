//! Sharp cells of gmsh's mesh are mended, and no surface moves: by other cells in the same room ([`swaps`](crate::mesh::swaps)), by
//! better places for nodes, and by nodes less or more ([`nodes`](super::nodes)).
//!
//! Every step leaves the sharpest angle there less sharp than it was, no altitude shorter and every volume positive. Nodes on a
//! facet move within it, those on its edges along these, and both sides of a facet's triangles change alike ([`Seat`]): so
//! every aggregate stays what it is. What lies on the outside of the mesh stays, too, for it may have to match the opposite side.

use super::nodes::{divide, join};
use super::seat::Seat;
use crate::mesh::lattice::{Star, Tetrahedra, sharpness, sharpness_of};
use crate::mesh::swaps::swapped;
use crate::mesh::web::Web;
use rayon::prelude::*;

/// Cells with a smaller angle are mended, degrees (somewhat more than what counts as bad), and how many times those are looked
/// at that are still poor where something changed; the sharpest once more at the end.
const TURNS: [(f64, usize); 2] = [(10.0, 4), (3.0, 8)];
/// Steps tried, in lengths of the node's shortest edge.
const STEPS: [f64; 3] = [0.3, 0.1, 0.03];

/// Mends the poor cells of `mesh`.
pub(super) fn mend(mesh: &mut Tetrahedra) {
    let of = |cell: &[u32; 4]| sharpness(cell.map(|node| mesh.points[node as usize]));
    let limit = sharpness_of(TURNS[0].0);
    let poor: Vec<u32> =
        (0..mesh.cells.len() as u32).into_par_iter().filter(|&cell| of(&mesh.cells[cell as usize]) > limit).collect();
    let mut web = Web::new(mesh, &poor);
    for (degrees, rounds) in TURNS {
        let limit = sharpness_of(degrees);
        let mut poor = web.sharper(limit);
        for _ in 0..rounds {
            poor = still_poor(&mut web, &poor, limit);
        }
    }
    web.finish();
}

/// Betters the cells in `poor`; those that are sharper than `limit` where that changed something.
fn still_poor(web: &mut Web, poor: &[u32], limit: f64) -> Vec<u32> {
    let mut touched = Vec::new();
    for &cell in poor {
        if !web.is_gone(cell) && web.sharpest(&[cell]) > limit {
            let nodes = web.cell(cell);
            if better(web, cell) {
                touched.extend(nodes);
            }
        }
    }
    touched.sort_unstable();
    touched.dedup();
    let mut poor: Vec<u32> = touched.iter().flat_map(|&node| web.star(node)).copied().collect();
    poor.sort_unstable();
    poor.dedup();
    poor.retain(|&cell| web.sharpest(&[cell]) > limit);
    poor
}

/// Takes the first way found that makes what is around a cell less sharp; whether there was one.
fn better(web: &mut Web, cell: u32) -> bool {
    if swapped(web, cell) {
        return true;
    }
    let nodes = web.cell(cell);
    let seats = nodes.map(|node| (node, Seat::of(web, node)));
    if seats.iter().any(|(node, seat)| join(web, *node, &nodes, seat)) {
        return true;
    }
    let moved = seats.iter().filter(|(node, seat)| relocate(web, *node, seat)).count();
    let [a, b, c, d] = nodes;
    let edges = [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]];
    moved > 0 || edges.into_iter().any(|[a, b]| divide(web, a, b))
}

/// Moves a node to the best place around it that its seat allows; whether there was a better one.
fn relocate(web: &mut Web, node: u32, seat: &Seat) -> bool {
    let ways = seat.ways();
    if ways.is_empty() || web.star(node).is_empty() {
        return false;
    }
    let cells = web.star(node).iter().map(|&cell| (web.cell(cell), web.grain(cell)));
    let mut star = Star::of_cells(node, cells, |node| web.point(node));
    let from = web.point(node);
    let neighbours = web.star(node).iter().flat_map(|&cell| web.cell(cell)).filter(|other| *other != node);
    let shortest = neighbours.map(|other| (web.point(other) - from).norm()).fold(f64::INFINITY, f64::min);
    let mut best = (star.sharpest_first(), None);
    for place in STEPS.iter().flat_map(|step| ways.iter().map(move |way| from + way * (step * shortest))) {
        let worst = star.worst(&place, best.0);
        if worst < best.0 {
            best = (worst, Some(place));
        }
    }
    let Some(place) = best.1 else { return false };
    let altitude = |web: &Web| web.shortest_altitude(web.star(node).iter().map(|&cell| web.cell(cell)));
    let before = altitude(web);
    web.go(node, place);
    let is_thinner = altitude(web) < before;
    if is_thinner {
        web.go(node, from);
    }
    !is_thinner
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::mesh::conforming::seat::octants;
    use crate::mesh::lattice::oriented;
    use crate::mesh::swaps::{put_through, take_out};

    /// Two apexes over and under a triangle of this radius, `height` from it.
    fn spindle(radius: f64, height: f64) -> Vec<Vec3> {
        let corner = |angle: f64| Vec3::new(radius * libm::cos(angle), radius * libm::sin(angle), 0.0);
        let third = 2.0 * std::f64::consts::FRAC_PI_3;
        let apexes = [-height, height].map(|z| Vec3::new(0.0, 0.0, z));
        [corner(0.0), corner(third), corner(2.0 * third)].into_iter().chain(apexes).collect()
    }

    fn mesh(points: Vec<Vec3>, cells: &[[u32; 4]], grain: Vec<u32>) -> Tetrahedra {
        let cells = cells.iter().map(|cell| oriented(*cell, &points)).collect();
        Tetrahedra { points, cells, grain }
    }

    fn volume(mesh: &Tetrahedra) -> f64 {
        let of = |cell: &[u32; 4]| {
            let [a, b, c, d] = cell.map(|node| mesh.points[node as usize]);
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        };
        mesh.cells.iter().map(of).sum()
    }

    const AROUND_AN_EDGE: [[u32; 4]; 3] = [[3, 4, 0, 1], [3, 4, 1, 2], [3, 4, 2, 0]];

    #[test]
    fn a_long_edge_is_taken_out_of_the_cells_around_it_within_one_grain_alone() {
        for (grain, done) in [(vec![5; 3], true), (vec![5, 5, 6], false)] {
            let mut mesh = mesh(spindle(0.2, 1.0), &AROUND_AN_EDGE, grain);
            let before = volume(&mesh);
            let mut web = Web::new(&mut mesh, &[0, 1, 2]);
            let sharpest = web.sharpest(&[0, 1, 2]);
            assert_eq!(take_out(&mut web, 3, 4), done);
            assert!(!done || web.sharpest(&[0, 1]) < sharpest);
            web.finish();
            assert_eq!((mesh.cells.len(), mesh.grain.len()), if done { (2, 2) } else { (3, 3) });
            assert!((volume(&mesh) - before).abs() < 1e-15);
        }
    }

    #[test]
    fn an_edge_is_put_through_the_face_of_two_flat_cells() {
        let mut mesh = mesh(spindle(1.0, 0.15), &[[0, 1, 2, 3], [0, 1, 2, 4]], vec![5; 2]);
        let before = volume(&mesh);
        let mut web = Web::new(&mut mesh, &[0, 1]);
        assert!(put_through(&mut web, 0, 3));
        web.finish();
        assert_eq!(mesh.grain, [5; 3]);
        assert!((volume(&mesh) - before).abs() < 1e-15 && mesh.cells.iter().all(|cell| cell.contains(&3)));
    }

    #[test]
    fn an_edge_in_a_facet_gives_way_to_the_other_diagonal_on_both_sides() {
        for (height, done) in [(0.0, true), (0.01, false)] {
            let quad = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.12, height], [0.0, -0.12, 0.0]];
            let points = quad.into_iter().chain([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]).map(Vec3::from).collect();
            let cells = [[0, 1, 2, 4], [0, 1, 4, 3], [0, 1, 3, 5], [0, 1, 5, 2]];
            let mut mesh = mesh(points, &cells, vec![5, 5, 6, 6]);
            let before = volume(&mesh);
            let mut web = Web::new(&mut mesh, &[0, 1, 2, 3]);
            assert_eq!(take_out(&mut web, 0, 1), done);
            web.finish();
            assert_eq!(mesh.cells.iter().all(|cell| cell.contains(&2) && cell.contains(&3)), done);
            let above = |(cell, grain): (&[u32; 4], &u32)| cell.contains(&4) == (*grain == 5);
            assert!(mesh.cells.len() == 4 && mesh.cells.iter().zip(&mesh.grain).all(above));
            assert!((volume(&mesh) - before).abs() < 1e-15);
        }
    }

    #[test]
    fn a_node_goes_where_angles_are_larger_as_far_as_its_materials_let_it() {
        let none: fn([bool; 3]) -> u32 = |_| 5;
        let halves: fn([bool; 3]) -> u32 = |[_, _, z]| u32::from(z);
        let quarter: fn([bool; 3]) -> u32 = |[x, y, _]| u32::from(x && y);
        for (from, grain, free) in [
            ([0.3, 0.3, 0.38], none, [true, true, true]),
            ([0.45, 0.5, 0.0], halves, [true, true, false]),
            ([0.0, 0.0, 0.9], quarter, [false, false, true]),
            ([0.3, 0.3, 0.38], quarter, [false, false, false]),
        ] {
            let from = Vec3::from(from);
            let mut mesh = octants(from, grain);
            let (whole, corners) = (volume(&mesh), mesh.points[..6].to_vec());
            let mut web = Web::new(&mut mesh, &[0, 1, 2, 3, 4, 5, 6, 7]);
            let seat = Seat::of(&web, 6);
            assert_eq!(relocate(&mut web, 6, &seat), free != [false; 3]);
            assert!(mesh.points[..6] == corners[..] && (volume(&mesh) - whole).abs() < 1e-12);
            let moved = (0..3).map(|axis| mesh.points[6][axis] != from[axis]);
            assert!(moved.zip(free).all(|(moved, free)| free || !moved), "{:?}", mesh.points[6]);
        }
    }
}
