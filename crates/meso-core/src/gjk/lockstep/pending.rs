//! The pairs that their bounds leave open, with what was found out about them.

use crate::math::Vec3;

/// A list of pairs, column by column.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Pending {
    /// The direction to start from, then the closeness. They have room for more than the list.
    pub(super) columns: [Vec<f64>; 4],
    /// Index of the question.
    queries: Vec<u32>,
}

impl Pending {
    pub(in super::super) fn clear(&mut self) {
        self.queries.clear();
    }

    /// Room for `n` pairs.
    pub(super) fn make_room(&mut self, n: usize) {
        self.queries.reserve(n);
        for column in self.columns.iter_mut().filter(|column| column.len() < n) {
            column.resize(n, 0.0);
        }
    }

    /// Adds a question whose columns are filled in.
    #[inline(always)]
    pub(super) fn add(&mut self, query: u32) {
        self.queries.push(query);
    }

    /// The direction to start from.
    #[inline(always)]
    pub(in super::super) fn direction(&self, i: usize) -> Vec3 {
        Vec3::new(self.columns[0][i], self.columns[1][i], self.columns[2][i])
    }

    pub(in super::super) fn len(&self) -> usize {
        self.queries.len()
    }

    /// The index of each open question, in their order.
    pub(in super::super) fn queries(&self) -> &[u32] {
        &self.queries
    }

    /// How close the bodies of entry `i` are: 2 or less where the ellipsoids overlap, the less the deeper. Only ratios count.
    pub(in super::super) fn closeness(&self, i: usize) -> f64 {
        self.columns[3][i]
    }
}
