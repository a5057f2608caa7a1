//! Crushes a mesh: explicit dynamics of mesoscale concrete between rigid plates.
//!
//! Units as everywhere: mm, N, MPa, tonne, s; energies in mJ (N mm).
//!
//! [`Run::new`] checks a [`Test`] of a [`Sample`] and prepares it, [`Run::to_end`] runs it under the eyes of an
//! [`Observer`], and the [`Response`] holds the curve and its figures. [`solve`] is all three in one.

mod assembly;
mod block;
mod builder;
mod checkpoint;
mod curve;
#[cfg(test)]
mod dice;
mod drive;
mod element;
mod error;
mod frame;
mod lanes;
pub mod law;
mod mass;
mod matter;
mod nodes;
mod observer;
mod order;
mod parts;
mod patches;
mod phases;
mod plates;
pub mod point;
pub mod real;
mod response;
pub mod results;
mod run;
mod sample;
mod servo;
mod test;
mod weight;

pub use curve::{Figures, Row};
pub use error::SolveError;
pub use frame::{Frame, Mean, Point};
pub use lanes::InstructionSet;
pub use observer::{Observer, Progress, Silent, Wish};
pub use response::{Ended, Energies, PhaseResult, Response, Summary};
pub use run::Run;
pub use sample::{Sample, gross_section_mm2};
pub use test::{Control, Interface, Itz, Joined, Kind, LawName, Smoothing, Test};

use meso_mesh::materials::Materials;

/// Checks what is known before there is a mesh: the test's values, and the materials that its law takes.
///
/// # Errors
/// Names the value and what is accepted.
pub fn validate(materials: &Materials, test: &Test) -> Result<(), SolveError> {
    test.validate()?;
    matter::validate(materials, test.law)
}

/// Tests `sample`.
///
/// # Errors
/// As [`Run::new`]: whatever cannot be tested is refused before the first step.
pub fn solve(
    sample: Sample,
    materials: &Materials,
    test: &Test,
    observer: &dyn Observer,
) -> Result<Response, SolveError> {
    Ok(Run::new(sample, materials, test)?.to_end(observer))
}
