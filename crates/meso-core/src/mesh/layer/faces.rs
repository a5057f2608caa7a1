//! The faces of a periodic box: which nodes lie on them, and where else in the mesh the same place is.

use super::flat::Flat;
use crate::math::{Aabb, Vec3};
use crate::mesh::sides::Sides;
use crate::mesh::{Mesh, opposite};

/// The nodes on faces across which a box repeats itself; empty where it does not.
pub(super) struct Faces {
    walls: Aabb,
    /// The faces that each node has to stay in.
    flat: Vec<Flat>,
    /// One number for all images of a place, and the upper faces that the node lies on.
    places: Vec<Option<(u32, u8)>>,
    /// Places with their nodes, ascending.
    images: Vec<(u32, u32)>,
}

impl Faces {
    /// Those of `mesh`.
    pub(super) fn of(mesh: &Mesh) -> Self {
        if mesh.periodic == [false; 3] {
            let walls = Aabb::around(&mesh.points);
            return Self { walls, flat: Vec::new(), places: Vec::new(), images: Vec::new() };
        }
        Self::on(mesh, &Sides::of(mesh))
    }

    /// Those of a mesh with these `sides`.
    pub(super) fn on(mesh: &Mesh, sides: &Sides) -> Self {
        let places = opposite::places(mesh, sides);
        let mut images: Vec<(u32, u32)> =
            (0..).zip(&places).filter_map(|(node, place)| place.map(|(place, _)| (place, node))).collect();
        images.sort_unstable();
        let flat = (0..places.len() as u32).map(|node| Flat::of(sides.on(node), mesh.periodic)).collect();
        Self { walls: Aabb::around(&mesh.points), flat, places, images }
    }

    pub(super) fn walls(&self) -> &Aabb {
        &self.walls
    }

    /// The faces that a node has to stay in.
    pub(super) fn flat(&self, node: u32) -> Flat {
        self.flat.get(node as usize).copied().unwrap_or_default()
    }

    /// One number for all images of a node's place on the faces, and the upper ones that it lies on, a bit per axis; `None`
    /// elsewhere, and where opposite faces do not match.
    pub(super) fn place(&self, node: u32) -> Option<(u32, u8)> {
        self.places.get(node as usize).copied().flatten()
    }

    /// The nodes at all images of a place.
    pub(super) fn at(&self, place: u32) -> impl ExactSizeIterator<Item = u32> {
        let start = self.images.partition_point(|image| image.0 < place);
        let count = self.images[start..].partition_point(|image| image.0 == place);
        self.images[start..start + count].iter().map(|image| image.1)
    }

    /// The node and its images.
    pub(super) fn images(&self, node: u32) -> Vec<u32> {
        self.place(node).map_or_else(|| vec![node], |(place, _)| self.at(place).collect())
    }

    /// Whether a node may move as far as its faces go: it lies on none, or has all of its images.
    pub(super) fn is_matched(&self, node: u32) -> bool {
        let all = 1 << (0..3).filter(|&axis| self.flat(node).holds(axis)).count();
        self.images(node).len() == all
    }

    /// The place that an image's `x` is for `node`: as far as its faces allow.
    pub(super) fn put(&self, node: u32, x: &Vec3) -> Vec3 {
        self.flat(node).put(x, &self.walls)
    }
}
