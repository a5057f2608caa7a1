//! The sides of a mesh towards its bounding planes: their nodes, and the cells' faces on them.
//!
//! A side holds the faces on its bounding plane. Where no face does (a cylinder's mantle), it is the part of the mesh's
//! surface that looks along that axis more than along the others, and at less than 45 degrees to it.

use super::interface::{NO_NODE, by_nodes};
use super::mesh::{Cells, Mesh};
use crate::disjoint::{find, join};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::specimen::Specimen;
use rayon::prelude::*;

/// The bounding planes: axis, whether it is the upper one, and the name of its node set.
pub const SIDES: [(usize, bool, &str); 6] = [
    (0, false, "XMIN"),
    (0, true, "XMAX"),
    (1, false, "YMIN"),
    (1, true, "YMAX"),
    (2, false, "ZMIN"),
    (2, true, "ZMAX"),
];

/// A face looks along an axis where its unit normal's component is above the root of this: 45 degrees are 0.5, and the
/// flat triangles of a mantle lean a little.
const LOOKS: f64 = 0.45;

/// The nodes and faces of all sides.
#[derive(Clone, Debug)]
pub struct Sides {
    /// For every node a bit per side, in the order of [`SIDES`].
    nodes: Vec<u8>,
    faces: [Vec<(u32, usize)>; 6],
}

impl Sides {
    /// The sides of `mesh`.
    pub fn of(mesh: &Mesh) -> Self {
        let cells = mesh.by_owner();
        let mut sides = Self::in_planes(cells);
        if sides.faces.iter().any(Vec::is_empty) {
            sides.add_curved(cells, &mesh.cohesive);
        }
        sides
    }

    /// The sides of a mesh whose cells fill a box.
    pub(crate) fn in_planes(cells: Cells) -> Self {
        let sides = Self::of_points(cells.points);
        Self { faces: in_planes(cells, &sides.nodes), ..sides }
    }

    /// The bounding planes of `points` and which of these lie on them, without any faces.
    pub(crate) fn of_points(points: &[Vec3]) -> Self {
        Self { nodes: on_planes(points), faces: Default::default() }
    }

    /// The sides that `node` lies on.
    pub fn on(&self, node: u32) -> u8 {
        self.nodes[node as usize]
    }

    /// The nodes on side `bit` of [`SIDES`], ascending.
    pub fn members(&self, bit: usize) -> impl Iterator<Item = u32> {
        (0..).zip(&self.nodes).filter(move |(_, on)| **on >> bit & 1 == 1).map(|(node, _)| node)
    }

    /// The faces (cell, number of the face in [`CellKind::faces`](super::CellKind::faces)) on every side, by cell.
    pub fn faces(&self) -> &[Vec<(u32, usize)>; 6] {
        &self.faces
    }

    /// Gives the sides without a face in their plane those that look their way.
    fn add_curved(&mut self, mesh: Cells, cohesive: &[u32]) {
        let curved = [0, 1, 2, 3, 4, 5].map(|bit: usize| self.faces[bit].is_empty());
        for (cell, face) in outer_faces(mesh, cohesive) {
            let start = cell as usize * mesh.kind.nodes();
            let p = |i: usize| mesh.points[mesh.nodes[start + mesh.kind.faces()[face][i]] as usize];
            let normal = (p(1) - p(0)).cross(&(p(2) - p(0)));
            let axis = normal.iamax();
            let bit = 2 * axis + usize::from(normal[axis] > 0.0);
            if curved[bit] && normal[axis] * normal[axis] > LOOKS * normal.norm_squared() {
                self.faces[bit].push((cell, face));
                for &i in mesh.kind.face_nodes()[face] {
                    self.nodes[mesh.nodes[start + i] as usize] |= 1 << bit;
                }
            }
        }
    }
}

/// A bit per side, in the order of [`SIDES`], from the answers for the lower and the upper one across each axis.
pub(crate) fn bits(of_axis: impl Fn(usize) -> [bool; 2]) -> u8 {
    (0..3).fold(0, |bits, axis| {
        let [low, high] = of_axis(axis).map(u8::from);
        bits | low << (2 * axis) | high << (2 * axis + 1)
    })
}

/// The sides across which a box repeats itself, a bit for each.
pub(crate) fn repeating(periodic: [bool; 3]) -> u8 {
    bits(|axis| [periodic[axis]; 2])
}

/// For every node a bit per bounding plane it lies on.
fn on_planes(points: &[Vec3]) -> Vec<u8> {
    let aabb = Aabb::around(points);
    let slack = 1e-9 * aabb.size().max();
    let on = |p: &Vec3| bits(|axis| [aabb.min, aabb.max].map(|plane| (p[axis] - plane[axis]).abs() <= slack));
    points.iter().map(on).collect()
}

