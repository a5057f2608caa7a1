//! Many pairs at a time through the portal search, in f32.
//!
//! The same steps as [`mpr`](super::super::mpr), lane by lane. The first support decides most pairs that are apart: it is
//! taken of a register of fresh pairs at a time. The others queue; whenever a lane's pair is decided, the next one takes its
//! place, so that no lane idles. Single precision proves what it can; most of what it cannot is proved in f64 from the portal
//! it came to, again a register at a time; the rest is left to the single query.

use super::super::mpr::Portal;
use super::super::pair_query::PairQuery;
use super::open::Open;
use super::pending::Pending;
use super::queue::Queue;
use super::rank::Rank;
use super::vectors::narrow_lanes;
use crate::simd::{Lanes, MOST_LANES, Simd, Vectorized};

/// Registers of pairs in flight: what one waits for, another fills.
pub(super) const RANKS: usize = 2;

/// A pair that the search left open.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Undecided {
    /// Its question.
    pub(in super::super) query: u32,
    /// The portal it came to.
    pub(in super::super) portal: Option<Portal>,
}

/// Answers the chosen entries of `pending`; those it cannot are listed.
pub(in super::super) struct Search<'a, 'q> {
    pub(in super::super) queries: &'a [PairQuery<'q>],
    pub(in super::super) gap: f64,
    pub(in super::super) pending: &'a Pending,
    pub(in super::super) chosen: &'a [u32],
    pub(in super::super) notes: &'a mut Notes,
    pub(in super::super) answers: &'a mut [Option<bool>],
    pub(in super::super) undecided: &'a mut Vec<Undecided>,
}

impl Vectorized for Search<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        // Not compiled where it does not pay. Nobody comes here then, unless another thread has just chosen such a set.
        if !S::LOCKSTEP_PAYS {
            self.give_up(self.chosen);
            return;
        }
        let mut queue = Queue::new();
        let mut ranks = [Rank::idle(simd), Rank::idle(simd)];
        let mut fresh = self.chosen.chunks(narrow_lanes::<S>());
        loop {
            while queue.len() < RANKS * narrow_lanes::<S>()
                && self.notes.have_room()
                && let Some(entries) = fresh.next()
            {
                queue.admit(simd, &mut self, entries);
            }
            let mut busy = false;
            for rank in &mut ranks {
                rank.refill(simd, &mut queue, self.queries);
                busy |= rank.is_busy();
                if rank.is_busy() {
                    rank.step(simd, &mut self);
                }
            }
            let over = !busy && fresh.len() == 0;
            if over || !self.notes.have_room() {
                self.enter_notes(simd);
            }
            if over {
                return;
            }
        }
    }
}

impl Search<'_, '_> {
    /// The entries that lockstep does not take.
    pub(super) fn give_up(&mut self, entries: &[u32]) {
        let queries = self.pending.queries();
        self.undecided.extend(entries.iter().map(|&entry| Undecided { query: queries[entry as usize], portal: None }));
    }

    /// Gives the answers that were noted, and asks for those of the open pairs in f64.
    #[inline(always)]
    fn enter_notes<S: Simd>(&mut self, simd: S) {
        let Self { queries, gap, notes, answers, undecided, .. } = self;
        notes.apart.questions().for_each(|query| answers[query] = Some(false));
        notes.overlap.questions().for_each(|query| answers[query] = Some(true));
        let mut open = Open { queries, gap: *gap, answers, undecided };
        open.enclose(simd, &notes.beyond, &mut notes.before);
        open.separate(simd, &notes.before);
        notes.clear();
    }
}

/// Questions that were answered or left open, on their way to where they belong.
///
/// Noted a register at a time: nobody could foretell a branch for each.
#[derive(Default)]
pub(in super::super) struct Notes {
    pub(super) apart: List<1>,
    pub(super) overlap: List<1>,
    /// Left open, with the slots of a portal that lies beyond the origin, seen from v0; and of one that lies before it.
    pub(super) beyond: List<4>,
    pub(super) before: List<4>,
}

impl Notes {
    /// Room for a register of fresh pairs, and for all lanes in flight.
    fn have_room(&self) -> bool {
        let longest = self.apart.len.max(self.overlap.len).max(self.beyond.len + self.before.len);
        longest + (RANKS + 1) * MOST_LANES <= NOTES
    }

    fn clear(&mut self) {
        (self.apart.len, self.overlap.len, self.beyond.len, self.before.len) = (0, 0, 0, 0);
    }
}

/// Room for questions.
const NOTES: usize = 8 * MOST_LANES;

/// Rows of bits that stand in f32; the first number is the question.
pub(super) struct List<const N: usize> {
    columns: [[f32; NOTES]; N],
    len: usize,
}

impl<const N: usize> Default for List<N> {
    fn default() -> Self {
        Self { columns: [[0.0; NOTES]; N], len: 0 }
    }
}

impl<const N: usize> List<N> {
    /// Adds the rows of the lanes of the mask.
    #[inline(always)]
    pub(super) fn add<L: Lanes<T = f32>>(&mut self, rows: [L; N], mask: u32) {
        let at = self.len;
        assert!(at <= NOTES - MOST_LANES, "see `have_room`");
        for (column, numbers) in self.columns.iter_mut().zip(rows) {
            numbers.front(mask).store(column, at);
        }
        self.len += mask.count_ones() as usize;
    }

    /// Adds a row.
    pub(super) fn push(&mut self, row: [f32; N]) {
        self.columns.iter_mut().zip(row).for_each(|(column, number)| column[self.len] = number);
        self.len += 1;
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The numbers of row `i`.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> [f32; N] {
        self.columns.each_ref().map(|column| column[i])
    }

    fn questions(&self) -> impl Iterator<Item = usize> + '_ {
        self.columns[0][..self.len].iter().map(|question| question.to_bits() as usize)
    }
}
