//! The meshes of slabs become one. gmsh may have inserted a node on a plane between two slabs, or swapped a diagonal there;
//! then the cells on the other side are split alike.
//!
//! 1. Both sides started from the same triangles. Nodes of one side alone split the edges or triangles of the other side that
//!    they lie in, and crossing edges get a node at the crossing. Then both sides have the same triangles again.
//! 2. Cells with all corners on the plane, which gmsh leaves where it recovers an edge, have no volume and are removed first.
//! 3. The plane faces of a periodic box have such flat cells, too. A flat cell has both diagonals of a quadrilateral on the
//!    face: one is an edge of the surface, the other was Delaunay's. A node at their crossing splits every cell around both
//!    and removes the flat one; the opposite face gets the same node.

use super::slabs::Slabs;
use crate::error::MeshError;
use crate::tet::{Incidence, TetMesh, ascending};
use crate::triangulation::{Nodes, key};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::specimen::Period;
use std::collections::{BTreeMap, BTreeSet};

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
pub(super) fn joined(parts: Vec<TetMesh>, slabs: &Slabs) -> Result<TetMesh, MeshError> {
    let mut mesh = sewn(parts, slabs);
    for &position in &slabs.positions {
        Seam::new(&mut mesh, slabs.axis, position).close()?;
    }
    Ok(mesh)
}

