//! The concrete that benches of tests mesh: 40 % of 5 to 16 mm, with gaps that the elements resolve.

use meso_core::specimen::Specimen;
use meso_core::{Model, Silent, Spec, pack};

/// A packed cube and the size of its elements, mm: as the command line gives them, 50 and 2 mm, or less with `--quick`.
pub(crate) fn asked(is_quick: bool) -> (Model, f64) {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with("--")).collect();
    let word = |i: usize, usual: f64| words.get(i).map_or(usual, |word| word.parse().expect("a number"));
    let (side, size) = if is_quick { (24.0, 4.0) } else { (word(0, 50.0), word(1, 2.0)) };
    let mut spec = Spec { fraction: 0.4, specimen: Specimen::cube(side), ..Spec::default() };
    spec.grading.d_max_mm = 16.0;
    spec.grading.classes_mm = vec![5.0, 10.0, 16.0];
    spec.placement.min_gap_mm = 1.0;
    (pack(&spec, &Silent).expect("a packing"), size)
}
