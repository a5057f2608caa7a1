//! Many pairs at a time through the portal search, in f32.
//!
//! The same steps as [`mpr`](super::super::mpr), lane by lane. The first support decides most pairs that are apart: it is
//! taken of a register of fresh pairs at a time. The others queue; whenever a lane's pair is decided, the next one takes its
//! place, so that no lane idles. Single precision proves what it can; what it cannot is left to the single query, with the
//! portal it came to.

use super::super::body::Group;
use super::super::cascade::NARROW_REACH;
use super::super::kernel::Real;
use super::super::mpr::{self, MAX_STEPS, Portal, Refined, TURN};
use super::super::pair_query::PairQuery;
use super::pending::Pending;
use super::supports::{Groups, Supports, doubt, unpacked};
use super::vectors::{Vectors, first_lanes, narrow_lanes};
use crate::simd::{Lanes, Lockstep, MOST_LANES, Simd, Vectorized, for_each_lane};

/// Registers of pairs in flight: what one waits for, another fills.
const RANKS: usize = 2;

/// Pairs ahead of which the points in f64 are asked for, which the search in f32 never reads.
const SOON: usize = 3;

/// A pair that the search left open.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Undecided {
    /// Its entry of `pending`.
    pub(in super::super) entry: u32,
    /// The portal it came to.
    pub(in super::super) portal: Option<Portal>,
}

/// Answers the chosen entries of `pending`; those it cannot are listed.
pub(in super::super) struct Search<'a, 'q> {
    pub(in super::super) queries: &'a [PairQuery<'q>],
    pub(in super::super) gap: f64,
    pub(in super::super) pending: &'a Pending,
    pub(in super::super) chosen: &'a [u32],
    pub(in super::super) answers: &'a mut [Option<bool>],
    pub(in super::super) undecided: &'a mut Vec<Undecided>,
}

impl Vectorized for Search<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        // Not compiled where it does not pay. Nobody comes here then, unless another thread has just chosen such a set.
        if !S::LOCKSTEP_PAYS {
            self.undecided.extend(self.chosen.iter().map(|&entry| Undecided { entry, portal: None }));
            return;
        }
        let mut queue = Queue::new();
        let mut ranks = [Rank::idle(simd), Rank::idle(simd)];
        let mut notes = Notes::new();
        let mut fresh = self.chosen.chunks(narrow_lanes::<S>());
        loop {
            while queue.len < RANKS * narrow_lanes::<S>()
                && let Some(entries) = fresh.next()
            {
                queue.admit(simd, &mut self, entries, &mut notes);
            }
            let mut busy = false;
            for rank in &mut ranks {
                rank.refill(simd, &mut queue);
                if rank.live != 0 {
                    rank.step(simd, &mut self, &mut notes);
                    busy = true;
                }
            }
            if !busy && fresh.len() == 0 {
                break;
            }
        }
        notes.enter(&mut self);
        self.resume(simd);
    }
}

/// Entries that were answered, on their way to where the answers belong.
///
/// Noted a register at a time: nobody could foretell a branch for each.
struct Notes {
    apart: Column,
    overlap: Column,
}

/// Entries, as bits.
struct Column {
    entries: [f32; NOTES],
    len: usize,
}

/// Room for entries.
const NOTES: usize = 8 * MOST_LANES;

impl Notes {
    fn new() -> Self {
        let empty = || Column { entries: [0.0; NOTES], len: 0 };
        Self { apart: empty(), overlap: empty() }
    }

    /// Notes the entries of the lanes of either mask.
    #[inline(always)]
    fn take<L: Lanes<T = f32>>(&mut self, entries: L, apart: u32, overlap: u32, search: &mut Search<'_, '_>) {
        self.apart.add(entries, apart);
        self.overlap.add(entries, overlap);
        if self.apart.len.max(self.overlap.len) > NOTES - MOST_LANES {
            self.enter(search);
        }
    }

    /// Gives the answers.
    fn enter(&mut self, search: &mut Search<'_, '_>) {
        for (column, overlap) in [(&mut self.apart, false), (&mut self.overlap, true)] {
            column.entries[..column.len].iter().for_each(|entry| search.answer(entry.to_bits(), overlap));
            column.len = 0;
        }
    }
}

impl Column {
    #[inline(always)]
    fn add<L: Lanes<T = f32>>(&mut self, entries: L, mask: u32) {
        entries.front(mask).store(&mut self.entries, self.len);
        self.len += mask.count_ones() as usize;
    }
}

/// Stands for the body of a lane that has no pair.
static NOBODY: Group<f32> = Group([[0.0; 32]; 3]);

