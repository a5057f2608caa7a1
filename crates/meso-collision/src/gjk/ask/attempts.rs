//! Attempts on their way through the stages: the pair that seems closest before the others.
//!
//! How many pairs an attempt has, and how many of these are open, no processor foretells. So whatever is done for every
//! attempt takes the same steps for each.

use crate::gjk::search::lockstep::Pending;
use std::ops::Range;

/// The attempts of a batch that are open.
#[derive(Default)]
pub(crate) struct Attempts {
    /// How many questions are [`OPEN`], and how many [`OVERLAP`], before each question and before the end.
    before: Vec<u64>,
    /// Has room for all attempts.
    open: Vec<Attempt>,
}

#[derive(Clone, Default)]
struct Attempt {
    number: u32,
    /// Entries of `pending`: at least one.
    entries: Range<u32>,
    /// The one that seems closest.
    closest: u32,
}

/// The two counts of a sum.
const OPEN: u64 = 1;
const OVERLAP: u64 = 1 << 32;

/// Counts added by a pair that is apart, that overlaps, that is open: by a table, since the compiler would branch.
static COUNTS: [u64; 3] = [0, OVERLAP, OPEN];

/// Entries that are compared without a branch: few attempts have more that are open.
const UNROLLED: u32 = 4;

impl Attempts {
    /// Takes up the attempts that `answers` leaves open; returns whether each has had no overlap so far.
    pub(crate) fn begin(&mut self, ends: &[u32], answers: &[Option<bool>]) -> Vec<bool> {
        self.count(answers);
        self.open.resize(ends.len(), Attempt::default());
        let (mut len, mut start) = (0, self.before[0]);
        let begin = |(number, &end): (usize, &u32)| {
            let (from, to) = (start, self.before[end as usize]);
            let clear = to - from < OVERLAP;
            self.open[len] = Attempt { number: number as u32, entries: from as u32..to as u32, closest: from as u32 };
            len += usize::from(clear & (to > from));
            start = to;
            clear
        };
        let clear = ends.iter().enumerate().map(begin).collect();
        self.open.truncate(len);
        clear
    }

    fn count(&mut self, answers: &[Option<bool>]) {
        let mut count = 0;
        self.before.clear();
        self.before.extend(answers.iter().map(|answer| {
            let before = count;
            count += COUNTS[answer.map_or(2, usize::from)];
            before
        }));
        self.before.push(count);
    }

    /// The entry of every open attempt that seems closest.
    pub(crate) fn choose_closest(&mut self, pending: &Pending, chosen: &mut Vec<u32>) {
        for Attempt { entries, closest, .. } in &mut self.open {
            let last = entries.end - 1;
            let mut least = (pending.closeness(*closest), *closest);
            let mut compare = |entry| {
                let closeness = pending.closeness(entry);
                least = if closeness < least.0 { (closeness, entry) } else { least };
            };
            (1..UNROLLED).for_each(|k| compare(last.min(entries.start + k)));
            (entries.start + UNROLLED..entries.end).for_each(compare);
            *closest = least.1;
        }
        chosen.extend(self.open.iter().map(|attempt| attempt.closest));
    }

    /// All other entries of the attempts whose closest pair is apart.
    pub(crate) fn choose_rest(
        &mut self,
        pending: &Pending,
        answers: &[Option<bool>],
        chosen: &mut Vec<u32>,
        clear: &mut [bool],
    ) {
        self.open.retain(|Attempt { number, entries, closest }| {
            let apart = answers[pending.query(*closest) as usize] == Some(false);
            clear[*number as usize] = apart;
            apart & (entries.len() > 1)
        });
        for Attempt { entries, closest, .. } in &self.open {
            chosen.extend(entries.clone().filter(|entry| entry != closest));
        }
    }

    /// The outcome of the attempts whose other entries are answered, too.
    pub(crate) fn end(&self, pending: &Pending, answers: &[Option<bool>], clear: &mut [bool]) {
        for Attempt { number, entries, .. } in &self.open {
            clear[*number as usize] =
                entries.clone().all(|entry| answers[pending.query(entry) as usize] == Some(false));
        }
    }
}
