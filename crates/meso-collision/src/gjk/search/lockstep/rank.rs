//! A register of pairs on their way through the portal search.

use super::queue::{DIRECTION, NOBODY, QUESTION, Queue, REACH, SLOTS_1, V0, V1};
use super::supports::{Groups, Supports, doubt, enclosing};
use super::task::{Search, Undecided};
use super::vectors::{Vectors, first_lanes, narrow_lanes};
use crate::gjk::ask::pair_query::PairQuery;
use crate::gjk::search::mpr::MAX_STEPS;
use crate::simd::{Lanes, Lockstep, MOST_LANES, Mask as _, Simd, for_each_lane};

/// The share of a height's error within which a portal is as near the origin as single precision sees: f64 takes it up.
/// With a share of 1, nine times as many of these would not be the last portal of their search.
const NEAR: f32 = 0.125;

/// A register of pairs on their way.
pub(super) struct Rank<'q, S: Simd> {
    groups: Groups<'q, f32>,
    /// The lanes that have a pair, as bits.
    live: u32,
    /// Lanes that have only the first point of the portal.
    second: Mask<S>,
    /// Lanes whose ray passes the portal.
    found: Mask<S>,
    /// The question, as bits.
    question: S::F32,
    direction: Vectors<S::F32>,
    v0: Vectors<S::F32>,
    /// The corners of the portal.
    corners: [Vectors<S::F32>; 3],
    /// Their slots, as bits.
    slots: [S::F32; 3],
    reach: S::F32,
    /// Steps since it last took a pair.
    steps: usize,
}

type Mask<S> = <<S as Simd>::F32 as Lanes>::Mask;

impl<'q, S: Simd> Rank<'q, S> {
    #[inline(always)]
    pub(super) fn idle(simd: S) -> Self {
        let (zero, none) = (S::F32::all(simd, 0.0), Vectors::all(simd, 0.0));
        Self {
            groups: [[&NOBODY; 2]; MOST_LANES],
            live: 0,
            second: S::F32::mask(simd, 0),
            found: S::F32::mask(simd, 0),
            question: zero,
            direction: none,
            v0: none,
            corners: [none; 3],
            slots: [zero; 3],
            reach: zero,
            steps: 0,
        }
    }

    pub(super) fn is_busy(&self) -> bool {
        self.live != 0
    }