impl<'q> Search<'_, 'q> {
    fn query(&self, entry: u32) -> &PairQuery<'q> {
        &self.queries[self.pending.queries()[entry as usize] as usize]
    }

    /// Takes the undecided pairs up in f64, from the portals they came to; most are decided there at once.
    #[inline(always)]
    fn resume<S: Simd>(&mut self, simd: S) {
        let mut left = 0;
        for i in 0..self.undecided.len() {
            if let Some(soon) = self.undecided.get(i + SOON) {
                let PairQuery { a, b, .. } = self.query(soon.entry);
                a.prefetch_wide();
                b.prefetch_wide();
            }
            let Undecided { entry, portal } = self.undecided[i];
            let refined = match portal {
                Some(portal) => mpr::resume(self.query(entry).query(self.gap).pair(), simd, portal, self.gap),
                None => None,
            };
            match refined {
                Some(Refined::Apart(_)) => self.answer(entry, false),
                Some(Refined::Overlap(_)) => self.answer(entry, true),
                _ => {
                    self.undecided[left] = self.undecided[i];
                    left += 1;
                }
            }
        }
        self.undecided.truncate(left);
    }

    #[inline(always)]
    fn answer(&mut self, entry: u32, overlap: bool) {
        self.answers[self.pending.queries()[entry as usize] as usize] = Some(overlap);
    }
}

/// The columns of a [`Queue`], each of one number per pair; vectors take three.
const DIRECTION: usize = 0;
const V0: usize = 3;
const V1: usize = 6;
const REACH: usize = 9;
/// The slots of v1, and the entry of the list, as bits.
const SLOTS_1: usize = 10;
const ENTRY: usize = 11;
const COLUMNS: usize = 12;
/// Lanes to fill, a register's more that are admitted together, and what a store of a register overshoots.
const ROOM: usize = (RANKS + 2) * MOST_LANES;

/// Pairs with their first support, waiting for a lane.
struct Queue {
    columns: [[f32; ROOM]; COLUMNS],
    len: usize,
}

/// A register of fresh pairs.
struct Fresh<'q> {
    groups: Groups<'q>,
    direction: [[f32; MOST_LANES]; 3],
    v0: [[f32; MOST_LANES]; 3],
    reach: [f32; MOST_LANES],
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
            fit: 0,
        };
        for (l, &entry) in entries.iter().enumerate() {
            let PairQuery { a, b, b_from_a: x } = *search.query(entry);
            let reach = a.circumradius() + b.circumradius() + (x.x.abs() + x.y.abs() + x.z.abs());
            let (Some(a), Some(b)) = (a.narrow(), b.narrow()) else { continue };
            if reach > NARROW_REACH {
                continue;
            }
            let v = search.pending.direction(entry as usize);
            for axis in 0..3 {
                fresh.direction[axis][l] = v[axis] as f32;
                fresh.v0[axis][l] = -x[axis] as f32;
            }
            (fresh.groups[l], fresh.reach[l]) = ([a, b], reach as f32);
            fresh.fit |= 1 << l;
        }
        fresh
    }
}

impl Queue {
    fn new() -> Self {
        Self { columns: [[0.0; ROOM]; COLUMNS], len: 0 }
    }

    /// The first support of up to a register of pairs: those that it leaves open queue up.
    #[inline(always)]
    fn admit<S: Simd>(&mut self, simd: S, search: &mut Search<'_, '_>, entries: &[u32], notes: &mut Notes) {
        let Fresh { groups, direction, v0, reach, fit } = Fresh::new(search, entries);
        let (direction, v0) = (Vectors::load(simd, &direction), Vectors::load(simd, &v0));
        let reach = S::F32::load(simd, &reach, 0);
        let supports = Supports::new(simd, &groups, fit, direction, v0);
        let (apart, leaves) = supports.apart(simd, direction, reach, search.gap as f32);
        let mut index = [0.0; MOST_LANES];
        for (index, &entry) in index.iter_mut().zip(entries) {
            *index = f32::from_bits(entry);
        }
        let entry = S::F32::load(simd, &index, 0);
        notes.take(entry, apart & fit, 0, search);
        let open = first_lanes(entries.len()) & (!fit | leaves & !apart);
        for_each_lane(open, |l| search.undecided.push(Undecided { entry: entries[l], portal: None }));
        let (w, slots) = supports.points(simd, &groups, v0);
        self.push(fit & !leaves, [turned_away(simd, direction, w), v0, w], [reach, slots, entry]);
    }

    #[inline(always)]
    fn push<L: Lanes<T = f32>>(&mut self, mask: u32, vectors: [Vectors<L>; 3], [reach, slots, entry]: [L; 3]) {
        let at = self.len;
        for (v, column) in vectors.into_iter().zip([DIRECTION, V0, V1]) {
            v.x.front(mask).store(&mut self.columns[column], at);
            v.y.front(mask).store(&mut self.columns[column + 1], at);
            v.z.front(mask).store(&mut self.columns[column + 2], at);
        }
        reach.front(mask).store(&mut self.columns[REACH], at);
        slots.front(mask).store(&mut self.columns[SLOTS_1], at);
        entry.front(mask).store(&mut self.columns[ENTRY], at);
        self.len += mask.count_ones() as usize;
    }
}

