//! The serde view of every option: what a SPEC.toml may say.

use crate::aggregate::{Grading, Itz, Shape};
use crate::packing::{Placement, Specimen};
use serde::{Deserialize, Serialize};

/// Everything that decides a model, with the paper's specimen as default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Spec {
    /// Seed of all randomness.
    pub seed: u64,
    /// Volume of the aggregates over the specimen's, 0 to 1.
    pub fraction: f64,
    /// What is filled.
    pub specimen: Specimen,
    /// Sizes.
    pub grading: Grading,
    /// Shapes.
    pub shape: Shape,
    /// Interfacial transition zone.
    pub itz: Itz,
    /// Placement.
    pub placement: Placement,
}

impl Default for Spec {
    fn default() -> Self {
        Self {
            seed: 1,
            fraction: 0.5,
            specimen: Specimen::default(),
            grading: Grading::default(),
            shape: Shape::default(),
            itz: Itz::default(),
            placement: Placement::default(),
        }
    }
}

/// A spec that cannot be: what, where, and the way out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key}: {message}")]
pub struct SpecError {
    /// Dotted path of the key, e.g. `grading.d_min_mm`.
    pub key: String,
    /// The value, what is wrong with it and the accepted range.
    pub message: String,
}
