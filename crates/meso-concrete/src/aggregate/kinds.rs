//! Aggregates of several kinds in one packing: which grain is of which phase.

use super::grading::SizeClass;
use super::grain::{Grain, Kind};
use serde::{Deserialize, Serialize};

/// A phase that some of the aggregates have instead of the phase `aggregate`: an entry of `[[phases]]` in a spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OwnPhase {
    /// Name of the phase, which its values have in `[materials]`: lower-case letters, digits and `_`.
    pub name: String,
    /// Volume of its aggregates over that of all aggregates in its classes, above 0 to 1.
    pub share: f64,
    /// Smallest and largest size of its classes, mm, both of them limits in `grading.classes_mm`; absent, all classes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sizes_mm: Option<[f64; 2]>,
}

impl OwnPhase {
    /// Share of the aggregates in `class` that have this phase.
    pub fn share_of(&self, class: &SizeClass) -> f64 {
        let has = |[low, high]: [f64; 2]| low <= class.d_min_mm && class.d_max_mm <= high;
        if self.sizes_mm.is_none_or(has) { self.share } else { 0.0 }
    }

    /// Shares of the aggregates in `class` that have each of the `phases`; the last is the phase `aggregate`, which has the rest.
    pub fn shares(phases: &[Self], class: &SizeClass) -> Vec<f64> {
        let own: Vec<f64> = phases.iter().map(|phase| phase.share_of(class)).collect();
        let rest = 1.0 - own.iter().sum::<f64>();
        own.into_iter().chain([if rest > SHARE_ROUNDING { rest } else { 0.0 }]).collect()
    }
}

/// Gives each aggregate the phase whose volume lags farthest behind its share, class by class from the coarsest. The grains of a
/// class come in descending volume, so that a class ends within its smallest grains of its shares; what it lacks is left
/// to the next one.
pub(super) fn divide(grains: &mut [Grain], phases: &[OwnPhase], classes: &[SizeClass]) {
    if phases.is_empty() {
        return;
    }
    let mut lag = vec![0.0; phases.len() + 1];
    for (number, class) in classes.iter().enumerate().rev() {
        let (shares, number) = (OwnPhase::shares(phases, class), number as u16);
        for grain in grains.iter_mut().filter(|grain| grain.kind == Kind::Aggregate && grain.class == number) {
            let volume = grain.volume();
            lag.iter_mut().zip(&shares).for_each(|(lag, share)| *lag += share * volume);
            let asked = (0..lag.len()).filter(|&phase| shares[phase] > 0.0);
            let Some(most) = asked.max_by(|&p, &q| lag[p].total_cmp(&lag[q]).then(q.cmp(&p))) else { continue };
            lag[most] -= volume;
            grain.own = (most < phases.len()).then_some(most as u8);
        }
    }
}

/// Most by which the sum of shares that make a whole may differ from 1.
pub const SHARE_ROUNDING: f64 = 1e-9;
