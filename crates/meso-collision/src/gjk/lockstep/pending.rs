//! The pairs that their bounds leave open, with what was found out about them.

use crate::math::Vec3;
use crate::simd::Lanes;

/// A list of pairs, column by column.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Pending {
    /// The direction to start from; the closeness, 2 or less where the ellipsoids overlap, the less the deeper, of which only
    /// ratios count; the index of the question, as bits. They have room for more than the list.
    columns: [Vec<f64>; 5],
    len: usize,
}

impl Pending {
    pub(in super::super) fn clear(&mut self) {
        self.len = 0;
    }

    /// Room for `n` pairs.
    pub(super) fn make_room(&mut self, n: usize) {
        for column in self.columns.iter_mut().filter(|column| column.len() < n) {
            column.resize(n, 0.0);
        }
    }

    /// Adds the lanes of the mask.
    #[inline(always)]
    pub(super) fn add<L: Lanes<T = f64>>(&mut self, mask: u32, rows: [L; 5]) {
        let at = self.len;
        for (column, numbers) in self.columns.iter_mut().zip(rows) {
            numbers.front(mask).store(column, at);
        }
        self.len = at + mask.count_ones() as usize;
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
        self.columns[4][i as usize].to_bits() as u32
    }

    /// The second entry if its bodies are closer than those of the first, else the first.
    #[inline(always)]
    pub(in super::super) fn closer(&self, first: u32, second: u32) -> u32 {
        let closeness = &self.columns[3];
        if closeness[second as usize] < closeness[first as usize] { second } else { first }
    }
}