/// The cells' faces on every bounding plane, by cell.
fn in_planes(mesh: Cells, nodes: &[u8]) -> [Vec<(u32, usize)>; 6] {
    let mut faces: [Vec<(u32, usize)>; 6] = Default::default();
    for (number, cell) in (0..).zip(mesh.iter()) {
        if cell.iter().all(|&node| nodes[node as usize] == 0) {
            continue;
        }
        for (face, corners) in mesh.kind.faces().iter().enumerate() {
            let on = corners.iter().fold(u8::MAX, |on, &i| on & nodes[cell[i] as usize]);
            (0..6).filter(|bit| on >> bit & 1 == 1).for_each(|bit| faces[bit].push((number, face)));
        }
    }
    faces
}

impl Mesh {
    /// The faces (cell, number of the face in [`CellKind::faces`](super::CellKind::faces)) of the mesh's surface, by cell,
    /// without the walls of pores inside.
    pub fn outer_faces(&self) -> Vec<(u32, usize)> {
        outer_faces(self.by_owner(), &self.cohesive)
    }
}

/// The faces that only one cell has, by cell, but for walls of pores; cohesive elements join the faces at their two sides.
fn outer_faces(mesh: Cells, cohesive: &[u32]) -> Vec<(u32, usize)> {
    let mut faces = by_nodes(mesh, |_| true);
    let joined = |face: &[u32]| {
        let mut nodes = [NO_NODE; 4];
        nodes[..face.len()].copy_from_slice(face);
        nodes.sort_unstable();
        (nodes, u32::MAX, 0)
    };
    faces.extend(cohesive.chunks_exact(mesh.kind.faces()[0].len()).map(joined));
    faces.par_sort_unstable();
    let lone = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| &same[0]);
    let mut lone: Vec<(u32, usize)> = lone.map(|&(_, cell, face)| (cell, face as usize)).collect();
    lone.sort_unstable();
    without_pores(mesh, cohesive, lone)
}

/// Those of the `lone` faces that edges connect with a bounding plane, also from one side of a cohesive element to the other.
fn without_pores(mesh: Cells, cohesive: &[u32], mut lone: Vec<(u32, usize)>) -> Vec<(u32, usize)> {
    let mut twin: Vec<u32> = (0..mesh.points.len() as u32).collect();
    for sides in cohesive.chunks_exact(2 * mesh.kind.faces()[0].len()) {
        let (one, other) = sides.split_at(sides.len() / 2);
        one.iter().zip(other).for_each(|(&one, &other)| join(&mut twin, one, other));
    }
    let on = on_planes(mesh.points);
    let (mut edges, mut reaches) = (Vec::new(), vec![false; lone.len()]);
    for (index, &(cell, face)) in (0..).zip(&lone) {
        let nodes: Vec<u32> = mesh.face(cell, face).collect();
        for (&node, &next) in nodes.iter().zip(nodes.iter().cycle().skip(1)) {
            let [a, b] = [node, next].map(|node| find(&mut twin, node));
            edges.push(([a.min(b), a.max(b)], index));
            reaches[index as usize] |= on[node as usize] != 0;
        }
    }
    edges.sort_unstable();
    let mut part: Vec<u32> = (0..lone.len() as u32).collect();
    // A pore may touch the surface at an edge, which four faces have.
    for same in edges.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 2) {
        join(&mut part, same[0].1, same[1].1);
    }
    for index in 0..lone.len() {
        let root = find(&mut part, index as u32) as usize;
        reaches[root] |= reaches[index];
    }
    let mut index = 0..;
    lone.retain(|_| index.next().is_some_and(|index| reaches[find(&mut part, index) as usize]));
    lone
}

/// Points this near to a side, in sizes of the box, are on it.
const ROUNDING: f64 = 1e-9;

/// The flat sides of a specimen's box across which it does not repeat itself, where aggregates end before the mesh does; in the order of [`SIDES`].
pub(crate) struct FlatSides {
    aabb: Aabb,
    /// A bit for each.
    sides: u8,
    slack: f64,
}

impl FlatSides {
    pub(crate) fn of(specimen: &Specimen) -> Self {
        let aabb = specimen.aabb();
        Self { aabb, sides: !repeating(specimen.periodic().0), slack: ROUNDING * aabb.size().max() }
    }

    /// Whether `x` lies on one of the sides.
    pub(crate) fn have(&self, x: &Vec3) -> bool {
        self.across(x) != 0
    }

    /// The sides that `x` lies on, a bit for each.
    pub(crate) fn across(&self, x: &Vec3) -> u8 {
        let on = |axis| [x[axis] <= self.aabb.min[axis] + self.slack, x[axis] >= self.aabb.max[axis] - self.slack];
        bits(on) & self.sides
    }

    /// From `body` to the farthest of the sides `across`, mm.
    pub(crate) fn gap(&self, body: &Aabb, across: u8) -> f64 {
        let gaps = |axis: usize| [body.min[axis] - self.aabb.min[axis], self.aabb.max[axis] - body.max[axis]];
        let all = [0, 1, 2].map(gaps);
        (0..6).filter(|side| across >> side & 1 == 1).map(|side| all.as_flattened()[side]).fold(0.0, f64::max)
    }
}
