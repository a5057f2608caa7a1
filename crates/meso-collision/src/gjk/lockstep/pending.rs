//! The pairs that their bounds leave open, with what was found out about them.

use crate::math::Vec3;
use crate::simd::Lanes;

/// A list of pairs, column by column.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Pending {
    /// The direction to start from; the closeness, 2 or less where the ellipsoids overlap, the less the deeper, of which only
    /// ratios count. They have room for more than the list.
    columns: [Vec<f64>; 4],
    /// Index of the question; room, too.
    queries: Vec<u32>,
    len: usize,
}

impl Pending {
    pub(in super::super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Room for `n` pairs.
    pub(super) fn make_room(&mut self, n: usize) {
        self.queries.resize(n.max(self.queries.len()), 0);
        for column in self.columns.iter_mut().filter(|column| column.len() < n) {
            column.resize(n, 0.0);
        }
    }

    /// Adds the lanes of the mask; the question of lane 0 is the `first`.
    ///
    /// Without a branch for each: nobody could foretell them.
    #[inline(always)]
    pub(super) fn add<L: Lanes<T = f64>>(&mut self, mask: u32, first: usize, rows: [L; 4]) {
        let at = self.len;
        for (column, numbers) in self.columns.iter_mut().zip(rows) {
            numbers.front(mask).store(column, at);
        }
        let queries = &mut self.queries[at..at + L::LANES];
        let mut taken = 0;
        for l in 0..L::LANES {
            queries[taken] = (first + l) as u32;
            taken += (mask >> l & 1) as usize;
        }
        self.len = at + taken;
    }

    /// The direction to start from.
    #[inline(always)]
    pub(in super::super) fn direction(&self, i: u32) -> Vec3 {
        let [x, y, z, ..] = &self.columns;
        Vec3::new(x[i as usize], y[i as usize], z[i as usize])
    }

    pub(in super::super) fn len(&self) -> usize {
        self.len
    }

    /// The index of the question of entry `i`.
    #[inline(always)]
    pub(in super::super) fn query(&self, i: u32) -> u32 {
        self.queries[i as usize]
    }

    /// The second entry if its bodies are closer than those of the first, else the first.
    #[inline(always)]
    pub(in super::super) fn closer(&self, first: u32, second: u32) -> u32 {
        let closeness = &self.columns[3];
        if closeness[second as usize] < closeness[first as usize] { second } else { first }
    }
}
