//! Ranges of a model's values, whether it was read, packed or imported. A reader refuses the others, so that they are never
//! written: a model that breaks this is refused before any product is made of it.

use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use meso_place::Report;
use meso_spec::{MAX_LENGTH_MM, Spec};

/// Why a model is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// Two entries that must agree do not.
    #[error("{0}")]
    Contradiction(String),
    /// A void or fibre that is none of those the spec asks for, or no closed surface.
    #[error("body {index}, one of the inclusions: {reason}")]
    Inclusion {
        /// Position in the file, counted from the first aggregate.
        index: usize,
        /// The fault.
        reason: String,
    },
    /// An aggregate whose surface is not closed.
    #[error("aggregate {index}: {reason}")]
    Aggregate {
        /// Position in the file, from 0.
        index: usize,
        /// The fault.
        reason: String,
    },
}

/// Accepts the parts of a model that can be read back.
///
/// # Errors
/// The first value that a reader refuses. Surfaces that are not closed are not looked for: makers of bodies prove them.
pub(crate) fn model(
    spec: &Spec,
    aggregates: &[Aggregate],
    inclusions: &[Aggregate],
    said: &Report,
) -> Result<(), Fault> {
    report(said, spec, aggregates.len())?;
    let classes = spec.grading.classes().len();
    for (index, aggregate) in aggregates.iter().enumerate() {
        let wrong = |reason: String| Fault::Aggregate { index, reason };
        values(index, aggregate.id, (aggregate.class, classes), aggregate.itz_thickness_mm).map_err(wrong)?;
        in_reach(aggregate.body.vertices()).map_err(wrong)?;
    }
    for (index, inclusion) in (aggregates.len()..).zip(inclusions) {
        in_reach(inclusion.body.vertices()).map_err(|reason| Fault::Inclusion { index, reason })?;
    }
    Ok(())
}

/// Accepts the values of the aggregate at this position: its id, its class of so many, and the thickness of its ITZ.
pub(crate) fn values(index: usize, id: u32, (class, classes): (u16, usize), itz_mm: f64) -> Result<(), String> {
    if id as usize != index {
        return Err(format!("its id is {id}; ids count from 0 in the order of the file"));
    }
    if usize::from(class) >= classes {
        return Err(format!("its class is {class}; the spec has {classes} classes, counted from 0"));
    }
    if !(0.0..=MAX_LENGTH_MM).contains(&itz_mm) {
        return Err(format!("its itz_thickness_mm is {itz_mm}; it must be 0 or more"));
    }
    Ok(())
}

/// Accepts vertices that every step can compute with.
pub(crate) fn in_reach(vertices: &[Vec3]) -> Result<(), String> {
    let is_in_reach = |v: &Vec3| v.iter().all(|x| x.abs() <= 2.0 * MAX_LENGTH_MM);
    match vertices.iter().position(|v| !is_in_reach(v)) {
        Some(vertex) => Err(format!("vertex {vertex} is farther than {} mm from the origin", 2.0 * MAX_LENGTH_MM)),
        None => Ok(()),
    }
}

/// Accepts a report that speaks of as many aggregates as there are, in figures that are numbers.
pub(crate) fn report(report: &Report, spec: &Spec, aggregates: usize) -> Result<(), Fault> {
    let classes = spec.grading.classes().len();
    if report.aggregates != aggregates || report.classes.len() != classes || report.seed != spec.seed {
        let message = format!(
            "report speaks of {} aggregates in {} classes with seed {}, the file holds {aggregates} in {classes} with seed {}",
            report.aggregates,
            report.classes.len(),
            report.seed,
            spec.seed
        );
        return Err(Fault::Contradiction(message));
    }
    let again = serde_json::to_value(report).and_then(serde_json::from_value::<Report>);
    again.map(drop).map_err(|error| Fault::Contradiction(format!("a figure of the report is no number: {error}")))
}