    /// Pairs from the end of the queue for the lanes that have none.
    #[inline(always)]
    pub(super) fn refill(&mut self, simd: S, queue: &mut Queue, queries: &[PairQuery<'q>]) {
        let free = !self.live & first_lanes(narrow_lanes::<S>());
        let (taken, at) = queue.take(free.count_ones() as usize);
        if taken == 0 {
            return;
        }
        // The lowest lanes first: as many as there are pairs.
        let mut bits = free;
        for _ in taken..free.count_ones() as usize {
            bits &= !(1 << (31 - bits.leading_zeros()));
        }
        self.direction = refilled(self.direction, bits, queue, DIRECTION, at);
        self.v0 = refilled(self.v0, bits, queue, V0, at);
        self.corners[0] = refilled(self.corners[0], bits, queue, V1, at);
        self.reach = self.reach.refilled(bits, queue.column(REACH), at);
        self.slots[0] = self.slots[0].refilled(bits, queue.column(SLOTS_1), at);
        self.question = self.question.refilled(bits, queue.column(QUESTION), at);
        let mask = S::F32::mask(simd, bits);
        self.steps = 0;
        self.second = self.second | mask;
        self.found = self.found.but_not(mask);
        self.live |= bits;
        let mut next = at;
        for_each_lane(bits, |l| {
            let query = &queries[queue.column(QUESTION)[next].to_bits() as usize];
            self.groups[l] = [query.a.narrow_group(), query.b.narrow_group()];
            next += 1;
        });
    }

    /// One support for everybody, and its consequences.
    #[inline(always)]
    pub(super) fn step(&mut self, simd: S, search: &mut Search<'_, '_>) {
        let supports = Supports::new(simd, &self.groups, self.live, self.direction, self.v0);
        let (apart, leaves) = supports.apart(simd, self.direction, self.reach, search.gap as f32);
        let (w, slots) = supports.points(simd, &self.groups, self.v0);
        let stuck = self.take(simd, w, slots, doubt(simd, self.direction, self.reach));
        self.direction = self.next_direction();
        let (zero, height) = (S::F32::all(simd, 0.0), self.direction.dot(self.corners[0]));
        let beyond = self.found & height.above(zero);
        let within = doubt(simd, self.direction, self.reach) * S::F32::all(simd, NEAR);
        let near = self.found & (height + within).above(zero);
        let overlap = (enclosing(simd, self.v0, self.corners, self.reach) & beyond).but_not(leaves);
        self.steps += 1;
        let over = if self.steps > MAX_STEPS { self.live } else { (leaves | beyond | near | stuck).bits() };
        self.note(apart.bits(), overlap.bits(), beyond.bits(), over, search);
    }

    /// Lists the lanes that are over, and makes room in them.
    #[inline(always)]
    fn note(&mut self, apart: u32, overlap: u32, beyond: u32, over: u32, search: &mut Search<'_, '_>) {
        let (apart, overlap) = (apart & self.live, overlap & self.live);
        search.notes.apart.add([self.question], apart);
        search.notes.overlap.add([self.question], overlap);
        let open = over & self.live & !(apart | overlap);
        self.live &= !over;
        // Near touch most pairs come here, elsewhere hardly any.
        if open == 0 {
            return;
        }
        let (found, [s1, s2, s3]) = (self.found.bits(), self.slots);
        search.notes.beyond.add([self.question, s1, s2, s3], open & beyond);
        search.notes.before.add([self.question, s1, s2, s3], open & found & !beyond);
        if open & !found != 0 {
            let questions = self.question.to_array();
            for_each_lane(open & !found, |l| {
                search.undecided.push(Undecided { query: questions.as_ref()[l].to_bits(), portal: None });
            });
        }
    }

    /// Puts the new points where they belong; returns the lanes that make no progress beyond `doubt`.
    ///
    /// The second point so that v0, v1, v2 face the origin; then discovery in the lanes without a portal and refinement
    /// in the others: see [`mpr`](crate::gjk::search::mpr).
    #[inline(always)]
    fn take(&mut self, simd: S, w: Vectors<S::F32>, slots: S::F32, doubt: S::F32) -> Mask<S> {
        let (zero, found, second) = (S::F32::all(simd, 0.0), self.found, self.second);
        let across = self.v0.cross(w);
        let [v1, v2, v3] = self.corners;
        let [e1, e2, e3] = [v1.dot(across), v2.dot(across), v3.dot(across)];
        let below = [zero.above(e1), zero.above(e2), zero.above(e3)];
        let stuck = found.but_not((w - v1).dot(self.direction).above(doubt));
        // The second point is the first corner where that turns the normal towards the origin.
        let swapped = second & below[0];
        // Discovery: outside of the plane v0 v3 v1, of v0 v2 v3, or found.
        let outside31 = e1.above(zero).but_not(found | second);
        let outside23 = below[1].but_not(found | second | outside31);
        let just_found =
            S::F32::mask(simd, first_lanes(narrow_lanes::<S>())).but_not(found | second | outside31 | outside23);
        // Refinement: with the opposite signs, since it crosses the other way round.
        let leaves3 = (found & below[0]).but_not(below[1]);
        let leaves1 = (found & below[1]).but_not(leaves3 | below[2]);
        let leaves2 = found.but_not(leaves3 | leaves1);
        let masks = [outside23 | leaves1 | swapped, second | outside31 | leaves2, just_found | leaves3];
        self.corners = [v1.or(masks[0], w), v2.or(masks[1], w).or(swapped, v1), v3.or(masks[2], w)];
        let [s1, s2, s3] = self.slots;
        self.slots = [s1.or(masks[0], slots), s2.or(masks[1], slots).or(swapped, s1), s3.or(masks[2], slots)];
        self.found = found | just_found;
        self.second = S::F32::mask(simd, 0);
        stuck
    }

    /// Perpendicular to the plane of v0, v1, v2, on one side or the other; or outward from the portal.
    #[inline(always)]
    fn next_direction(&self) -> Vectors<S::F32> {
        let [v1, v2, v3] = self.corners;
        let from = self.v0.or(self.found, v1);
        (v1.or(self.found, v2) - from).cross(v2.or(self.found, v3) - from)
    }
}

/// The lanes of the mask filled from three columns.
#[inline(always)]
fn refilled<L: Lockstep>(v: Vectors<L>, mask: u32, queue: &Queue, column: usize, at: usize) -> Vectors<L> {
    Vectors {
        x: v.x.refilled(mask, queue.column(column), at),
        y: v.y.refilled(mask, queue.column(column + 1), at),
        z: v.z.refilled(mask, queue.column(column + 2), at),
    }
}
