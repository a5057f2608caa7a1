//! The driver of all improvement: from the poor cells on, round by round, within a budget.

use rayon::prelude::*;

/// Someone who improves a mesh.
pub(in crate::mesh) trait Improver: Sync {
    /// Whether a cell falls short of what is wanted.
    fn is_poor(&self, cell: u32) -> bool;

    /// Works on `poor` cells, ascending; the cells that this may have changed.
    fn round(&mut self, poor: &[u32]) -> Vec<u32>;
}

/// Works on the poor ones of `suspects` and of what changes around them, until none is left or `rounds` are over; the cells
/// that changed last.
///
/// Cells are taken by their numbers, not by their quality: neighbours then follow each other, and the result does not hang on
/// ties.
pub(in crate::mesh) fn improve(improver: &mut impl Improver, mut suspects: Vec<u32>, rounds: usize) -> Vec<u32> {
    for _ in 0..rounds {
        let poor: Vec<u32> = suspects.into_par_iter().filter(|&cell| improver.is_poor(cell)).collect();
        if poor.is_empty() {
            return poor;
        }
        suspects = ascending(improver.round(&poor));
    }
    suspects
}

/// Numbers sorted, each once.
pub(in crate::mesh) fn ascending(numbers: impl IntoIterator<Item = u32>) -> Vec<u32> {
    let mut numbers: Vec<u32> = numbers.into_iter().collect();
    numbers.par_sort_unstable();
    numbers.dedup();
    numbers
}