/// As in [`mpr`](super::super::mpr).
#[inline(always)]
fn turned_away<S: Simd>(simd: S, v: Vectors<S::F32>, w: Vectors<S::F32>) -> Vectors<S::F32> {
    let share = v.dot(w) / w.dot(w) * S::F32::all(simd, TURN);
    v - w.times(share)
}

/// A register of pairs on their way.
struct Rank<S: Simd> {
    /// The lanes that have a pair.
    live: u32,
    /// Those that have a first point of the portal only.
    second: u32,
    /// Those whose ray passes the portal.
    found: u32,
    entry: S::F32,
    direction: Vectors<S::F32>,
    v0: Vectors<S::F32>,
    /// The corners of the portal.
    corners: [Vectors<S::F32>; 3],
    /// Their slots, as bits.
    slots: [S::F32; 3],
    reach: S::F32,
    steps: S::F32,
}

impl<S: Simd> Rank<S> {
    #[inline(always)]
    fn idle(simd: S) -> Self {
        let (zero, none) = (S::F32::all(simd, 0.0), Vectors::all(simd, 0.0));
        Self {
            live: 0,
            second: 0,
            found: 0,
            entry: zero,
            direction: none,
            v0: none,
            corners: [none; 3],
            slots: [zero; 3],
            reach: zero,
            steps: zero,
        }
    }

    /// Pairs from the end of the queue for the lanes that have none.
    #[inline(always)]
    fn refill(&mut self, simd: S, queue: &mut Queue) {
        let free = !self.live & first_lanes(narrow_lanes::<S>());
        let taken = queue.len.min(free.count_ones() as usize);
        if taken == 0 {
            return;
        }
        // The lowest lanes first: as many as there are pairs.
        let mut mask = free;
        for _ in taken..free.count_ones() as usize {
            mask &= !(1 << (31 - mask.leading_zeros()));
        }
        queue.len -= taken;
        let (columns, at) = (&queue.columns, queue.len);
        self.direction = refilled(self.direction, mask, columns, DIRECTION, at);
        self.v0 = refilled(self.v0, mask, columns, V0, at);
        self.corners[0] = refilled(self.corners[0], mask, columns, V1, at);
        self.reach = self.reach.refilled(mask, &columns[REACH], at);
        self.slots[0] = self.slots[0].refilled(mask, &columns[SLOTS_1], at);
        self.entry = self.entry.refilled(mask, &columns[ENTRY], at);
        self.steps = self.steps.or(mask, S::F32::all(simd, 0.0));
        self.live |= mask;
        self.second |= mask;
        self.found &= !mask;
    }

    /// One support for everybody, and what follows from it.
    #[inline(always)]
    fn step(&mut self, simd: S, search: &mut Search<'_, '_>, notes: &mut Notes) {
        let mut index = [0.0; MOST_LANES];
        self.entry.store(&mut index, 0);
        let groups = self.groups(search, &index);
        let supports = Supports::new(simd, &groups, self.live, self.direction, self.v0);
        let (apart, leaves) = supports.apart(simd, self.direction, self.reach, search.gap as f32);
        let second = self.second;
        let (w, slots) = supports.points(simd, &groups, self.v0);
        let stuck = self.take(simd, w, slots, doubt(simd, self.direction, self.reach));
        self.direction = self.next_direction();
        self.face_origin(simd, second);
        let (inside, enclosed) = self.encloses_origin(simd);
        let overlap = enclosed & self.live & !leaves;
        let decided = (apart | overlap) & self.live;
        notes.take(self.entry, apart & self.live, overlap, search);
        self.steps = self.steps + S::F32::all(simd, 1.0);
        let over = leaves | inside | stuck | self.steps.above(S::F32::all(simd, MAX_STEPS as f32));
        self.report(self.live & over & !decided, &index, search);
        self.live &= !over;
    }

    #[inline(always)]
    fn groups<'q>(&self, search: &Search<'_, 'q>, index: &[f32; MOST_LANES]) -> Groups<'q> {
        let nobody: &'q Group<f32> = &NOBODY;
        let mut groups = [[nobody; 2]; MOST_LANES];
        for l in 0..narrow_lanes::<S>() {
            if self.live >> l & 1 == 1 {
                let query = search.query(index[l].to_bits());
                groups[l] = [query.a.narrow_group(), query.b.narrow_group()];
            }
        }
        groups
    }

