//! Proves in f64 the pairs that single precision left open: a register of pairs at a time, from the portals they came
//! to.
//!
//! A portal that lies beyond the origin encloses it with v0: four determinants tell. For an origin before the portal
//! the outward normal is the direction that separates the bodies best: one support tells. Corners, normal and support
//! are all of f64, so that a portal that is none in f64 only fails to prove anything.

use super::supports::{Groups, Supports, corners, enclosing, unpacked};
use super::task::{List, Undecided};
use super::vectors::{Vectors, first_lanes};
use crate::gjk::ask::pair_query::PairQuery;
use crate::gjk::search::mpr::Portal;
use crate::simd::{Lanes, MOST_LANES, Mask, Simd};

/// Open pairs, each with a portal.
pub(super) struct Open<'a, 'q> {
    pub(super) queries: &'a [PairQuery<'q>],
    pub(super) gap: f64,
    pub(super) answers: &'a mut [Option<bool>],
    pub(super) undecided: &'a mut Vec<Undecided>,
}

/// A register of them.
struct Pairs<'q, L> {
    groups: Groups<'q, f64>,
    v0: Vectors<L>,
    reach: L,
    corners: [Vectors<L>; 3],
}

impl<'q> Open<'_, 'q> {
    /// Pairs of the list that share a point; the others are added to the second list.
    #[inline(always)]
    pub(super) fn enclose<S: Simd>(&mut self, simd: S, list: &List<4>, others: &mut List<4>) {
        for at in (0..list.len()).step_by(S::F64::LANES) {
            let Pairs { v0, reach, corners, .. } = self.pairs(simd, list, at);
            let overlap = enclosing(simd, v0, corners, reach).bits();
            for (l, i) in (at..list.len().min(at + S::F64::LANES)).enumerate() {
                if overlap >> l & 1 == 1 {
                    self.answers[row(list, i).0 as usize] = Some(true);
                } else {
                    others.push(list.row(i));
                }
            }
        }
    }

    /// Pairs of the list that are more than the gap apart, or share a point after all.
    #[inline(always)]
    pub(super) fn separate<S: Simd>(&mut self, simd: S, list: &List<4>) {
        for at in (0..list.len()).step_by(S::F64::LANES) {
            let Pairs { groups, v0, reach, corners } = self.pairs(simd, list, at);
            let [v1, v2, v3] = corners;
            let outward = (v2 - v1).cross(v3 - v1);
            let supports = Supports::new(simd, &groups, first_lanes(S::F64::LANES), outward, v0);
            let apart = supports.apart(simd, outward, reach, self.gap).0.bits();
            let overlap = enclosing(simd, v0, corners, reach).bits();
            for (l, i) in (at..list.len().min(at + S::F64::LANES)).enumerate() {
                let (query, portal) = row(list, i);
                if (apart | overlap) >> l & 1 == 1 {
                    self.answers[query as usize] = Some(overlap >> l & 1 == 1);
                } else {
                    self.undecided.push(Undecided { query, portal: Some(portal) });
                }
            }
        }
    }

    /// The pairs from row `at` on; the last one fills up.
    #[inline(always)]
    fn pairs<S: Simd>(&self, simd: S, list: &List<4>, at: usize) -> Pairs<'q, S::F64> {
        let mut of = [[(0, 0); MOST_LANES]; 3];
        let mut asked = [&self.queries[0]; MOST_LANES];
        for l in 0..S::F64::LANES {
            let (query, portal) = row(list, (at + l).min(list.len() - 1));
            asked[l] = &self.queries[query as usize];
            portal.into_iter().zip(&mut of).for_each(|(corner, of)| of[l] = corner);
        }
        let groups: Groups<'q, f64> = asked.map(|pair| [pair.a.first_group(), pair.b.first_group()]);
        let x = S::F64::of_lanes(simd, |l| -asked[l].b_from_a.x);
        let y = S::F64::of_lanes(simd, |l| -asked[l].b_from_a.y);
        let v0 = Vectors { x, y, z: S::F64::of_lanes(simd, |l| -asked[l].b_from_a.z) };
        let radii = S::F64::of_lanes(simd, |l| asked[l].a.circumradius() + asked[l].b.circumradius());
        let [v1, v2, v3] = [0, 1, 2];
        let corners = [
            corners(simd, &groups, |l| of[v1][l]) + v0,
            corners(simd, &groups, |l| of[v2][l]) + v0,
            corners(simd, &groups, |l| of[v3][l]) + v0,
        ];
        Pairs { groups, v0, reach: radii + v0.norm1(), corners }
    }
}

/// The question of a row, and its portal.
#[inline(always)]
fn row(list: &List<4>, i: usize) -> (u32, Portal) {
    let [question, v1, v2, v3] = list.row(i);
    (question.to_bits(), [unpacked(v1), unpacked(v2), unpacked(v3)])
}
