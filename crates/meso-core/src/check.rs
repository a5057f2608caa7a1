//! The independent check of a model: everything a packing promises, proved from the saved coordinates alone.
//!
//! It shares no code with placement: its own broad phase, the exact collision verdict on the vertices as they are saved,
//! and exact orientation signs for convexity. What it finds is listed, never repaired.

mod pairs;
mod solid;

use crate::aggregate::{Aggregate, SizeDefinition};
use crate::geometry::sieve_size;
use crate::math::{Vec3, longest_distance};
use crate::model::Model;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt;

/// What a check looked at and found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// Aggregates looked at.
    pub aggregates: usize,
    /// Pairs whose boxes come within the asked gap of each other: those were put to the exact test.
    pub pairs_tested: u64,
    /// Volume of the polyhedra over the specimen's.
    pub fraction: f64,
    /// Everything that is not as promised; empty for a sound model.
    pub findings: Vec<Finding>,
}

/// One thing that is not as promised.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "finding", rename_all = "kebab-case")]
pub enum Finding {
    /// Two aggregates share a point.
    Overlap {
        /// The smaller id.
        a: u32,
        /// The larger id.
        b: u32,
    },
    /// Two aggregates are nearer than the spec's `min_gap_mm`.
    Gap {
        /// The smaller id.
        a: u32,
        /// The larger id.
        b: u32,
        /// Their distance, mm.
        distance_mm: f64,
    },
    /// A vertex is outside the specimen, or nearer to its surface than `wall_gap_mm`.
    Outside {
        /// Id.
        aggregate: u32,
    },
    /// The faces do not bound a convex solid seen from outside.
    NotConvex {
        /// Id.
        aggregate: u32,
        /// What is wrong.
        reason: String,
    },
    /// The ITZ leaves no core inside the aggregate.
    Itz {
        /// Id.
        aggregate: u32,
        /// What is wrong.
        reason: String,
    },
    /// The size is outside its class.
    Size {
        /// Id.
        aggregate: u32,
        /// Its size by the spec's definition, mm.
        size_mm: f64,
    },
    /// The report does not say what the aggregates say.
    Report {
        /// What differs.
        reason: String,
    },
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Overlap { a, b } => write!(f, "aggregates {a} and {b} share a point"),
            Self::Gap { a, b, distance_mm } => write!(f, "aggregates {a} and {b} are only {distance_mm} mm apart"),
            Self::Outside { aggregate } => {
                write!(f, "aggregate {aggregate} reaches out of the specimen or into the wall's gap")
            }
            Self::NotConvex { aggregate, reason } => write!(f, "aggregate {aggregate} is no convex solid: {reason}"),
            Self::Itz { aggregate, reason } => write!(f, "aggregate {aggregate} has no sound ITZ: {reason}"),
            Self::Size { aggregate, size_mm } => {
                write!(f, "aggregate {aggregate} has the size {size_mm} mm, outside its class")
            }
            Self::Report { reason } => write!(f, "the report is wrong: {reason}"),
        }
    }
}

impl Check {
    /// True when nothing was found.
    pub fn is_sound(&self) -> bool {
        self.findings.is_empty()
    }
}

/// Checks every promise of `model`.
pub fn check(model: &Model) -> Check {
    let bodies: Vec<&[Vec3]> = model.aggregates.iter().map(|a| a.body.vertices()).collect();
    let (pairs_tested, mut findings) = pairs::check(&bodies, model.spec.placement.min_gap_mm);
    findings.par_extend(model.aggregates.par_iter().flat_map_iter(|aggregate| single(model, aggregate)));
    // Summed in the order of the aggregates, whatever the threads.
    let volumes: Vec<f64> = model.aggregates.par_iter().map(|a| a.body.volume()).collect();
    let fraction = volumes.iter().sum::<f64>() / model.spec.specimen.volume();
    findings.extend(report(model, fraction));
    Check { aggregates: model.aggregates.len(), pairs_tested, fraction, findings }
}

/// What concerns one aggregate alone.
fn single(model: &Model, aggregate: &Aggregate) -> Vec<Finding> {
    let id = aggregate.id;
    let convex = solid::check(&aggregate.body).err().map(|reason| Finding::NotConvex { aggregate: id, reason });
    // The offset of what is no convex solid means nothing.
    let itz = if convex.is_none() { itz(aggregate) } else { None };
    [convex, itz, outside(model, aggregate), size(model, aggregate)].into_iter().flatten().collect()
}

fn outside(model: &Model, aggregate: &Aggregate) -> Option<Finding> {
    let inside = model.spec.specimen.holds(aggregate.body.vertices(), &Vec3::zeros(), model.spec.placement.wall_gap_mm);
    (!inside).then_some(Finding::Outside { aggregate: aggregate.id })
}

/// A point deeper than the shell is thick proves a core; only where the mean of the vertices is none, the core is made.
fn itz(aggregate: &Aggregate) -> Option<Finding> {
    let thickness = aggregate.itz_thickness_mm;
    // Planes and distances are rounded to about 1e-13 mm.
    if solid::depth_of_mean(&aggregate.body) > thickness + 1e-9 {
        return None;
    }
    let reason = match aggregate.core() {
        Err(error) => error.to_string(),
        Ok(None) => format!("a shell of {thickness} mm leaves no core"),
        Ok(Some(core)) => {
            let thinnest = solid::thinnest_shell(&aggregate.body, &core);
            if thinnest >= thickness - 1e-9 {
                return None;
            }
            format!("its shell is {thinnest} mm thin where it should be {thickness}")
        }
    };
    Some(Finding::Itz { aggregate: aggregate.id, reason })
}

/// Sizes are drawn within the class; turning an aggregate rounds its vertices by far less than 1e-6 mm.
fn size(model: &Model, aggregate: &Aggregate) -> Option<Finding> {
    let class = *model.spec.grading.classes().get(usize::from(aggregate.class))?;
    let size_mm = match model.spec.grading.size {
        SizeDefinition::LongestAxis => longest_distance(aggregate.body.vertices()),
        SizeDefinition::Sieve => sieve_size(&aggregate.body),
    };
    let fits = size_mm >= class.d_min_mm - 1e-6 && size_mm <= class.d_max_mm + 1e-6;
    (!fits).then_some(Finding::Size { aggregate: aggregate.id, size_mm })
}

/// The report's figures against those of the aggregates; 1e-9 covers the order of summation.
fn report(model: &Model, fraction: f64) -> Option<Finding> {
    let report = &model.report;
    let reason = if report.aggregates != model.aggregates.len() {
        format!("it counts {} aggregates, there are {}", report.aggregates, model.aggregates.len())
    } else if (report.fraction - fraction).abs() > 1e-9 {
        format!("it gives the fraction {}, the aggregates {fraction}", report.fraction)
    } else {
        return None;
    };
    Some(Finding::Report { reason })
}
