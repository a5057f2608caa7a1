//! Sharp cells of gmsh's mesh are mended where no surface is touched: by other cells in the same room ([`swaps`](super::swaps)),
//! and by better places for nodes that lie inside one material.
//!
//! Every step leaves the sharpest angle there less sharp than it was, no altitude shorter and every volume positive. What lies between close
//! facets has all its nodes on these, and stays.

use super::swaps::{put_through, take_out};
use super::web::Web;
use crate::mesh::lattice::{Star, Tetrahedra, sharpness, sharpness_of, ways};
use rayon::prelude::*;

/// Cells with a smaller angle are mended, degrees: somewhat more than what counts as bad.
const POOR_DEG: f64 = 10.0;
/// Times that what is still poor is looked at.
const ROUNDS: usize = 4;
/// Steps tried, in lengths of the node's shortest edge.
const STEPS: [f64; 3] = [0.3, 0.1, 0.03];

/// Mends the poor cells of `mesh`.
pub(super) fn mend(mesh: &mut Tetrahedra) {
    let limit = sharpness_of(POOR_DEG);
    let of = |cell: &[u32; 4]| sharpness(cell.map(|node| mesh.points[node as usize]));
    let mut poor: Vec<u32> =
        (0..mesh.cells.len() as u32).into_par_iter().filter(|&cell| of(&mesh.cells[cell as usize]) > limit).collect();
    let mut web = Web::new(mesh, &poor);
    for _ in 0..ROUNDS {
        let before = poor.len();
        let mut touched = Vec::new();
        for &cell in &poor {
            if !web.is_gone(cell) && web.sharpest(&[cell]) > limit {
                touched.extend(web.cell(cell));
                better(&mut web, cell);
            }
        }
        touched.sort_unstable();
        touched.dedup();
        poor = touched.iter().flat_map(|&node| web.star(node)).copied().collect();
        poor.sort_unstable();
        poor.dedup();
        poor.retain(|&cell| web.sharpest(&[cell]) > limit);
        if poor.len() == before {
            break;
        }
    }
    web.finish();
}

/// Takes the first way found that makes what is around a cell less sharp.
fn better(web: &mut Web, cell: u32) {
    let [a, b, c, d] = web.cell(cell);
    let edges = [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]];
    if edges.into_iter().any(|[a, b]| take_out(web, a, b)) {
        return;
    }
    if [a, b, c, d].into_iter().any(|apex| put_through(web, cell, apex)) {
        return;
    }
    [a, b, c, d].into_iter().for_each(|node| relocate(web, node));
}

/// Moves a node inside one material to the best place around it.
fn relocate(web: &mut Web, node: u32) {
    if !is_free(web, node) {
        return;
    }
    let cells = web.star(node).iter().map(|&cell| (web.cell(cell), web.grain(cell)));
    let mut star = Star::of_cells(node, cells, |node| web.point(node));
    let from = web.point(node);
    let neighbours = web.star(node).iter().flat_map(|&cell| web.cell(cell)).filter(|other| *other != node);
    let shortest = neighbours.map(|other| (web.point(other) - from).norm()).fold(f64::INFINITY, f64::min);
    let mut best = (star.sharpest_first(), None);
    for place in STEPS.iter().flat_map(|step| ways().map(move |way| from + way * (step * shortest))) {
        let worst = star.worst(&place, best.0);
        if worst < best.0 {
            best = (worst, Some(place));
        }
    }
    let Some(place) = best.1 else { return };
    let altitude = |web: &Web| web.shortest_altitude(web.star(node).iter().map(|&cell| web.cell(cell)));
    let before = altitude(web);
    web.go(node, place);
    if altitude(web) < before {
        web.go(node, from);
    }
}

/// True where one material is all around a node, and its cells are known.
fn is_free(web: &Web, node: u32) -> bool {
    let star = web.star(node);
    if star.is_empty() {
        return false;
    }
    let mut edges = Vec::with_capacity(3 * star.len());
    for &cell in star {
        if web.grain(cell) != web.grain(star[0]) {
            return false;
        }
        let mut face: Vec<u32> = web.cell(cell).into_iter().filter(|other| *other != node).collect();
        face.sort_unstable();
        edges.extend([[face[0], face[1]], [face[0], face[2]], [face[1], face[2]]]);
    }
    edges.sort_unstable();
    edges.chunk_by(|a, b| a == b).all(|same| same.len() == 2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::mesh::conforming::swaps::{put_through, take_out};
    use crate::mesh::lattice::oriented;

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
    fn a_node_inside_one_material_goes_where_angles_are_larger_and_others_stay() {
        for (grain, moves) in [(vec![5; 8], true), (vec![5, 5, 5, 5, 6, 6, 6, 6], false)] {
            let ends = (0..3).flat_map(|i| [Vec3::ith(i, 1.0), Vec3::ith(i, -1.0)]);
            let points: Vec<Vec3> = ends.chain([Vec3::new(0.3, 0.3, 0.38)]).collect();
            let of = |octant: u32| [octant >> 2 & 1, 2 + (octant >> 1 & 1), 4 + (octant & 1), 6];
            let mut mesh = mesh(points.clone(), &(0..8).map(of).collect::<Vec<_>>(), grain);
            let whole = volume(&mesh);
            mend(&mut mesh);
            assert_eq!(mesh.points[6] != points[6], moves);
            assert_eq!(mesh.points[..6], points[..6]);
            assert!((volume(&mesh) - whole).abs() < 1e-12);
        }
    }
}