/// All parts in one mesh, nodes at the same position on a plane one node.
fn sewn(mut parts: Vec<TetMesh>, slabs: &Slabs) -> TetMesh {
    if slabs.positions.is_empty() {
        return parts.pop().unwrap_or_default();
    }
    let mut mesh = TetMesh::default();
    let mut on_planes = Nodes::default();
    // The mesh's number of every node on a plane.
    let mut shared = Vec::new();
    for part in parts {
        let mut number = Vec::with_capacity(part.points.len());
        for mut point in part.points {
            let plane = slabs.positions.iter().find(|position| (point[slabs.axis] - **position).abs() <= ON_PLANE_MM);
            if let Some(&position) = plane {
                point[slabs.axis] = position;
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
        mesh.owner.extend(part.owner);
    }
    mesh
}

/// A plane between two slabs.
struct Seam<'a> {
    mesh: &'a mut TetMesh,
    axis: usize,
    position: f64,
    /// The cells with two corners or more on the plane, below and above it.
    sides: [Vec<u32>; 2],
}

/// A triangle on the plane, its nodes ascending.
type Corners = [u32; 3];

impl<'a> Seam<'a> {
    fn new(mesh: &'a mut TetMesh, axis: usize, position: f64) -> Self {
        let mut sides = [Vec::new(), Vec::new()];
        let mut flat = Vec::new();
        for (number, cell) in (0..).zip(&mesh.cells) {
            let off = cell.map(|node| mesh.points[node as usize][axis] - position);
            match off.iter().filter(|off| **off == 0.0).count() {
                4 => flat.push(number as usize),
                2 | 3 => sides[usize::from(off.iter().any(|off| *off > 0.0))].push(number),
                _ => {}
            }
        }
        let mut seam = Self { mesh, axis, position, sides };
        seam.leave_out(&flat);
        seam
    }

    /// Takes `flat` cells, ascending, out of the mesh.
    fn leave_out(&mut self, flat: &[usize]) {
        for &cell in flat.iter().rev() {
            // The last one takes its number.
            let last = self.mesh.cells.len() as u32 - 1;
            self.mesh.cells.swap_remove(cell);
            self.mesh.owner.swap_remove(cell);
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
        self.mesh.points[node as usize][self.axis] == self.position
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
                let position = self.mesh.points[node as usize];
                let around = lone[other].iter().map(|&corners| (self.heights(corners, &position), corners));
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

    fn signed_area(&self, a: &Vec3, b: &Vec3, c: &Vec3) -> f64 {
        signed_area(self.axis, a, b, c)
    }

    /// The height of `position` over every side of a triangle, in heights of the corner opposite to it.
    fn heights(&self, corners: Corners, position: &Vec3) -> [f64; 3] {
        let [a, b, c] = corners.map(|node| self.mesh.points[node as usize]);
        let whole = self.signed_area(&a, &b, &c);
        [self.signed_area(position, &b, &c), self.signed_area(&a, position, &c), self.signed_area(&a, &b, position)]
            .map(|part| part / whole)
    }

    fn do_cross(&self, [a, b]: [u32; 2], [c, d]: [u32; 2]) -> bool {
        do_cross(&[a, b, c, d].map(|node| self.mesh.points[node as usize]), self.axis)
    }

    fn crossing(&self, quad: [u32; 4]) -> Vec3 {
        let mut position = crossing(quad.map(|node| self.mesh.points[node as usize]), self.axis);
        position[self.axis] = self.position;
        position
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
        let (whole, owner) = self.mesh.owned(cell);
        for (part, corner) in corners.iter().enumerate() {
            let nodes = whole.map(|of| if of == *corner { node } else { of });
            if part == 0 {
                self.mesh.cells[cell as usize] = nodes;
            } else {
                let part = self.mesh.push(nodes, owner);
                self.sides[side].push(part);
            }
        }
    }
}

/// The entries of the first of two ascending lists that the second lacks.
fn without(list: &[Corners], other: &[Corners]) -> Vec<Corners> {
    list.iter().filter(|entry| other.binary_search(entry).is_err()).copied().collect()
}

/// The nodes of triangles, ascending.
fn nodes(triangles: &[Corners]) -> Vec<u32> {
    ascending(triangles.as_flattened().iter().copied())
}

/// The edges of triangles, ascending.
fn edges(triangles: &[Corners]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c], [b, c]]).collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// Most tetrahedra that are opened on a pair of faces: before the faces' nodes were smoothed one of 35 meshes of 40,000
/// cells had some.
const MOST_SLIVERS: usize = 10_000;

/// Opens the flat tetrahedra of `mesh` on the faces of `domain` across which the box repeats itself.
pub(super) fn open_slivers(mesh: &mut TetMesh, period: &Period, domain: &Aabb) {
    for axis in (0..3).filter(|&axis| period.along(axis).is_some()) {
        let faces = Faces { axis, positions: [domain.min[axis], domain.max[axis]] };
        let flat: Vec<u32> = (0..mesh.cells.len() as u32).rev().filter(|&cell| faces.have(mesh, cell)).collect();
        if !flat.is_empty() {
            OpenedMesh::new(mesh, faces).open(flat);
        }
    }
}

/// Two opposite faces.
struct Faces {
    axis: usize,
    positions: [f64; 2],
}

impl Faces {
    /// True when a cell lies in one of them with all its corners.
    fn have(&self, mesh: &TetMesh, cell: u32) -> bool {
        let [first, rest @ ..] = mesh.cells[cell as usize].map(|node| mesh.points[node as usize][self.axis]);
        self.positions.contains(&first) && rest.iter().all(|position| *position == first)
    }

    /// The corners of a flat tetrahedron, those of its edges that cross first and last.
    fn quad(&self, [a, b, c, d]: [Vec3; 4]) -> Option<[Vec3; 4]> {
        [[a, b, c, d], [a, c, b, d], [a, d, b, c]].into_iter().find(|quad| do_cross(quad, self.axis))
    }
}

/// The mesh, with an index of its nodes and cells at a pair of faces.
struct OpenedMesh<'a> {
    mesh: &'a mut TetMesh,
    faces: Faces,
    /// The nodes on the faces by their positions.
    nodes: BTreeMap<[u64; 3], u32>,
    /// The cells of each of these, and some that are removed.
    around: Incidence,
}

