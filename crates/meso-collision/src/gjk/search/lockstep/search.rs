//! Many pairs at a time through the portal search, in f32.
//!
//! Runs the steps of [`mpr`](crate::gjk::search::mpr), lane by lane. The first support decides most pairs that are
//! apart: it is taken of a register of fresh pairs at a time. The others queue; whenever a lane's pair is decided, the
//! next one takes its place, so that no lane idles. Single precision proves most pairs; most others are proved in f64
//! from the portal it came to, again a register at a time; the rest is left to the single query.

use super::open::Open;
use super::queue::Queue;
use super::rank::Rank;
use super::task::{RANKS, Search};
use super::vectors::narrow_lanes;
use crate::simd::{Simd, Vectorized};

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
