//! The support of a body: its points, and the farthest of them along a direction.

use crate::math::Vec3;

/// The convex hull of finitely many points, closed, of any dimension from a point to a solid.
pub trait Support {
    /// Number of points, at least one.
    fn len(&self) -> usize;

    /// Point `i`, mm.
    fn point(&self, i: usize) -> Vec3;

    /// True for a body without points; such a body is rejected before any search.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of a point farthest along `direction`, up to rounding.
    ///
    /// The index steers a search and decides nothing: answers rest on certificates.
    fn extreme(&self, direction: &Vec3) -> usize {
        let height = |i: usize| self.point(i).dot(direction);
        (1..self.len()).fold(0, |best, i| if height(i) > height(best) { i } else { best })
    }
}

impl Support for [Vec3] {
    fn len(&self) -> usize {
        <[Vec3]>::len(self)
    }

    fn point(&self, i: usize) -> Vec3 {
        self[i]
    }
}