impl<'a> OpenedMesh<'a> {
    fn new(mesh: &'a mut TetMesh, faces: Faces) -> Self {
        let on = |node: &u32| faces.positions.contains(&mesh.points[*node as usize][faces.axis]);
        let nodes = (0..mesh.points.len() as u32).filter(on).map(|node| (key(&mesh.points[node as usize]), node));
        let nodes: BTreeMap<[u64; 3], u32> = nodes.collect();
        let around = Incidence::around(&mesh.cells, mesh.points.len(), nodes.values().copied());
        Self { mesh, faces, nodes, around }
    }

    /// Opens the cells in `flat`, the last first, and the cells that become flat by that.
    fn open(mut self, mut flat: Vec<u32>) {
        let mut left = MOST_SLIVERS;
        while let Some(cell) = flat.pop().filter(|_| left > 0) {
            if self.mesh.is_removed(cell) {
                continue;
            }
            let Some(quad) = self.faces.quad(self.mesh.corners(self.mesh.cell(cell))) else { continue };
            let middle = crossing(quad, self.faces.axis);
            for position in self.faces.positions {
                let moved = |point: Vec3| Vec3::from_fn(|i, _| if i == self.faces.axis { position } else { point[i] });
                let first = self.mesh.cells.len() as u32;
                self.divide(quad.map(moved), moved(middle));
                flat.extend((first..self.mesh.cells.len() as u32).filter(|&new| self.faces.have(self.mesh, new)));
            }
            left -= 1;
        }
        self.mesh.drop_removed();
    }

    /// Divides the cells that have the edge ab or cd at a new node in the `middle` of both; those that have both go.
    fn divide(&mut self, quad: [Vec3; 4], middle: Vec3) {
        let [Some(a), Some(b), Some(c), Some(d)] = quad.map(|position| self.nodes.get(&key(&position)).copied()) else {
            return;
        };
        let new = self.mesh.points.len() as u32;
        self.mesh.points.push(middle);
        self.nodes.insert(key(&middle), new);
        self.around.add_node();
        let around = ascending([self.around.cells(a), self.around.cells(c)].concat());
        for number in around.into_iter().filter(|number| !self.mesh.is_removed(*number)).collect::<Vec<_>>() {
            let (cell, owner) = self.mesh.owned(number);
            let has = |p: u32, q: u32| cell.contains(&p) && cell.contains(&q);
            let half = |end: u32| cell.map(|node| if node == end { new } else { node });
            let parts = match (has(a, b), has(c, d)) {
                (false, false) => continue,
                (true, false) => vec![half(a), half(b)],
                (false, true) => vec![half(c), half(d)],
                (true, true) => vec![],
            };
            self.mesh.remove(number);
            for part in parts {
                let number = self.mesh.push(part, owner);
                self.around.link(number, &part);
            }
        }
    }
}

/// Twice the area of the triangle from a over b to c, seen along `axis`.
fn signed_area(axis: usize, a: &Vec3, b: &Vec3, c: &Vec3) -> f64 {
    (b - a).cross(&(c - a))[axis]
}

/// Whether ab and cd cross, seen along `axis`.
fn do_cross([a, b, c, d]: &[Vec3; 4], axis: usize) -> bool {
    signed_area(axis, a, b, c) * signed_area(axis, a, b, d) < 0.0
        && signed_area(axis, c, d, a) * signed_area(axis, c, d, b) < 0.0
}

