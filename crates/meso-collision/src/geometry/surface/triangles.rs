//! The triangles of a surface, found by where they lie.

use super::box_tree::BoxTree;
use super::nearest::nearest_on_triangle;
use crate::math::{Aabb, Vec3};

/// Triangles, each with its box, and a tree of these.
#[derive(Clone, Debug)]
pub struct Triangles {
    corners: Vec<[Vec3; 3]>,
    boxes: Vec<Aabb>,
    tree: BoxTree,
}

impl Triangles {
    /// Triangles with these corners, counter-clockwise seen from outside where they enclose a body.
    pub fn new(corners: Vec<[Vec3; 3]>) -> Self {
        let boxes: Vec<Aabb> = corners.iter().map(Aabb::around).collect();
        Self { tree: BoxTree::new(&boxes), corners, boxes }
    }

    /// Triangles that are in the order of a tree already, as those of a turned copy are: only boxes are computed.
    pub fn in_order(corners: Vec<[Vec3; 3]>) -> Self {
        let boxes: Vec<Aabb> = corners.iter().map(Aabb::around).collect();
        Self { tree: BoxTree::in_order(&boxes), corners, boxes }
    }

    /// True where `visit` is true for all pairs of triangles, one of each surface, whose boxes come within `margin` mm.
    pub(crate) fn all_pairs(&self, other: &Self, margin: f64, visit: impl FnMut(u32, u32) -> bool) -> bool {
        self.tree.all_pairs(&other.tree, margin, visit)
    }

    /// Numbers of the triangles in the order of the tree.
    pub fn order(&self) -> &[u32] {
        self.tree.order()
    }

    /// The smallest box around all triangles.
    pub fn aabb(&self) -> Aabb {
        self.tree.aabb()
    }

    /// Corners of every triangle.
    pub fn corners(&self) -> &[[Vec3; 3]] {
        &self.corners
    }

    /// The corners of this triangle.
    pub fn of(&self, triangle: u32) -> &[Vec3; 3] {
        &self.corners[triangle as usize]
    }

    /// The triangles whose boxes meet `aabb`, in any order.
    pub fn meeting(&self, aabb: Aabb) -> impl Iterator<Item = u32> {
        self.tree.near(aabb).filter(move |&t| self.boxes[t as usize].intersects(&aabb))
    }

    /// Numbers of the triangles whose boxes meet `aabb`, in ascending order.
    pub fn near(&self, aabb: &Aabb) -> Vec<u32> {
        let mut near: Vec<u32> = self.meeting(*aabb).collect();
        near.sort_unstable();
        near
    }

    /// The triangles whose boxes meet this triangle's, in any order, itself among them.
    pub fn around(&self, triangle: u32) -> impl Iterator<Item = u32> {
        self.meeting(self.boxes[triangle as usize])
    }

    /// The point of a triangle that is nearest to `point`, and its distance, mm.
    pub fn nearest_of(&self, triangle: u32, point: &Vec3) -> (Vec3, f64) {
        let nearest = nearest_on_triangle(self.of(triangle), point);
        (nearest, (nearest - point).norm())
    }

    /// True when a triangle comes within `most` mm of a point.
    pub fn is_within(&self, point: &Vec3, most: f64) -> bool {
        self.meeting(Aabb { min: *point, max: *point }.grown(most)).any(|t| self.nearest_of(t, point).1 <= most)
    }

    /// The point of all triangles that is nearest to `point`, and its distance, mm; `None` where there are none.
    pub fn nearest(&self, point: &Vec3) -> Option<(Vec3, f64)> {
        let nearest = self.nearest_triangle(point);
        nearest.map(|(t, distance)| (self.nearest_of(t, point).0, distance))
    }

    /// The triangle that is nearest to `point`, and its distance, mm; `None` where there are none.
    pub(crate) fn nearest_triangle(&self, point: &Vec3) -> Option<(u32, f64)> {
        self.tree.nearest(point, |t| self.nearest_of(t, point).1)
    }
}
