//! A question about two bodies, one of many.

use crate::gjk::ask::cascade::Query;
use crate::gjk::body::Body;
use crate::math::Vec3;

/// Do A and B share a point, with B displaced by `b_from_a` (mm)?
#[derive(Clone, Copy, Debug)]
pub struct PairQuery<'a> {
    /// The first body.
    pub a: &'a Body,
    /// The second body.
    pub b: &'a Body,
    /// The displacement that takes B's points into A's frame, mm.
    pub b_from_a: Vec3,
}

impl<'a> PairQuery<'a> {
    #[inline(always)]
    pub(crate) fn query(&self, gap: f64) -> Query<'a> {
        Query { a: self.a, b: self.b, x: self.b_from_a, gap }
    }
}
