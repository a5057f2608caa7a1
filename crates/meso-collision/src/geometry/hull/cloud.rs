//! Points side by side: heights above a plane for eight of them at a time.

use super::surface::error_bound;
use crate::math::{Aabb, Vec3};

/// Points looked at together.
pub(super) const LANES: usize = 8;
/// Groups of them; the work grows with their square.
pub(super) const MOST_GROUPS: usize = 12;
/// No more points than this are looked at all together.
pub(super) const MOST_POINTS: usize = LANES * MOST_GROUPS;

/// One number of each point in a group.
pub(super) type Group = [f64; LANES];

/// Points about the middle of their box, one list per coordinate, padded to whole groups with a point inside.
#[derive(Clone, Debug, Default)]
pub(super) struct Cloud {
    pub(super) x: [Group; MOST_GROUPS],
    pub(super) y: [Group; MOST_GROUPS],
    pub(super) z: [Group; MOST_GROUPS],
    /// Groups in use.
    pub(super) groups: usize,
    error_bound: f64,
}

impl Cloud {
    /// Points, at most [`MOST_POINTS`].
    #[inline(always)]
    pub(super) fn new(points: &[Vec3]) -> Self {
        let mut cloud = Self::default();
        cloud.fill(points);
        cloud
    }

    /// Takes these points in place of those it had.
    #[inline(always)]
    pub(super) fn fill(&mut self, points: &[Vec3]) {
        let aabb = Aabb::around(points);
        let middle = (aabb.min + aabb.max) * 0.5;
        let inside = points.iter().sum::<Vec3>() / points.len() as f64 - middle;
        self.groups = points.len().div_ceil(LANES);
        self.error_bound = error_bound(&aabb);
        for (i, point) in points.iter().enumerate() {
            self.set(i, &(point - middle));
        }
        for i in points.len()..LANES * self.groups {
            self.set(i, &inside);
        }
    }

    #[inline(always)]
    fn set(&mut self, i: usize, point: &Vec3) {
        let (group, lane) = (i / LANES, i % LANES);
        (self.x[group][lane], self.y[group][lane], self.z[group][lane]) = (point.x, point.y, point.z);
    }

    /// One of the points.
    #[inline(always)]
    pub(super) fn point(&self, i: usize) -> Vec3 {
        let (group, lane) = (i / LANES, i % LANES);
        Vec3::new(self.x[group][lane], self.y[group][lane], self.z[group][lane])
    }

    /// Twice the vector area of a triangle of the points, and its product with a corner.
    #[inline(always)]
    pub(super) fn plane(&self, [a, b, c]: [usize; 3]) -> (Vec3, f64) {
        let (a, b, c) = (self.point(a), self.point(b), self.point(c));
        let normal = (b - a).cross(&(c - a));
        (normal, normal.dot(&c))
    }

    /// Heights of a group above a [`plane`](Self::plane); counts by lane the points that are not certainly below it.
    #[inline(always)]
    pub(super) fn heights(&self, group: usize, (normal, offset): &(Vec3, f64), not_below: &mut [u32; LANES]) -> Group {
        let (x, y, z) = (&self.x[group], &self.y[group], &self.z[group]);
        let mut heights = [0.0; LANES];
        for lane in 0..LANES {
            heights[lane] = normal.x * x[lane] + normal.y * y[lane] + normal.z * z[lane] - offset;
            not_below[lane] += u32::from(heights[lane] >= -self.error_bound);
        }
        heights
    }
}