/// Where ab and cd cross, seen along `axis`; across it the position is on ab.
fn crossing([a, b, c, d]: [Vec3; 4], axis: usize) -> Vec3 {
    let cross = |p: Vec3, q: Vec3| p.cross(&q)[axis];
    a + (b - a) * (cross(c - a, d - c) / cross(b - a, d - c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_concrete::specimen::Periodic;

    /// A part of one side of z = 1: a square or its halves and the given cells beside it, with an apex.
    fn part(points: &[[f64; 2]], triangles: &[[u32; 3]], apex: f64) -> TetMesh {
        let on = points.iter().map(|[x, y]| Vec3::new(*x, *y, 1.0));
        let points: Vec<Vec3> = on.chain([Vec3::new(0.4, 0.45, apex)]).collect();
        let top = points.len() as u32 - 1;
        let cells: Vec<[u32; 4]> = triangles.iter().map(|&[a, b, c]| [a, b, c, top]).collect();
        TetMesh { owner: vec![7; cells.len()], points, cells }
    }

    fn volume(mesh: &TetMesh) -> f64 {
        let of = |cell: &[u32; 4]| {
            let [a, b, c, d] = cell.map(|node| mesh.points[node as usize]);
            (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
        };
        mesh.cells.iter().map(of).sum()
    }

    /// The parts joined; every triangle of one side is one of the other's, and no volume is lost.
    fn close(below: TetMesh, above: TetMesh) -> TetMesh {
        let whole = volume(&below) + volume(&above);
        let slabs = Slabs { axis: 2, positions: vec![1.0] };
        let mut mesh = joined(vec![below, above], &slabs).unwrap();
        assert!((volume(&mesh) - whole).abs() < 1e-12);
        assert!(mesh.cells.len() == mesh.owner.len() && mesh.owner.iter().all(|owner| *owner == 7));
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
        below.owner.push(7);
        assert_eq!(close(below, part(&SQUARE, &[[0, 1, 3], [1, 2, 3]], 2.0)).cells.len(), 8);
    }

    #[test]
    fn sides_that_cover_different_places_are_told() {
        let slabs = Slabs { axis: 2, positions: vec![1.0] };
        let parts = vec![part(&SQUARE, &[[0, 1, 2]], 0.0), part(&SQUARE, &[[0, 2, 3]], 2.0)];
        assert!(matches!(joined(parts, &slabs), Err(MeshError::Seam { .. })));
    }

    #[test]
    fn a_flat_tetrahedron_on_a_face_is_opened_there_and_opposite_to_it() {
        let square = |z: f64| [[1.0, 0.0, z], [0.0, 1.0, z], [0.2, 0.1, z], [1.0, 1.0, z]].map(Vec3::from);
        let apexes = [Vec3::new(0.5, 0.5, 1.0), Vec3::new(0.5, 0.5, 3.0)];
        // The lower face has the edge 0-1, under which gmsh took 2-3; the upper one has 0-1 alone.
        let cells = vec![[2, 3, 0, 8], [2, 3, 1, 8], [0, 1, 2, 3], [4, 5, 6, 9], [4, 5, 7, 9]];
        let points = [&square(0.0)[..], &square(4.0), &apexes].concat();
        let mut mesh = TetMesh { points, cells, owner: vec![1, 1, 1, 2, 2] };
        let size = Vec3::repeat(4.0);
        let domain = Aabb { min: Vec3::zeros(), max: size };
        let volume = |mesh: &TetMesh| -> [f64; 2] {
            [1, 2].map(|tag| {
                let own = mesh.cells.iter().zip(&mesh.owner).filter(|(_, volume)| **volume == tag);
                own.map(|(cell, _)| {
                    let [a, b, c, d] = cell.map(|node| mesh.points[node as usize]);
                    (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0
                })
                .sum()
            })
        };
        let before = volume(&mesh);
        open_slivers(&mut mesh, &Period::new(&size, Periodic([false, false, true])), &domain);
        assert_eq!((mesh.cells.len(), mesh.points.len()), (8, 12));
        assert!(volume(&mesh).iter().zip(before).all(|(after, before)| (after - before).abs() < 1e-15));
        let [low, high] = [mesh.points[10], mesh.points[11]];
        assert!(low.z == 0.0 && high.z == 4.0 && low.xy() == high.xy());
        assert!((low.x + low.y - 1.0).abs() < 1e-15, "on the edge 0-1: {low}");
        let flat = |cell: &[u32; 4]| cell.iter().all(|&node| mesh.points[node as usize].z == 0.0);
        assert!(!mesh.cells.iter().any(flat));
    }
}
