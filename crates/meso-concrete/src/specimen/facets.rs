//! The triangles of a surface, found by where they lie.

use meso_collision::geometry::{BoxTree, nearest_on_triangle};
use meso_collision::math::{Aabb, Vec3};

/// Triangles, each with its box, and a tree of these.
#[derive(Clone, Debug)]
pub(super) struct Facets {
    corners: Vec<[Vec3; 3]>,
    boxes: Vec<Aabb>,
    tree: BoxTree,
}

impl Facets {
    pub(super) fn new(corners: Vec<[Vec3; 3]>) -> Self {
        let boxes: Vec<Aabb> = corners.iter().map(Aabb::around).collect();
        Self { tree: BoxTree::new(&boxes), corners, boxes }
    }

    /// Corners of every triangle.
    pub(super) fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// The corners of this triangle.
    pub(super) fn of(&self, triangle: u32) -> &[Vec3; 3] {
        &self.corners[triangle as usize]
    }

    /// The triangles whose boxes meet `aabb`, in any order.
    pub(super) fn meeting(&self, aabb: Aabb) -> impl Iterator<Item = u32> {
        self.tree.near(aabb).filter(move |&t| self.boxes[t as usize].intersects(&aabb))
    }

    /// Numbers of the triangles whose boxes meet `aabb`, in ascending order.
    pub(super) fn near(&self, aabb: &Aabb) -> Vec<u32> {
        let mut near: Vec<u32> = self.meeting(*aabb).collect();
        near.sort_unstable();
        near
    }

    /// The triangles whose boxes meet this triangle's, in any order, itself among them.
    pub(super) fn around(&self, triangle: u32) -> impl Iterator<Item = u32> {
        self.meeting(self.boxes[triangle as usize])
    }

    /// The point of a triangle that is nearest to `point`, and its distance, mm.
    pub(super) fn nearest_of(&self, triangle: u32, point: &Vec3) -> (Vec3, f64) {
        let nearest = nearest_on_triangle(self.of(triangle), point);
        (nearest, (nearest - point).norm())
    }

    /// The point of all triangles that is nearest to `point`, and its distance, mm; `None` where there are none.
    pub(super) fn nearest(&self, point: &Vec3) -> Option<(Vec3, f64)> {
        let found = self.tree.nearest(point, |t| self.nearest_of(t, point).1);
        found.map(|(t, distance)| (self.nearest_of(t, point).0, distance))
    }
}
