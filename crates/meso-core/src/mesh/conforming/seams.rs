//! Meshes of slabs become one: where gmsh put a node of its own on a plane between two, or took the other diagonal there,
//! the cells on the other side are divided alike.
//!
//! Both sides had the same triangles. Nodes that one side alone has divide the edges or triangles that they lie in on the
//! other side; edges that cross get a node where they do; so both sides come to the same triangles again. Cells with all
//! corners on the plane, which gmsh leaves where it recovers an edge, have no volume and go first.

use super::faces::Nodes;
use super::flat::{crossing, do_cross, turn};
use super::msh::Volumes;
use super::slabs::Slabs;
use crate::math::Vec3;
use crate::mesh::MeshError;
use std::collections::BTreeSet;

/// Nodes this near to a plane are on it, mm: those that gmsh adds there are rounded.
const ON_PLANE_MM: f64 = 1e-9;
/// A node this near to an edge, in heights of the triangle, lies on it.
const ON_EDGE: f64 = 1e-6;
/// Most times that a plane is given nodes.
const MOST: usize = 10_000;

/// The meshes of `slabs`, in their order, as one.
///
/// # Errors
/// Where the sides of a plane do not come to the same triangles.
pub(super) fn joined(parts: Vec<Volumes>, slabs: &Slabs) -> Result<Volumes, MeshError> {
    let mut mesh = sewn(parts, slabs);
    for &place in &slabs.places {
        Seam::new(&mut mesh, slabs.axis, place).close()?;
    }
    Ok(mesh)
}

/// All parts in one mesh, nodes at the same place on a plane one node.
fn sewn(mut parts: Vec<Volumes>, slabs: &Slabs) -> Volumes {
    if slabs.places.is_empty() {
        return parts.pop().unwrap_or_default();
    }
    let mut mesh = Volumes::default();
    let mut on_planes = Nodes::default();
    // The mesh's number of every node on a plane.
    let mut shared = Vec::new();
    for part in parts {
        let mut number = Vec::with_capacity(part.points.len());
        for mut point in part.points {
            let plane = slabs.places.iter().find(|place| (point[slabs.axis] - **place).abs() <= ON_PLANE_MM);
            if let Some(&place) = plane {
                point[slabs.axis] = place;
                let at = on_planes.at(point) as usize;
                if at < shared.len() {
                    number.push(shared[at]);
                    continue;
                }
                shared.push(mesh.points.len() as u32);
            }
            number.push(mesh.points.len() as u32);
            mesh.points.push(point);
        }
        mesh.cells.extend(part.cells.into_iter().map(|cell| cell.map(|node| number[node as usize])));
        mesh.volume.extend(part.volume);
    }
    mesh
}

/// A plane between two slabs.
struct Seam<'a> {
    mesh: &'a mut Volumes,
    axis: usize,
    place: f64,
    /// The cells with two corners or more on the plane, below and above it.
    sides: [Vec<u32>; 2],
}

/// A triangle on the plane, its nodes ascending.
type Corners = [u32; 3];

impl<'a> Seam<'a> {
    fn new(mesh: &'a mut Volumes, axis: usize, place: f64) -> Self {
        let mut sides = [Vec::new(), Vec::new()];
        let mut flat = Vec::new();
        for (number, cell) in (0..).zip(&mesh.cells) {
            let off = cell.map(|node| mesh.points[node as usize][axis] - place);
            match off.iter().filter(|off| **off == 0.0).count() {
                4 => flat.push(number as usize),
                2 | 3 => sides[usize::from(off.iter().any(|off| *off > 0.0))].push(number),
                _ => {}
            }
        }
        let mut seam = Self { mesh, axis, place, sides };
        seam.leave_out(&flat);
        seam
    }

    /// Takes `flat` cells, ascending, out of the mesh.
    fn leave_out(&mut self, flat: &[usize]) {
        for &cell in flat.iter().rev() {
            // The last one takes its number.
            let last = self.mesh.cells.len() as u32 - 1;
            self.mesh.cells.swap_remove(cell);
            self.mesh.volume.swap_remove(cell);
            let renamed = self.sides.iter_mut().flatten().filter(|number| **number == last);
            renamed.for_each(|number| *number = cell as u32);
        }
    }

    /// Divides cells until both sides have the same triangles.
    fn close(mut self) -> Result<(), MeshError> {
        for _ in 0..MOST {
            let [below, above] = [0, 1].map(|side| self.triangles(side));
            let lone = [without(&below, &above), without(&above, &below)];
            if lone.iter().all(Vec::is_empty) {
                return Ok(());
            }
            if !self.put_nodes([&below, &above], &lone) && !self.cross(&lone) {
                break;
            }
        }
        Err(self.open())
    }

    /// Where the sides still differ.
    fn open(&self) -> MeshError {
        let [below, above] = [0, 1].map(|side| self.triangles(side));
        let lone = [without(&below, &above), without(&above, &below)].concat();
        let at = lone.first().map_or(Vec3::zeros(), |corners| self.mesh.points[corners[0] as usize]);
        MeshError::Seam { at: at.into() }
    }

