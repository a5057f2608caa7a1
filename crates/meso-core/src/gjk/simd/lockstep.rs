//! Eight pairs at a time through the portal search, on AVX-512.
//!
//! The same steps as [`portal`](super::super::portal), lane by lane. The first support decides most pairs that are apart:
//! it is taken of eight fresh pairs at a time. The others queue; whenever a lane's pair is decided, the next one takes its
//! place, so that no lane idles. Whatever is in doubt is left to the single query.

use super::super::batch::Ask;
use super::super::certificate::{ENCLOSING, UNDERFLOW};
use super::super::portal::TURN;
use super::eight::{Eight, LANES, Vectors};
use super::open::Open;
use super::supports::Supports;

/// Lanes in flight are this many times eight: what one rank waits for, another fills.
const RANKS: usize = 2;
/// Supports after which a pair is left to the single query.
const MAX_STEPS: f64 = 32.0;

/// Answers the chosen entries of `open`; `None` is left where the search ends in doubt.
#[target_feature(enable = "avx512f,avx2,fma")]
pub(super) fn search(asks: &[Ask<'_>], gap: f64, open: &Open, chosen: &[u32], answers: &mut [Option<bool>]) {
    let mut queue = Queue::new();
    let mut ranks = [Rank::idle(), Rank::idle()];
    let mut fresh = chosen.chunks(LANES);
    loop {
        while queue.len < RANKS * LANES
            && let Some(entries) = fresh.next()
        {
            queue.admit(asks, gap, open, entries, answers);
        }
        let mut busy = false;
        for rank in &mut ranks {
            rank.refill(&mut queue);
            if rank.live != 0 {
                rank.step(asks, gap, answers);
                busy = true;
            }
        }
        if !busy && fresh.len() == 0 {
            break;
        }
    }
}

/// The columns of a [`Queue`], each of one number per pair; vectors take three.
const DIRECTION: usize = 0;
const V0: usize = 3;
const V1: usize = 6;
const REACH: usize = 9;
/// The index of the question, as bits.
const ASK: usize = 10;
const COLUMNS: usize = 11;
/// Lanes to fill, eight more that are admitted together, and what a store of eight overshoots.
const ROOM: usize = (RANKS + 2) * LANES;

/// Pairs with their first support, waiting for a lane.
struct Queue {
    columns: [[f64; ROOM]; COLUMNS],
    len: usize,
}

impl Queue {
    fn new() -> Self {
        Self { columns: [[0.0; ROOM]; COLUMNS], len: 0 }
    }

    /// The first support of up to eight pairs: those that it leaves open queue up.
    #[inline(always)]
    fn admit(&mut self, asks: &[Ask<'_>], gap: f64, open: &Open, entries: &[u32], answers: &mut [Option<bool>]) {
        let entry = |l: usize| entries[l.min(entries.len() - 1)] as usize;
        let index: [usize; LANES] = std::array::from_fn(|l| open.asks()[entry(l)] as usize);
        let lanes: [&Ask<'_>; LANES] = index.map(|i| &asks[i]);
        let direction = directions(open, entry);
        let v0 = -Vectors::from_lanes(|l| &lanes[l].b_from_a);
        let radii = Eight::from_lanes(|l| lanes[l].a.circumradius() + lanes[l].b.circumradius());
        let reach = radii + v0.norm1();
        let filled = u8::MAX >> (LANES - entries.len());
        let portals = portals(&lanes) & filled;
        let supports = Supports::new(&lanes, portals, direction, v0);
        let (apart, leaves) = supports.apart(direction, reach, gap);
        for_each_lane(apart & portals, |l| answers[index[l]] = Some(false));
        let w = supports.points(&lanes, v0);
        let ask = Eight::from_lanes(|l| f64::from_bits(index[l] as u64));
        self.push(portals & !leaves, [turned_away(direction, w), v0, w], reach, ask);
    }

    #[inline(always)]
    fn push(&mut self, mask: u8, vectors: [Vectors; 3], reach: Eight, ask: Eight) {
        let at = self.len;
        for (v, column) in vectors.into_iter().zip([DIRECTION, V0, V1]) {
            v.x.front(mask).store(&mut self.columns[column], at);
            v.y.front(mask).store(&mut self.columns[column + 1], at);
            v.z.front(mask).store(&mut self.columns[column + 2], at);
        }
        reach.front(mask).store(&mut self.columns[REACH], at);
        ask.front(mask).store(&mut self.columns[ASK], at);
        self.len += mask.count_ones() as usize;
    }
}

/// As in [`portal`](super::super::portal).
#[inline(always)]
fn turned_away(v: Vectors, w: Vectors) -> Vectors {
    let share = v.dot(w) / w.dot(w) * Eight::all(TURN);
    v - Vectors { x: w.x * share, y: w.y * share, z: w.z * share }
}

/// The directions of eight entries.
#[inline(always)]
fn directions(open: &Open, entry: impl Fn(usize) -> usize) -> Vectors {
    let [x, y, z, _] = &open.columns;
    Vectors {
        x: Eight::from_lanes(|l| x[entry(l)]),
        y: Eight::from_lanes(|l| y[entry(l)]),
        z: Eight::from_lanes(|l| z[entry(l)]),
    }
}

/// The lanes whose bodies hold their frames' origins and have one group of points: those this search is for.
#[inline(always)]
fn portals(lanes: &[&Ask<'_>; LANES]) -> u8 {
    let fits = |ask: &Ask<'_>| {
        let (a, b) = (ask.a, ask.b);
        a.bounds.inradius > 0.0 && b.bounds.inradius > 0.0 && a.is_one_group() && b.is_one_group()
    };
    (0..LANES).fold(0, |mask, l| mask | u8::from(fits(lanes[l])) << l)
}

#[inline(always)]
fn for_each_lane(mut mask: u8, mut act: impl FnMut(usize)) {
    while mask != 0 {
        act(mask.trailing_zeros() as usize);
        mask &= mask - 1;
    }
}

/// Eight pairs on their way.
struct Rank {
    /// The lanes that have a pair.
    live: u8,
    /// Those that have a first point of the portal only.
    second: u8,
    /// Those whose ray passes the portal.
    found: u8,
    ask: Eight,
    direction: Vectors,
    v0: Vectors,
    v1: Vectors,
    v2: Vectors,
    v3: Vectors,
    reach: Eight,
    steps: Eight,
}

impl Rank {
    #[inline(always)]
    fn idle() -> Self {
        let zero = Eight::all(0.0);
        let none = Vectors { x: zero, y: zero, z: zero };
        Self {
            live: 0,
            second: 0,
            found: 0,
            ask: zero,
            direction: none,
            v0: none,
            v1: none,
            v2: none,
            v3: none,
            reach: zero,
            steps: zero,
        }
    }

    /// Pairs from the end of the queue for the lanes that have none.
    #[inline(always)]
    fn refill(&mut self, queue: &mut Queue) {
        let free = !self.live;
        let taken = queue.len.min(free.count_ones() as usize);
        if taken == 0 {
            return;
        }
        // The lowest lanes first: as many as there are pairs.
        let mut mask = free;
        for _ in taken..free.count_ones() as usize {
            mask &= !(0x80 >> mask.leading_zeros());
        }
        queue.len -= taken;
        let (columns, at) = (&queue.columns, queue.len);
        self.direction = self.direction.refilled(mask, columns, DIRECTION, at);
        self.v0 = self.v0.refilled(mask, columns, V0, at);
        self.v1 = self.v1.refilled(mask, columns, V1, at);
        self.reach = self.reach.refilled(mask, &columns[REACH], at);
        self.ask = self.ask.refilled(mask, &columns[ASK], at);
        self.steps = self.steps.or(mask, Eight::all(0.0));
        self.live |= mask;
        self.second |= mask;
        self.found &= !mask;
    }

    /// One support for everybody, and what follows from it.
    #[inline(always)]
    fn step(&mut self, asks: &[Ask<'_>], gap: f64, answers: &mut [Option<bool>]) {
        let mut index = [0.0; LANES];
        self.ask.store(&mut index, 0);
        let index = index.map(|i| i.to_bits() as usize);
        let lanes: [&Ask<'_>; LANES] = index.map(|i| &asks[i]);
        let supports = Supports::new(&lanes, self.live, self.direction, self.v0);
        let (apart, leaves) = supports.apart(self.direction, self.reach, gap);
        let second = self.second;
        let stuck = self.take(supports.points(&lanes, self.v0));
        self.direction = self.next_direction();
        self.face_origin(second);
        let (inside, enclosed) = self.encloses_origin();
        let overlap = enclosed & self.live & !leaves;
        let apart = apart & self.live;
        for_each_lane(apart | overlap, |l| answers[index[l]] = Some(overlap >> l & 1 == 1));
        self.steps = self.steps + Eight::all(1.0);
        self.live &= !(leaves | inside | stuck | self.steps.above(Eight::all(MAX_STEPS)));
    }

    /// Puts the new points where they belong; returns the lanes that make no progress.
    ///
    /// The second point as it comes; then discovery in the lanes without a portal and refinement in the others: see
    /// [`portal`](super::super::portal).
    #[inline(always)]
    fn take(&mut self, w: Vectors) -> u8 {
        let seeking = !(self.found | self.second);
        let zero = Eight::all(0.0);
        let across = self.v0.cross(w);
        let [e1, e2, e3] = [self.v1.dot(across), self.v2.dot(across), self.v3.dot(across)];
        let stuck = self.found & !(w - self.v1).dot(self.direction).above(zero);
        // Discovery: outside of the plane v0 v3 v1, of v0 v2 v3, or found.
        let outside31 = seeking & e1.above(zero);
        let outside23 = seeking & !outside31 & zero.above(e2);
        let just_found = seeking & !outside31 & !outside23;
        // Refinement: with the opposite signs, since it crosses the other way round.
        let leaves3 = self.found & zero.above(e1) & !zero.above(e2);
        let leaves1 = self.found & !leaves3 & zero.above(e2) & !zero.above(e3);
        let leaves2 = self.found & !leaves3 & !leaves1;
        self.v1 = self.v1.or(outside23 | leaves1, w);
        self.v2 = self.v2.or(self.second | outside31 | leaves2, w);
        self.v3 = self.v3.or(just_found | leaves3, w);
        self.found |= just_found;
        self.second = 0;
        stuck
    }

    /// Perpendicular to the plane of v0, v1, v2, on one side or the other; or outward from the portal.
    #[inline(always)]
    fn next_direction(&self) -> Vectors {
        let from = self.v0.or(self.found, self.v1);
        (self.v1.or(self.found, self.v2) - from).cross(self.v2.or(self.found, self.v3) - from)
    }

    /// Where v2 has just come, turns v0, v1, v2 so that the direction is on the origin's side of their plane.
    #[inline(always)]
    fn face_origin(&mut self, second: u8) {
        let away = second & self.direction.dot(self.v0).above(Eight::all(0.0));
        self.direction = self.direction.or(away, -self.direction);
        (self.v1, self.v2) = (self.v1.or(away, self.v2), self.v2.or(away, self.v1));
    }

    /// The lanes whose portal lies beyond the origin, and those of them where that is proved.
    #[inline(always)]
    fn encloses_origin(&self) -> (u8, u8) {
        let height = self.direction.dot(self.v1);
        let inside = self.found & height.above(Eight::all(0.0));
        if inside == 0 {
            return (0, 0);
        }
        let bound = self.reach * self.reach * self.reach * Eight::all(ENCLOSING) + Eight::all(UNDERFLOW);
        let (c12, c23) = (self.v2.cross(self.v1), self.v3.cross(self.v2));
        let [e12, e23, e31] = [c12.dot(self.v0), c23.dot(self.v0), self.v1.cross(self.v3).dot(self.v0)];
        let determinant = Eight::all(0.0) - self.v1.dot(c23);
        let proved = e12.above(bound) & e23.above(bound) & e31.above(bound) & determinant.above(bound);
        (inside, inside & proved)
    }
}
