//! A packed specimen: what `pack` returns, `.json` holds and every other command reads.

use crate::aggregate::Aggregate;
use crate::packing::Report;
use crate::spec::Spec;

/// A packed specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// What was asked.
    pub spec: Spec,
    /// The aggregates in the specimen's frame, in descending volume; ids count from 0.
    pub aggregates: Vec<Aggregate>,
    /// What was reached.
    pub report: Report,
}

/// Where a long run says how far it is, and asks whether to go on.
pub trait Progress: Sync {
    /// The fraction reached so far, of the target. Return `false` to stop with the best packing found.
    fn update(&self, fraction: f64, target: f64) -> bool;
    /// Seconds since some fixed moment: the core itself reads no clock.
    fn seconds(&self) -> f64;
}

/// No progress, no clock, never stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn update(&self, _: f64, _: f64) -> bool {
        true
    }
    fn seconds(&self) -> f64 {
        0.0
    }
}

/// Takes and places the aggregates that `spec` asks for.
///
/// # Errors
/// A spec that cannot be met is named before any work starts.
pub fn pack(spec: &Spec, progress: &dyn Progress) -> Result<Model, crate::spec::SpecError> {
    let _ = (spec, progress);
    todo!("landed by the packing change")
}
