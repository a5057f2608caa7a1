//! What a packing run reached, and what it cost.

use serde::{Deserialize, Serialize};

/// The figures of one run: the keys of `--summary-json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Version of mesocrete.
    pub version: String,
    /// Seed of the run.
    pub seed: u64,
    /// Asked volume fraction of the aggregates, 0 to 1.
    pub target_fraction: f64,
    /// Reached volume fraction.
    pub fraction: f64,
    /// Aggregates placed.
    pub aggregates: usize,
    /// Aggregates taken but not placed.
    pub discarded: usize,
    /// What was filled.
    pub specimen: SpecimenReport,
    /// The curve behind the classes, e.g. `fuller, normalised, n = 0.5`.
    pub grading: String,
    /// The strategy that placed.
    pub strategy: String,
    /// Per size class, from the finest.
    pub classes: Vec<ClassReport>,
    /// Aggregates whose drawn ITZ was thinner than asked by the documented limit, by id.
    pub itz_limited: Vec<u32>,
    /// Why it ended.
    pub stop_reason: StopReason,
    /// The same in a sentence: which class or fraction fell short, and by how much.
    pub stop_detail: String,
    /// Wall-clock seconds by stage; zero in a loaded model.
    #[serde(default)]
    pub seconds: Seconds,
    /// How much each stage saw.
    #[serde(default)]
    pub work: Work,
}

/// Kind and volume of the specimen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpecimenReport {
    /// As in the spec.
    pub kind: String,
    /// mm3.
    pub volume_mm3: f64,
}

/// Asked and reached volume of one class, over the specimen's volume.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClassReport {
    /// Lower limit, mm.
    pub d_min_mm: f64,
    /// Upper limit, mm.
    pub d_max_mm: f64,
    /// Asked.
    pub target_fraction: f64,
    /// Reached.
    pub fraction: f64,
    /// Number of aggregates.
    pub aggregates: usize,
}

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    /// Fraction and grading as asked.
    TargetReached,
    /// Aggregates found no place within their attempts.
    AttemptsExhausted,
    /// The rearrangement stopped falling.
    Jammed,
    /// `--time-limit` came first.
    TimeLimit,
    /// The user stopped it.
    Interrupted,
}

/// Wall-clock seconds by stage. The core reads no clock: its callers fill these in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Seconds {
    /// All of it.
    pub total: f64,
    /// Making the aggregates.
    pub take: f64,
    /// Placing them.
    pub place: f64,
    /// Writing files.
    pub write: f64,
}

/// How many candidates or pairs each stage saw; a pair a stage decides goes no further.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Work {
    /// Candidate positions tried.
    pub candidates: u64,
    /// Pairs the broad phase named.
    pub pairs_broad: u64,
    /// Pairs left after the bounding spheres.
    pub pairs_sphere: u64,
    /// Pairs left after the ellipsoid axis.
    pub pairs_axis: u64,
    /// Pairs put to GJK.
    pub gjk_calls: u64,
    /// Pairs put to exact arithmetic.
    pub exact_calls: u64,
    /// Sweeps of the rearrangement.
    pub sweeps: u64,
}
