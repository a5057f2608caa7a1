//! Pairs with their first support, waiting for a lane.

use super::supports::{Groups, Supports};
use super::task::{RANKS, Search};
use super::vectors::{Vectors, first_lanes, narrow_lanes};
use crate::gjk::ask::cascade::NARROW_REACH;
use crate::gjk::ask::pair_query::PairQuery;
use crate::gjk::body::Group;
use crate::gjk::search::mpr::TURN;
use crate::simd::{Lanes, MOST_LANES, Mask, Simd, for_each_lane};

/// The columns of a [`Queue`], each of one number per pair; vectors take three.
pub(super) const DIRECTION: usize = 0;
pub(super) const V0: usize = 3;
pub(super) const V1: usize = 6;
pub(super) const REACH: usize = 9;
/// The slots of v1, and the question, as bits.
pub(super) const SLOTS_1: usize = 10;
pub(super) const QUESTION: usize = 11;
const COLUMNS: usize = 12;
/// Lanes to fill, a register's more that are admitted together, and the overshoot of a register's store.
const ROOM: usize = (RANKS + 2) * MOST_LANES;

/// Pairs with their first support, waiting for a lane.
#[repr(align(64))]
pub(super) struct Queue {
    columns: [[f32; ROOM]; COLUMNS],
    len: usize,
}

/// Stands for the body of a lane that has no pair.
pub(super) static NOBODY: Group<f32> = Group([[0.0; 32]; 3]);

/// A register of fresh pairs.
struct Fresh<'q, S: Simd> {
    groups: Groups<'q, f32>,
    direction: Vectors<S::F32>,
    v0: Vectors<S::F32>,
    reach: S::F32,
    question: S::F32,
    /// The lanes this search is for.
    fit: u32,
}

impl<'q, S: Simd> Fresh<'q, S> {
    /// The last of the entries fills up, as a pair this search is not for.
    #[inline(always)]
    fn new(simd: S, search: &Search<'_, 'q>, entries: &[u32]) -> Self {
        let (mut rows, mut asked) = ([&[0.0; 8]; MOST_LANES], [&search.queries[0]; MOST_LANES]);
        for l in 0..narrow_lanes::<S>() {
            rows[l] = search.pending.row(entries[l.min(entries.len() - 1)]);
            asked[l] = &search.queries[rows[l][7].to_bits() as usize];
        }
        let (mut groups, mut fit): (Groups<'q, f32>, _) = ([[&NOBODY; 2]; MOST_LANES], 0);
        for l in 0..narrow_lanes::<S>() {
            let PairQuery { a, b, .. } = asked[l];
            groups[l] = [a.narrow_group(), b.narrow_group()];
            fit |= u32::from(a.is_narrow() & b.is_narrow()) << l;
        }
        let [x, y, z, x0, y0, z0, _, question] = simd.narrow_columns(&rows);
        let (direction, v0) = (Vectors { x, y, z }, Vectors { x: x0, y: y0, z: z0 });
        let radii = S::F32::of_lanes(simd, |l| (asked[l].a.circumradius() + asked[l].b.circumradius()) as f32);
        let reach = radii + v0.norm1();
        let near = S::F32::all(simd, NARROW_REACH as f32).above(reach).bits();
        Self { groups, direction, v0, reach, question, fit: fit & near & first_lanes(entries.len()) }
    }
}

impl Queue {
    pub(super) fn new() -> Self {
        Self { columns: [[0.0; ROOM]; COLUMNS], len: 0 }
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Takes up to `n` pairs from its end; returns how many, and where their numbers stand in each column.
    #[inline(always)]
    pub(super) fn take(&mut self, n: usize) -> (usize, usize) {
        let taken = self.len.min(n);
        self.len -= taken;
        (taken, self.len)
    }

    #[inline(always)]
    pub(super) fn column(&self, column: usize) -> &[f32; ROOM] {
        &self.columns[column]
    }

    /// The first support of up to a register of pairs: those that it leaves open queue up.
    #[inline(always)]
    pub(super) fn admit<S: Simd>(&mut self, simd: S, search: &mut Search<'_, '_>, entries: &[u32]) {
        let Fresh { groups, direction, v0, reach, question, fit } = Fresh::new(simd, search, entries);
        let supports = Supports::new(simd, &groups, fit, direction, v0);
        let (apart, leaves) = supports.apart(simd, direction, reach, search.gap as f32);
        let (apart, leaves) = (apart.bits(), leaves.bits());
        search.notes.apart.add([question], apart & fit);
        let open = first_lanes(entries.len()) & (!fit | leaves & !apart);
        for_each_lane(open, |l| search.give_up(&entries[l..=l]));
        let (w, slots) = supports.points(simd, &groups, v0);
        self.push(fit & !leaves, [turned_away(simd, direction, w), v0, w], [reach, slots, question]);
    }

    #[inline(always)]
    fn push<L: Lanes<T = f32>>(&mut self, mask: u32, vectors: [Vectors<L>; 3], [reach, slots, question]: [L; 3]) {
        let at = self.len;
        for (v, column) in vectors.into_iter().zip([DIRECTION, V0, V1]) {
            v.x.front(mask).store(&mut self.columns[column], at);
            v.y.front(mask).store(&mut self.columns[column + 1], at);
            v.z.front(mask).store(&mut self.columns[column + 2], at);
        }
        reach.front(mask).store(&mut self.columns[REACH], at);
        slots.front(mask).store(&mut self.columns[SLOTS_1], at);
        question.front(mask).store(&mut self.columns[QUESTION], at);
        self.len += mask.count_ones() as usize;
    }
}

/// Value as in [`mpr`](crate::gjk::search::mpr).
#[inline(always)]
fn turned_away<S: Simd>(simd: S, v: Vectors<S::F32>, w: Vectors<S::F32>) -> Vectors<S::F32> {
    let share = v.dot(w) / w.dot(w) * S::F32::all(simd, TURN);
    v - w.times(share)
}