    /// Lists the lanes of the mask as undecided.
    #[inline(always)]
    fn report(&self, mask: u32, index: &[f32; MOST_LANES], search: &mut Search<'_, '_>) {
        if mask == 0 {
            return;
        }
        let mut slots = [[0.0; MOST_LANES]; 3];
        for (slots, of) in slots.iter_mut().zip(self.slots) {
            of.store(slots, 0);
        }
        let found = self.found;
        for_each_lane(mask, |l| {
            let portal = (found >> l & 1 == 1).then(|| slots.map(|of| unpacked(of[l])));
            search.undecided.push(Undecided { entry: index[l].to_bits(), portal });
        });
    }

    /// Puts the new points where they belong; returns the lanes that make no progress beyond `doubt`.
    ///
    /// The second point as it comes; then discovery in the lanes without a portal and refinement in the others: see
    /// [`mpr`](super::super::mpr).
    #[inline(always)]
    fn take(&mut self, simd: S, w: Vectors<S::F32>, slots: S::F32, doubt: S::F32) -> u32 {
        let seeking = !(self.found | self.second);
        let zero = S::F32::all(simd, 0.0);
        let across = self.v0.cross(w);
        let [v1, v2, v3] = self.corners;
        let [e1, e2, e3] = [v1.dot(across), v2.dot(across), v3.dot(across)];
        let stuck = self.found & !(w - v1).dot(self.direction).above(doubt);
        // Discovery: outside of the plane v0 v3 v1, of v0 v2 v3, or found.
        let outside31 = seeking & e1.above(zero);
        let outside23 = seeking & !outside31 & zero.above(e2);
        let just_found = seeking & !outside31 & !outside23;
        // Refinement: with the opposite signs, since it crosses the other way round.
        let leaves3 = self.found & zero.above(e1) & !zero.above(e2);
        let leaves1 = self.found & !leaves3 & zero.above(e2) & !zero.above(e3);
        let leaves2 = self.found & !leaves3 & !leaves1;
        let masks = [outside23 | leaves1, self.second | outside31 | leaves2, just_found | leaves3];
        self.corners = [v1.or(masks[0], w), v2.or(masks[1], w), v3.or(masks[2], w)];
        let [s1, s2, s3] = self.slots;
        self.slots = [s1.or(masks[0], slots), s2.or(masks[1], slots), s3.or(masks[2], slots)];
        self.found |= just_found;
        self.second = 0;
        stuck
    }

    /// Perpendicular to the plane of v0, v1, v2, on one side or the other; or outward from the portal.
    #[inline(always)]
    fn next_direction(&self) -> Vectors<S::F32> {
        let [v1, v2, v3] = self.corners;
        let from = self.v0.or(self.found, v1);
        (v1.or(self.found, v2) - from).cross(v2.or(self.found, v3) - from)
    }

    /// Where v2 has just come, turns v0, v1, v2 so that the direction is on the origin's side of their plane.
    #[inline(always)]
    fn face_origin(&mut self, simd: S, second: u32) {
        let away = second & self.direction.dot(self.v0).above(S::F32::all(simd, 0.0));
        self.direction = self.direction.or(away, Vectors::all(simd, 0.0) - self.direction);
        let [v1, v2, v3] = self.corners;
        self.corners = [v1.or(away, v2), v2.or(away, v1), v3];
        let [s1, s2, s3] = self.slots;
        self.slots = [s1.or(away, s2), s2.or(away, s1), s3];
    }

    /// The lanes whose portal lies beyond the origin, and those of them where that is proved.
    #[inline(always)]
    fn encloses_origin(&self, simd: S) -> (u32, u32) {
        let zero = S::F32::all(simd, 0.0);
        let [v1, v2, v3] = self.corners;
        let inside = self.found & self.direction.dot(v1).above(zero);
        if inside == 0 {
            return (0, 0);
        }
        let cubed = self.reach * self.reach * self.reach;
        let bound = cubed.times_plus(S::F32::all(simd, f32::ENCLOSING), S::F32::all(simd, f32::UNDERFLOW));
        let (c12, c23) = (v2.cross(v1), v3.cross(v2));
        let [e12, e23, e31] = [c12.dot(self.v0), c23.dot(self.v0), v1.cross(v3).dot(self.v0)];
        let determinant = zero - v1.dot(c23);
        let proved = e12.above(bound) & e23.above(bound) & e31.above(bound) & determinant.above(bound);
        (inside, inside & proved)
    }
}

/// The lanes of the mask filled from three columns.
#[inline(always)]
fn refilled<L: Lockstep>(
    v: Vectors<L>,
    mask: u32,
    columns: &[[f32; ROOM]; COLUMNS],
    column: usize,
    at: usize,
) -> Vectors<L> {
    Vectors {
        x: v.x.refilled(mask, &columns[column], at),
        y: v.y.refilled(mask, &columns[column + 1], at),
        z: v.z.refilled(mask, &columns[column + 2], at),
    }
}