    fn on(&self, node: u32) -> bool {
        self.mesh.points[node as usize][self.axis] == self.place
    }

    /// The triangles that a side has on the plane, ascending.
    fn triangles(&self, side: usize) -> Vec<Corners> {
        let mut triangles: Vec<Corners> = self.sides[side].iter().filter_map(|&cell| self.triangle(cell)).collect();
        triangles.sort_unstable();
        triangles
    }

    fn triangle(&self, cell: u32) -> Option<Corners> {
        let nodes = self.mesh.cells[cell as usize];
        let off = nodes.iter().position(|node| !self.on(*node))?;
        let mut corners = [1, 2, 3].map(|i| nodes[(off + i) % 4]);
        corners.sort_unstable();
        corners.iter().all(|node| self.on(*node)).then_some(corners)
    }

    /// Gives nodes that one side alone has to the other one, but no two to neighbours; false where there is none, or no place
    /// for it.
    fn put_nodes(&mut self, triangles: [&[Corners]; 2], lone: &[Vec<Corners>; 2]) -> bool {
        let all = triangles.map(nodes);
        let mut busy = BTreeSet::new();
        for (own, other) in [(0, 1), (1, 0)] {
            for node in nodes(&lone[own]).into_iter().filter(|node| all[other].binary_search(node).is_err()) {
                let place = self.mesh.points[node as usize];
                let around = lone[other].iter().map(|&corners| (self.heights(corners, &place), corners));
                let least = |heights: &[f64; 3]| heights.iter().fold(f64::INFINITY, |a: f64, b| a.min(*b));
                let Some((heights, corners)) = around.max_by(|a, b| least(&a.0).total_cmp(&least(&b.0))) else {
                    continue;
                };
                if least(&heights) < -ON_EDGE || corners.iter().any(|corner| busy.contains(corner)) {
                    continue;
                }
                match [0, 1, 2].into_iter().find(|&i| heights[i] < ON_EDGE) {
                    Some(i) => self.divide_edge(other, [corners[(i + 1) % 3], corners[(i + 2) % 3]], node),
                    None => self.divide_triangle(other, corners, node),
                }
                busy.extend(corners);
            }
        }
        !busy.is_empty()
    }

    /// Puts nodes where edges of the two sides cross, but no two at one edge; false where none do.
    fn cross(&mut self, lone: &[Vec<Corners>; 2]) -> bool {
        let [below, above] = [0, 1].map(|side| edges(&lone[side]));
        let mut busy = BTreeSet::new();
        for &[a, b] in below.iter().filter(|edge| above.binary_search(edge).is_err()) {
            for &[c, d] in above.iter().filter(|edge| below.binary_search(edge).is_err()) {
                if ![a, b, c, d].iter().any(|end| busy.contains(end)) && self.do_cross([a, b], [c, d]) {
                    let middle = self.crossing([a, b, c, d]);
                    let node = self.mesh.points.len() as u32;
                    self.mesh.points.push(middle);
                    self.divide_edge(0, [a, b], node);
                    self.divide_edge(1, [c, d], node);
                    busy.extend([a, b, c, d]);
                }
            }
        }
        !busy.is_empty()
    }

    fn turn(&self, a: &Vec3, b: &Vec3, c: &Vec3) -> f64 {
        turn(self.axis, a, b, c)
    }

    /// The height of `place` over every side of a triangle, in heights of the corner opposite to it.
    fn heights(&self, corners: Corners, place: &Vec3) -> [f64; 3] {
        let [a, b, c] = corners.map(|node| self.mesh.points[node as usize]);
        let whole = self.turn(&a, &b, &c);
        [self.turn(place, &b, &c), self.turn(&a, place, &c), self.turn(&a, &b, place)].map(|part| part / whole)
    }

