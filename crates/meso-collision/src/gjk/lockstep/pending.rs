//! The pairs that their bounds leave open, with what was found out about them.

use crate::math::Vec3;

/// A list of pairs, column by column.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Pending {
    /// The direction to start from, then the closeness. They have room for more than the list.
    pub(super) columns: [Vec<f64>; 4],
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

    /// Adds the questions of the mask's lanes, whose columns are filled in; that of lane 0 is the `first`.
    ///
    /// Without a branch for each: nobody could foretell them.
    #[inline(always)]
    pub(super) fn add(&mut self, mask: u32, first: usize, lanes: usize) {
        for l in 0..lanes {
            self.queries[self.len] = (first + l) as u32;
            self.len += (mask >> l & 1) as usize;
        }
    }

    /// The direction to start from.
    #[inline(always)]
    pub(in super::super) fn direction(&self, i: usize) -> Vec3 {
        Vec3::new(self.columns[0][i], self.columns[1][i], self.columns[2][i])
    }

    pub(in super::super) fn len(&self) -> usize {
        self.len
    }

    /// The index of each open question, in their order.
    pub(in super::super) fn queries(&self) -> &[u32] {
        &self.queries[..self.len]
    }

    /// How close the bodies of entry `i` are: 2 or less where the ellipsoids overlap, the less the deeper. Only ratios count.
    pub(in super::super) fn closeness(&self, i: usize) -> f64 {
        self.columns[3][i]
    }
}
