//! Pairs with their first support, waiting for a lane.

use super::super::body::Group;
use super::super::cascade::NARROW_REACH;
use super::super::mpr::TURN;
use super::super::pair_query::PairQuery;
use super::supports::{Groups, Supports};
use super::task::{RANKS, Search};
use super::vectors::{Vectors, first_lanes};
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
/// Lanes to fill, a register's more that are admitted together, and what a store of a register overshoots.
const ROOM: usize = (RANKS + 2) * MOST_LANES;

/// Pairs with their first support, waiting for a lane.
pub(super) struct Queue {
    columns: [[f32; ROOM]; COLUMNS],
    len: usize,
}

/// Stands for the body of a lane that has no pair.
pub(super) static NOBODY: Group<f32> = Group([[0.0; 32]; 3]);

/// A register of fresh pairs.
struct Fresh<'q> {
    groups: Groups<'q, f32>,
    direction: [[f32; MOST_LANES]; 3],
    v0: [[f32; MOST_LANES]; 3],
    reach: [f32; MOST_LANES],
    question: [f32; MOST_LANES],
    /// The lanes this search is for.
    fit: u32,
}

impl<'q> Fresh<'q> {
    #[inline(always)]
    fn new(search: &Search<'_, 'q>, entries: &[u32]) -> Self {
        let nobody: &'q Group<f32> = &NOBODY;
        let mut fresh = Self {
            groups: [[nobody; 2]; MOST_LANES],
            direction: [[1.0; MOST_LANES]; 3],
            v0: [[0.0; MOST_LANES]; 3],
            reach: [0.0; MOST_LANES],
            question: [0.0; MOST_LANES],
            fit: 0,
        };
        for (l, &entry) in entries.iter().enumerate() {
            let question = search.pending.query(entry);
            let PairQuery { a, b, b_from_a: x } = search.queries[question as usize];
            let reach = a.circumradius() + b.circumradius() + (x.x.abs() + x.y.abs() + x.z.abs());
            let (Some(a), Some(b)) = (a.narrow(), b.narrow()) else { continue };
            if reach > NARROW_REACH {
                continue;
            }
            let v = search.pending.direction(entry);
            for axis in 0..3 {
                fresh.direction[axis][l] = v[axis] as f32;
                fresh.v0[axis][l] = -x[axis] as f32;
            }
            (fresh.groups[l], fresh.reach[l]) = ([a, b], reach as f32);
            fresh.question[l] = f32::from_bits(question);
            fresh.fit |= 1 << l;
        }
        fresh
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
        let Fresh { groups, direction, v0, reach, question, fit } = Fresh::new(search, entries);
        let (direction, v0) = (Vectors::load(simd, &direction), Vectors::load(simd, &v0));
        let (reach, question) = (S::F32::load(simd, &reach, 0), S::F32::load(simd, &question, 0));
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

/// As in [`mpr`](super::super::mpr).
#[inline(always)]
fn turned_away<S: Simd>(simd: S, v: Vectors<S::F32>, w: Vectors<S::F32>) -> Vectors<S::F32> {
    let share = v.dot(w) / w.dot(w) * S::F32::all(simd, TURN);
    v - w.times(share)
}
