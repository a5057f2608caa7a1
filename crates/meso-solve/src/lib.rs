//! Crushes a mesh: explicit dynamics of mesoscale concrete between rigid plates.
//!
//! Units as everywhere: mm, N, MPa, tonne, s; energies in mJ (N mm).
//!
//! [`Run::new`] checks a [`Test`] of a [`Sample`] and prepares it, [`Run::to_end`] runs it under the eyes of an
//! [`Observer`], and the [`Response`] holds the curve and its figures. [`solve`] is all three in one.

mod assemble;
#[cfg(test)]
mod dice;
mod error;
mod march;
pub mod results;

pub use error::SolveError;
pub use march::{
    BeyondPeak, Ended, Energies, Extra, Figures, Frame, Lateral, Mean, Observer, PhaseResult, Point, Response, Row,
    Run, Summary, checkpoint_note, device,
};
pub use meso_element::{InstructionSet, LawName, law, real};
pub use meso_trial::{
    Along, Below, Control, Course, Drive, Expansion, Gauge, Geometry, Interface, Rule, Sample, Setup, Side, Smoothing,
    Speed, Strip, SupportSpec, Test, TestKind, TrialError, Turn, TurnOf, gross_section_mm2,
};

use meso_concrete::watch::Watch;
use meso_mesh::materials::Materials;

/// Checks the test's values, and the materials that its law takes, before there is a mesh.
///
/// # Errors
/// The first value out of its range, with the accepted range.
pub fn validate(materials: &Materials, test: &Test) -> Result<(), SolveError> {
    test.validate()?;
    march::validate_columns(test)?;
    Ok(meso_element::block::matter::validate(materials, test.law)?)
}

/// Tests `sample`.
///
/// # Errors
/// See [`Run::new`]: a sample that cannot be tested is refused before the first step.
pub fn solve(
    sample: Sample,
    materials: &Materials,
    test: &Test,
    watch: &dyn Watch,
    observer: &dyn Observer,
) -> Result<Response, SolveError> {
    Ok(Run::new(sample, materials, test)?.to_end(watch, observer))
}
