//! The bounding planes of a mesh: which nodes and which cells' faces lie on them.

use super::Mesh;
use crate::math::{Aabb, Vec3};

/// The bounding planes: axis, whether it is the upper one, and the name of its node set.
pub const SIDES: [(usize, bool, &str); 6] = [
    (0, false, "XMIN"),
    (0, true, "XMAX"),
    (1, false, "YMIN"),
    (1, true, "YMAX"),
    (2, false, "ZMIN"),
    (2, true, "ZMAX"),
];

/// For every node a bit per bounding plane it lies on, in the order of [`SIDES`].
#[derive(Clone, Debug)]
pub struct Sides(Vec<u8>);

impl Sides {
    /// Those of `points`, mm.
    pub fn of(points: &[Vec3]) -> Self {
        let aabb = Aabb::around(points);
        let slack = 1e-9 * aabb.size().max();
        let on = |x: f64, axis: usize, upper: bool| {
            let plane = if upper { aabb.max[axis] } else { aabb.min[axis] };
            u8::from((x - plane).abs() <= slack)
        };
        let bits = |p: &Vec3| {
            SIDES.iter().enumerate().fold(0, |bits, (i, &(axis, upper, _))| bits | on(p[axis], axis, upper) << i)
        };
        Self(points.iter().map(bits).collect())
    }

    /// The planes that `node` lies on.
    pub fn on(&self, node: u32) -> u8 {
        self.0[node as usize]
    }

    /// The nodes on bounding plane `bit` of [`SIDES`], ascending.
    pub fn members(&self, bit: usize) -> impl Iterator<Item = u32> {
        (0..).zip(&self.0).filter(move |(_, on)| **on >> bit & 1 == 1).map(|(node, _)| node)
    }

    /// The faces (cell, number of the face in [`CellKind::faces`](super::CellKind::faces)) on every plane, by cell.
    pub fn faces(&self, mesh: &Mesh) -> [Vec<(u32, usize)>; 6] {
        let mut faces: [Vec<(u32, usize)>; 6] = Default::default();
        for (number, cell) in (0..).zip(mesh.cells()) {
            if cell.iter().all(|&node| self.0[node as usize] == 0) {
                continue;
            }
            for (face, nodes) in mesh.kind.faces().iter().enumerate() {
                let on = nodes.iter().fold(u8::MAX, |on, &i| on & self.0[cell[i] as usize]);
                (0..6).filter(|bit| on >> bit & 1 == 1).for_each(|bit| faces[bit].push((number, face)));
            }
        }
        faces
    }
}
