//! Why effective properties are refused.

use meso_concrete::OutOfRange;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::specimen::Specimen;
use std::borrow::Cow;

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

/// The bodies with facets: balls and ellipsoids become polyhedra of their volume.
fn faceted(bodies: Cow<'_, [Aggregate]>) -> Cow<'_, [Aggregate]> {
    if bodies.iter().all(|body| body.body.round().is_none()) {
        return bodies;
    }
    let facets = |body: &Aggregate| Aggregate { body: body.body.faceted().into_owned(), ..body.clone() };
    bodies.iter().map(facets).collect()
}

/// The bodies as properties are computed for them; refuses those, and specimens, that none can be computed for.
///
/// # Errors
/// A body with dents, and a specimen that is no box.
pub(crate) fn accepted<'a>(
    bodies: Cow<'a, [Aggregate]>,
    specimen: &Specimen,
) -> Result<Cow<'a, [Aggregate]>, EffectiveError> {
    if let Some(body) = bodies.iter().find(|body| !body.body.is_convex()) {
        return Err(EffectiveError::Dents(body.id));
    }
    if specimen.container().is_box() { Ok(faceted(bodies)) } else { Err(EffectiveError::Specimen(specimen.kind())) }
}
