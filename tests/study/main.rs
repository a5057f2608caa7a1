//! Tests of studies: combinations, hashes, records, tables.

mod ensembles;
mod names;
mod plans;
mod records;
mod runs;
mod tables;

use meso_files::Beside;
use meso_study::{Axis, Plan, PlanError};
use serde_json::{Value, json};
use std::path::Path;

/// A plan of cubes of 30 mm, with these axes.
pub(crate) fn plan(axes: &[(&str, Value)]) -> Result<Plan, PlanError> {
    plan_of(axes, &json!({}))
}

/// The same with steps after the packing.
pub(crate) fn plan_of(axes: &[(&str, Value)], task: &Value) -> Result<Plan, PlanError> {
    let base = json!({ "fraction": 0.2, "specimen": { "kind": "cube", "side_mm": 30 }, "grading": { "d_max_mm": 10 } });
    let axis = |(key, values): &(&str, Value)| Axis::new(*key, values.as_array().expect("a list").clone());
    Plan::new(&base, &axes.iter().map(axis).collect::<Vec<_>>(), task, &mut Beside(Path::new("")))
}
