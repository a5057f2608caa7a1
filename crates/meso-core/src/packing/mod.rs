//! The *place*: aggregates into a specimen, without overlap, with a report of what was reached.

mod report;
mod specimen;

pub use report::{ClassReport, Report, Seconds, SpecimenReport, StopReason, Work};
pub use specimen::Specimen;

use serde::{Deserialize, Serialize};

/// How aggregates are placed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Placement {
    /// Which strategy places.
    pub strategy: Strategy,
    /// Random positions tried per aggregate; absent: up to [`DEFAULT_ATTEMPTS`].
    pub attempts: Option<u32>,
    /// Volume generated beyond the target, as a share of it (the paper's 2 to 3 %).
    pub surplus: f64,
    /// Smallest distance between two aggregates, mm; 0 means: proved apart.
    pub min_gap_mm: f64,
    /// Smallest distance between an aggregate and the specimen's surface, mm.
    pub wall_gap_mm: f64,
    /// Stop after so many seconds with the best packing found.
    pub time_limit_s: Option<f64>,
}

/// Attempts per aggregate where the spec does not say: beyond it, an aggregate is given up.
pub const DEFAULT_ATTEMPTS: u32 = 50_000;

/// The placement strategies, siblings behind one interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// The one that reaches the target.
    Auto,
    /// The paper's: random positions, largest first (Sec. 2.2).
    TakeAndPlace,
    /// All aggregates at once, moved until none overlap.
    Rearrange,
}

impl Default for Placement {
    fn default() -> Self {
        Self {
            strategy: Strategy::Auto,
            attempts: None,
            surplus: 0.025,
            min_gap_mm: 0.0,
            wall_gap_mm: 0.0,
            time_limit_s: None,
        }
    }
}
