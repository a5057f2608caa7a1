//! Why effective properties are refused.

use meso_concrete::OutOfRange;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::specimen::Specimen;

/// An error of the options, the values or the specimen.
#[derive(Debug, thiserror::Error)]
pub enum EffectiveError {
    /// A value outside its range.
    #[error(transparent)]
    Value(#[from] OutOfRange),
    /// A specimen that is no box.
    #[error("specimen.kind is {0}; effective properties need a cube, a box or a prism")]
    Specimen(&'static str),
    /// A body whose layers no planes bound.
    #[error(
        "aggregate {0} has dents; effective properties need convex aggregates: shape.hull = true packs their hulls"
    )]
    Dents(u32),
    /// The iterations did not reach the accuracy.
    #[error("after {iterations} iterations the error of the equations is still {reached:.1e} of the result; {fix}")]
    Diverged {
        /// Iterations done.
        iterations: usize,
        /// Error reached, over the result.
        reached: f64,
        /// Remedy.
        fix: &'static str,
    },
}

/// Refuses bodies and specimens that no effective property can be computed for.
///
/// # Errors
/// A body with dents, and a specimen that is no box.
pub(crate) fn accepts(bodies: &[Aggregate], specimen: &Specimen) -> Result<(), EffectiveError> {
    if let Some(body) = bodies.iter().find(|body| !body.body.is_convex()) {
        return Err(EffectiveError::Dents(body.id));
    }
    if specimen.container().is_box() { Ok(()) } else { Err(EffectiveError::Specimen(specimen.kind())) }
}
