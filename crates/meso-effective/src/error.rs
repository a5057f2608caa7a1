//! Refusals of effective properties.

use meso_collision::geometry::BodyForm;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{OutOfRange, Ranges, parallel};
use meso_mesh::MeshError;
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
    /// An axis of a cylinder without flat ends.
    #[error("specimen.kind is cylinder; its flat ends lie along z alone, so the axes must be z")]
    Ends,
    /// The specimen cannot be meshed.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Elements too large for a phase.
    #[error(
        "the phase {phase} takes {meshed:.4} of the specimen in the tetrahedra and {exact:.4} in the packing; take smaller elements, or the \
         method voxel"
    )]
    Coarse {
        /// Its name.
        phase: String,
        /// Its volume in the mesh over the specimen's.
        meshed: f64,
        /// Its volume in the packing over the specimen's.
        exact: f64,
    },
    /// A body with dents that is too thin for its ITZ.
    #[error(
        "aggregate {0} has dents and parts that are thinner than two of its ITZ ({1} mm); pack with a thinner ITZ, or the hulls by \
         shape.hull = true"
    )]
    Dents(u32, f64),
    /// A body with dents that is too thin for its shells.
    #[error(
        "aggregate {0} has dents and parts that are thinner than two of its ITZ with shells ({1:.3} mm); take the method \
         lattice, or pack with thinner shells"
    )]
    DentsInShells(u32, f64),
    /// A label of a volume that no table has.
    #[error("label {label} has no value; give it in [{table}] of a phases file, as in {label} = {example}", example = example(table))]
    Unlabelled {
        /// Table of the phases file.
        table: &'static str,
        /// The label.
        label: i64,
    },
    /// A key of a table that is neither a label nor a phase.
    #[error(
        "[{table}] has `{name}`; its keys must be labels, as in 0, or all of them mortar, itz, aggregate, void, fibre"
    )]
    Name {
        /// Table of the phases file.
        table: &'static str,
        /// The key.
        name: String,
    },
    /// One label under two names.
    #[error("[{table}] has the label {label} twice, as {} and as {}; keep one of them", names[0], names[1])]
    Twice {
        /// Table of the phases file.
        table: &'static str,
        /// The label.
        label: i64,
        /// Its keys.
        names: [String; 2],
    },
    /// Only zeros.
    #[error("all labels of the volume have the value 0 in [{0}]; one must have more")]
    Nothing(&'static str),
    /// The iterations did not reach the tolerance.
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

/// Refuses a tolerance of the equations out of its range: below, single precision leaves nothing to improve.
///
/// # Errors
/// The range.
pub(crate) fn accept_tolerance(tolerance: f64) -> Result<(), OutOfRange> {
    Ranges("effective").require("tolerance", tolerance, (1e-13..=1e-2).contains(&tolerance), "it must be 1e-13 to 0.01")
}

fn example(table: &str) -> &'static str {
    if table == "stiffness" { "{ youngs_modulus_mpa = 20000, poisson_ratio = 0.2 }" } else { "1.0" }
}

/// The bodies as [`accepted`] gives them, where the inner sides of all shells are surfaces.
///
/// # Errors
/// A body with dents that is too thin for its ITZ or its shells.
pub(crate) fn accepted_with_shells(bodies: Cow<'_, [Aggregate]>) -> Result<Cow<'_, [Aggregate]>, EffectiveError> {
    let bodies = accepted(bodies)?;
    let lost = |number: usize| {
        let body = Some(&bodies[number]).filter(|body| body.body.form() == BodyForm::Surface)?;
        let mut inner = body.layers().skip(1);
        inner.find(|(depth, _)| body.surface_below(*depth).is_err()).map(|(depth, _)| (body.id, depth))
    };
    match parallel::flat_map(bodies.len(), lost).first() {
        Some(&(id, depth)) => Err(EffectiveError::DentsInShells(id, depth)),
        None => Ok(bodies),
    }
}

/// The bodies as properties are computed for them: balls and ellipsoids become polyhedra of their volume.
///
/// # Errors
/// A body with dents that is too thin for its ITZ.
pub(crate) fn accepted(bodies: Cow<'_, [Aggregate]>) -> Result<Cow<'_, [Aggregate]>, EffectiveError> {
    let is_thin = |body: &Aggregate| body.body.form() == BodyForm::Surface && body.inner_surface().is_err();
    if let Some(body) = parallel::filter(bodies.len(), |number| is_thin(&bodies[number])).first() {
        let body = &bodies[*body as usize];
        return Err(EffectiveError::Dents(body.id, body.itz_thickness_mm));
    }
    if bodies.iter().all(|body| !matches!(body.body.form(), BodyForm::Round(_))) {
        return Ok(bodies);
    }
    let facets = |body: &Aggregate| Aggregate { body: body.body.faceted().into_owned(), ..body.clone() };
    Ok(bodies.iter().map(facets).collect())
}
