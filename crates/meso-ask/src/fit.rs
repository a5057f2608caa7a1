//! A fit of a mortar to a measured curve.

use crate::flags::of_schema::Flag;
use crate::given::{Given, Options};
use crate::{AskError, Over};
use meso_concrete::{OutOfRange, Ranges};
use meso_solve::LawName;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of a fit, beside the curve, the spec and the materials to start from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FitAsk {
    /// Number of packings, of successive seeds from the spec's on; their scatter is the uncertainty
    #[schemars(range(min = 1, max = 10_000))]
    pub seeds: u32,
    /// Most steps after the first five points; each tests every packing once
    pub steps: u32,
    /// Friction between plates and specimen
    pub friction: Option<f64>,
    /// Mean axial strain at the end [default: 1.15 times the last one of the curve]
    pub strain: Option<f64>,
    /// The law of mortar and ITZ [default: that of solve]
    pub law: Option<LawName>,
    /// Size of an element, mm [default: that of solve]
    pub element_size_mm: Option<f64>,
    /// Smallest distance between two aggregates, in every packing [default: the spec's; where it has none, as much as the mesh
    /// needs]
    pub min_gap_mm: Option<f64>,
    /// End every packing after S seconds with the best found; the results then depend on the machine
    pub time_limit_s: Option<f64>,
    /// Accept meshes that show a phase badly, as `solve` does
    pub accept_phase_error: bool,
}

/// Packings of a fit, unless a number is given.
const SEEDS: u32 = 3;
/// Most steps of a fit, unless a number is given.
const STEPS: u32 = 6;
/// Most packings.
const MOST_SEEDS: u32 = 10_000;

impl Default for FitAsk {
    fn default() -> Self {
        Self {
            seeds: SEEDS,
            steps: STEPS,
            friction: None,
            strain: None,
            law: None,
            element_size_mm: None,
            min_gap_mm: None,
            time_limit_s: None,
            accept_phase_error: false,
        }
    }
}

impl Options for FitAsk {
    const FLAGS: &'static [Flag] = &[
        Flag::common("seeds", "N").usually(SEEDS),
        Flag::common("steps", "N").usually(STEPS),
        Flag::common("friction", "MU"),
        Flag::common("strain", "E"),
        Flag::common("law", ""),
        Flag::common("element_size_mm", "H"),
        Flag::common("min_gap_mm", "MM"),
        Flag::common("time_limit_s", "S"),
        Flag::common("accept_phase_error", ""),
    ];
}

impl Given<FitAsk> {
    /// Refuses options that no curve can be fitted with.
    ///
    /// # Errors
    /// The option, its value and what would be accepted.
    pub fn accept(&self) -> Result<(), AskError> {
        let FitAsk { seeds, min_gap_mm, time_limit_s, .. } = self.options;
        Over { min_gap_mm, time_limit_s, ..Over::default() }.accept(self.giver())?;
        let accepted = format!("it must be a whole number from 1 to {MOST_SEEDS}");
        let wrong = |wrong: OutOfRange| AskError::Usage(self.refusal(&wrong));
        if self.options.law == Some(LawName::Elastic) {
            return Err(wrong(Ranges("fit").error(
                "law",
                "elastic",
                "it has no strength to fit; take meso, cdp or cdpm2",
            )));
        }
        Ranges("fit").require("seeds", seeds, (1..=MOST_SEEDS).contains(&seeds), accepted).map_err(wrong)
    }
}
