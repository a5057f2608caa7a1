//! The pairs that their bounds leave open, with their first directions and closeness.

use crate::math::Vec3;
use crate::simd::{Lanes, Row, Simd};

/// A list of pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Pending {
    /// The direction to start from; the displacement of A seen from B; the closeness, 2 or less where the ellipsoids
    /// overlap, the less the deeper, of which only ratios count; the index of the question, as bits. They have room for
    /// more than the list.
    rows: Vec<Row>,
    len: usize,
}

impl Pending {
    pub(crate) fn clear(&mut self) {
        self.len = 0;
    }

    /// Room for `n` pairs.
    pub(super) fn make_room(&mut self, n: usize) {
        self.rows.resize(n.max(self.rows.len()), Row::default());
    }

    /// Adds the lanes of the mask; the question of lane 0 is the `first`.
    ///
    /// Without a branch for each: nobody could foretell them.
    #[inline(always)]
    pub(super) fn add<S: Simd>(&mut self, simd: S, mask: u32, first: usize, columns: [S::F64; 7]) {
        let rows = &mut self.rows[self.len..self.len + S::F64::LANES];
        self.len += simd.store_rows(columns, first as u32, mask, rows);
    }

    /// Direction, displacement of A, closeness and question.
    #[inline(always)]
    pub(super) fn row(&self, i: u32) -> &[f32; 8] {
        &self.rows[i as usize].0
    }

    /// The direction to start from.
    #[inline(always)]
    pub(crate) fn direction(&self, i: u32) -> Vec3 {
        let [x, y, z, ..] = self.rows[i as usize].0.map(f64::from);
        Vec3::new(x, y, z)
    }

    pub(crate) fn len(&self) -> usize {
        self.len
    }

    /// The index of the question of entry `i`.
    #[inline(always)]
    pub(crate) fn query(&self, i: u32) -> u32 {
        self.rows[i as usize].0[7].to_bits()
    }

    /// The closeness of entry `i`, of which only ratios count.
    #[inline(always)]
    pub(crate) fn closeness(&self, i: u32) -> f32 {
        self.rows[i as usize].0[6]
    }
}
