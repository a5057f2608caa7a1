//! The pairs that their headers leave open, with what was found out about them.

use crate::math::Vec3;

/// A list of pairs, column by column.
#[derive(Clone, Debug, Default)]
pub(crate) struct Open {
    /// The direction to start from, then the closeness. They have room for more than the list.
    pub(super) columns: [Vec<f64>; 4],
    /// Index of the question.
    asks: Vec<u32>,
}

impl Open {
    pub(crate) fn clear(&mut self) {
        self.asks.clear();
    }

    /// Room for `n` pairs.
    pub(super) fn make_room(&mut self, n: usize) {
        self.asks.reserve(n);
        for column in self.columns.iter_mut().filter(|column| column.len() < n) {
            column.resize(n, 0.0);
        }
    }

    /// Adds a question.
    pub(crate) fn push(&mut self, ask: u32, v: &Vec3, closeness: f64) {
        let end = self.len();
        self.make_room(end + 1);
        for (column, value) in self.columns.iter_mut().zip([v.x, v.y, v.z, closeness]) {
            column[end] = value;
        }
        self.add(ask);
    }

    /// Adds a question whose columns are filled in.
    #[inline(always)]
    pub(super) fn add(&mut self, ask: u32) {
        self.asks.push(ask);
    }

    /// The direction to start from.
    pub(crate) fn direction(&self, i: usize) -> Vec3 {
        Vec3::new(self.columns[0][i], self.columns[1][i], self.columns[2][i])
    }

    pub(crate) fn len(&self) -> usize {
        self.asks.len()
    }

    /// The index of each open question, in their order.
    pub(crate) fn asks(&self) -> &[u32] {
        &self.asks
    }

    /// How close the bodies of entry `i` are: 2 or less where the ellipsoids overlap, the less the deeper. Only ratios count.
    pub(crate) fn closeness(&self, i: usize) -> f64 {
        self.columns[3][i]
    }
}
