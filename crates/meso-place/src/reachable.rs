//! The fraction that each strategy has been measured to reach, so that a user learns of a hopeless target before the
//! work.
//!
//! Measured in the paper's specimen (150 mm cube, Fuller 5 to 20 mm, n = 0.5), seeds 1 to 5. A narrower grading, a
//! wider gap or a narrower specimen reaches less.

use super::{DEFAULT_ATTEMPTS, Placement, Strategy};

/// (attempts per grain, fraction): take-and-place gains about 0.04 from ten times the attempts.
const TAKE_AND_PLACE: [(u32, f64); 4] = [(100, 0.42), (1000, 0.47), (10_000, 0.50), (100_000, 0.52)];
/// Rearrangement with the slowest damping that pays; 0.72 in a periodic box.
const REARRANGE: f64 = 0.70;

impl Placement {
    /// The fraction that a brief take-and-place reaches.
    pub(super) fn brief_reach() -> f64 {
        TAKE_AND_PLACE[0].1
    }

    /// The largest fraction that the chosen strategy has been measured to reach.
    pub fn reach(&self) -> f64 {
        if self.chosen() == Strategy::Rearrange {
            return REARRANGE;
        }
        let attempts = self.attempts.unwrap_or(DEFAULT_ATTEMPTS);
        let row = TAKE_AND_PLACE.iter().find(|row| attempts <= row.0);
        row.unwrap_or(&TAKE_AND_PLACE[TAKE_AND_PLACE.len() - 1]).1
    }
}