    fn do_cross(&self, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> bool {
        do_cross(&[a, b, c, d].map(|node| self.mesh.points[node as usize]), self.axis)
    }

    fn crossing(&self, quad: [u32; 4]) -> Vec3 {
        let mut place = crossing(quad.map(|node| self.mesh.points[node as usize]), self.axis);
        place[self.axis] = self.place;
        place
    }

    /// Divides every cell of a side that has the edge at `node`.
    fn divide_edge(&mut self, side: usize, edge: [u32; 2], node: u32) {
        let has_edge = |cell: &u32| edge.iter().all(|end| self.mesh.cells[*cell as usize].contains(end));
        let around: Vec<u32> = self.sides[side].iter().copied().filter(has_edge).collect();
        around.into_iter().for_each(|cell| self.divide(side, cell, &edge, node));
    }

    /// Divides the cell of a side that has the triangle at `node`.
    fn divide_triangle(&mut self, side: usize, corners: Corners, node: u32) {
        let cell = self.sides[side].iter().copied().find(|&cell| self.triangle(cell) == Some(corners));
        cell.into_iter().for_each(|cell| self.divide(side, cell, &corners, node));
    }

    /// Puts `node` in the place of each of `corners` in turn.
    fn divide(&mut self, side: usize, cell: u32, corners: &[u32], node: u32) {
        let (whole, volume) = (self.mesh.cells[cell as usize], self.mesh.volume[cell as usize]);
        for (part, corner) in corners.iter().enumerate() {
            let nodes = whole.map(|of| if of == *corner { node } else { of });
            if part == 0 {
                self.mesh.cells[cell as usize] = nodes;
            } else {
                self.sides[side].push(self.mesh.cells.len() as u32);
                self.mesh.cells.push(nodes);
                self.mesh.volume.push(volume);
            }
        }
    }
}

/// What is in the first of two ascending lists alone.
fn without(list: &[Corners], other: &[Corners]) -> Vec<Corners> {
    list.iter().filter(|entry| other.binary_search(entry).is_err()).copied().collect()
}

/// The nodes of triangles, ascending.
fn nodes(triangles: &[Corners]) -> Vec<u32> {
    let mut nodes = triangles.as_flattened().to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The edges of triangles, ascending.
fn edges(triangles: &[Corners]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c], [b, c]]).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part of one side of z = 1: a square or its halves and what is given beside it, with an apex.
    fn part(points: &[[f64; 2]], triangles: &[[u32; 3]], apex: f64) -> Volumes {
        let on = points.iter().map(|[x, y]| Vec3::new(*x, *y, 1.0));
        let points: Vec<Vec3> = on.chain([Vec3::new(0.4, 0.45, apex)]).collect();
        let top = points.len() as u32 - 1;
        let cells: Vec<[u32; 4]> = triangles.iter().map(|&[a, b, c]| [a, b, c, top]).collect();
        Volumes { volume: vec![7; cells.len()], points, cells }
    }

    fn volume(mesh: &Volumes) -> f64 {
        let of = |cell: &[u32; 4]| {
            let [a, b, c, d] = cell.map(|node| mesh.points[node as usize]);
            (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
        };
        mesh.cells.iter().map(of).sum()
    }

    /// The parts joined; every triangle of one side is one of the other's, and no volume is lost.
    fn close(below: Volumes, above: Volumes) -> Volumes {
        let whole = volume(&below) + volume(&above);
        let slabs = Slabs { axis: 2, places: vec![1.0] };
        let mut mesh = joined(vec![below, above], &slabs).unwrap();
        assert!((volume(&mesh) - whole).abs() < 1e-12);
        assert!(mesh.cells.len() == mesh.volume.len() && mesh.volume.iter().all(|volume| *volume == 7));
        let seam = Seam::new(&mut mesh, 2, 1.0);
        assert_eq!(seam.triangles(0), seam.triangles(1));
        assert_eq!(seam.mesh.cells.len(), seam.sides[0].len() + seam.sides[1].len(), "no cell is flat");
        mesh
    }

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    #[test]
    fn a_node_inside_a_triangle_or_on_an_edge_of_one_side_divides_the_other() {
        let with = |node: [f64; 2]| [&SQUARE[..], &[node]].concat();
        let above = || part(&SQUARE, &[[0, 1, 2], [0, 2, 3]], 2.0);
        let inside = part(&with([0.7, 0.2]), &[[0, 1, 4], [1, 2, 4], [0, 4, 2], [0, 2, 3]], 0.0);
        assert_eq!(close(inside, above()).cells.len(), 8);
        let on_edge = part(&with([0.3, 0.3]), &[[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]], 0.0);
        assert_eq!(close(on_edge, above()).cells.len(), 8);
    }

    #[test]
    fn where_the_sides_have_different_diagonals_both_get_a_node() {
        let below = part(&SQUARE, &[[0, 1, 2], [0, 2, 3]], 0.0);
        let mesh = close(below, part(&SQUARE, &[[0, 1, 3], [1, 2, 3]], 2.0));
        assert_eq!(mesh.cells.len(), 8);
        assert_eq!(mesh.points.last(), Some(&Vec3::new(0.5, 0.5, 1.0)));
    }

    #[test]
    fn a_flat_cell_goes_and_its_edges_get_a_node() {
        let mut below = part(&SQUARE, &[[0, 1, 2], [0, 2, 3]], 0.0);
        below.cells.insert(0, [0, 1, 2, 3]);
        below.volume.push(7);
        assert_eq!(close(below, part(&SQUARE, &[[0, 1, 3], [1, 2, 3]], 2.0)).cells.len(), 8);
    }

    #[test]
    fn sides_that_cover_different_places_are_told() {
        let slabs = Slabs { axis: 2, places: vec![1.0] };
        let parts = vec![part(&SQUARE, &[[0, 1, 2]], 0.0), part(&SQUARE, &[[0, 2, 3]], 2.0)];
        assert!(matches!(joined(parts, &slabs), Err(MeshError::Seam { .. })));
    }
}
