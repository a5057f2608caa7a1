//! The questions of a search in lockstep, and the notes of its answers.

use super::pending::Pending;
use crate::gjk::ask::pair_query::PairQuery;
use crate::gjk::search::mpr::Portal;
use crate::simd::{Lanes, MOST_LANES};

/// Registers of pairs in flight: one fills the waiting time of another.
pub(super) const RANKS: usize = 2;

/// A pair that the search left open.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Undecided {
    /// Its question.
    pub(crate) query: u32,
    /// The portal it came to.
    pub(crate) portal: Option<Portal>,
}

/// Answers the chosen entries of `pending`; those it cannot are listed.
pub(crate) struct Search<'a, 'q> {
    pub(crate) queries: &'a [PairQuery<'q>],
    pub(crate) gap: f64,
    pub(crate) pending: &'a Pending,
    pub(crate) chosen: &'a [u32],
    pub(crate) notes: &'a mut Notes,
    pub(crate) answers: &'a mut [Option<bool>],
    pub(crate) undecided: &'a mut Vec<Undecided>,
}

impl Search<'_, '_> {
    /// The entries that lockstep does not take.
    pub(super) fn give_up(&mut self, entries: &[u32]) {
        let undecided = entries.iter().map(|&entry| Undecided { query: self.pending.query(entry), portal: None });
        self.undecided.extend(undecided);
    }
}

/// Questions that were answered or left open, on their way to where they belong.
///
/// Noted a register at a time: nobody could foretell a branch for each.
#[derive(Default)]
pub(crate) struct Notes {
    pub(super) apart: List<1>,
    pub(super) overlap: List<1>,
    /// Left open, with the slots of a portal that lies beyond the origin, seen from v0; and of one that lies before it.
    pub(super) beyond: List<4>,
    pub(super) before: List<4>,
}

impl Notes {
    /// Room for a register of fresh pairs, and for all lanes in flight.
    pub(super) fn have_room(&self) -> bool {
        let longest = self.apart.len.max(self.overlap.len).max(self.beyond.len + self.before.len);
        longest + (RANKS + 1) * MOST_LANES <= NOTES
    }

    pub(super) fn clear(&mut self) {
        (self.apart.len, self.overlap.len, self.beyond.len, self.before.len) = (0, 0, 0, 0);
    }
}

/// Room for questions.
const NOTES: usize = 8 * MOST_LANES;

/// Rows of bits that stand in f32; the first number is the question.
#[repr(align(64))]
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

    pub(super) fn questions(&self) -> impl Iterator<Item = usize> + '_ {
        self.columns[0][..self.len].iter().map(|question| question.to_bits() as usize)
    }
}
