//! The cases of a study: a base, and axes whose values are laid over it in every combination.

use crate::case::Case;
use meso_pack::spec::Files;
use meso_pack::{Spec, SpecError};
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// Most cases of one study: every one has a folder, and its spec is kept in memory.
pub const MOST_CASES: usize = 1_000_000;
/// Options outside the spec whose axes change the task, not the spec.
const TASKS: [&str; 2] = ["mesh", "solve"];

/// An option and its values, e.g. `grading.d_max_mm` and 16, 20.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Dotted path of the option in a SPEC.toml; `mesh.` and `solve.` are flags of these commands.
    pub key: String,
    /// Values, in their order.
    pub values: Vec<Value>,
}

/// All cases of a study, in order: the last axis runs fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The axes' keys.
    pub keys: Vec<String>,
    /// The cases.
    pub cases: Vec<Case>,
}

/// A study that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// An axis without values.
    #[error("over.{0} has no values; give it at least one, or leave it out")]
    Empty(String),
    /// The same option twice, or an option and a part of it.
    #[error("over.{0} and over.{1} change the same option; keep one of the two")]
    Overlapping(String, String),
    /// A key that is no dotted path.
    #[error("over.{0:?} is not an option; write its path in a SPEC.toml, e.g. \"grading.d_max_mm\"")]
    Key(String),
    /// Too many combinations.
    #[error("over has {0} combinations; a study has at most {MOST_CASES} cases")]
    TooMany(usize),
    /// A combination whose spec cannot be.
    #[error("case {0}: {1}")]
    Spec(String, SpecError),
    /// Two combinations that are the same.
    #[error("cases {0} and {1} are the same: a value occurs twice in over, or the spec does not depend on it")]
    Twice(String, String),
}

impl Plan {
    /// Lays every combination of `axes` over `base` (a spec's tree of values, unresolved) and `task` (what is done with each
    /// packing).
    ///
    /// # Errors
    /// Names the axis or the case that cannot be, before any work.
    pub fn new(base: &Value, axes: &[Axis], task: &Value, files: &mut dyn Files) -> Result<Self, PlanError> {
        check(axes)?;
        let count = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
        let count = count.filter(|count| *count <= MOST_CASES).ok_or_else(|| {
            PlanError::TooMany(axes.iter().fold(1, |count, axis| count.saturating_mul(axis.values.len())))
        })?;
        let base = with_specimen(base, axes);
        let mut cases = Vec::with_capacity(count);
        for number in 0..count {
            cases.push(case(&base, &combination(axes, number), task, files)?);
        }
        distinct(&cases)?;
        Ok(Self { keys: axes.iter().map(|axis| axis.key.clone()).collect(), cases })
    }
}

fn check(axes: &[Axis]) -> Result<(), PlanError> {
    for (i, axis) in axes.iter().enumerate() {
        if axis.key.split('.').any(str::is_empty) {
            return Err(PlanError::Key(axis.key.clone()));
        }
        if axis.values.is_empty() {
            return Err(PlanError::Empty(axis.key.clone()));
        }
        let overlaps = |other: &&Axis| is_part(&axis.key, &other.key) || is_part(&other.key, &axis.key);
        if let Some(other) = axes[..i].iter().find(overlaps) {
            return Err(PlanError::Overlapping(other.key.clone(), axis.key.clone()));
        }
    }
    Ok(())
}

/// Whether the option `key` is `whole` or lies in it.
fn is_part(key: &str, whole: &str) -> bool {
    key.strip_prefix(whole).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// The values of combination `number`, axis by axis.
fn combination(axes: &[Axis], mut number: usize) -> Vec<(&str, &Value)> {
    let mut values: Vec<(&str, &Value)> = Vec::with_capacity(axes.len());
    for axis in axes.iter().rev() {
        values.push((&axis.key, &axis.values[number % axis.values.len()]));
        number /= axis.values.len();
    }
    values.reverse();
    values
}

/// `base` with the usual specimen where it has none and axes change a part of it, which alone is no specimen.
fn with_specimen(base: &Value, axes: &[Axis]) -> Value {
    let mut tree = base.clone();
    if let (Value::Object(sections), Ok(usual)) = (&mut tree, serde_json::to_value(Spec::default().specimen))
        && axes.iter().any(|axis| is_part(&axis.key, "specimen"))
    {
        sections.entry("specimen").or_insert(usual);
    }
    tree
}

fn case(base: &Value, values: &[(&str, &Value)], task: &Value, files: &mut dyn Files) -> Result<Case, PlanError> {
    let (mut tree, mut task) = (base.clone(), task.clone());
    let (of_task, of_spec) = values.iter().partition(|(key, _)| TASKS.iter().any(|name| is_part(key, name)));
    Spec::overlay(&mut tree, one_tree(of_spec));
    Spec::overlay(&mut task, one_tree(of_task));
    let spec = Spec::from_value_with(&tree, files).map_err(|error| PlanError::Spec(describe(values), error))?;
    Ok(Case::new(values, spec, task))
}

/// The values at their paths, of which none is a part of another.
fn one_tree(values: Vec<&(&str, &Value)>) -> Value {
    let mut tree = Value::Object(Map::new());
    for (key, value) in values {
        let place = key.split('.').fold(&mut tree, |section, name| &mut section[name]);
        *place = (*value).clone();
    }
    tree
}

/// `seed = 3, fraction = 0.4`.
fn describe(values: &[(&str, &Value)]) -> String {
    values.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}

fn distinct(cases: &[Case]) -> Result<(), PlanError> {
    let mut seen: BTreeMap<&str, &Case> = BTreeMap::new();
    for case in cases {
        if let Some(other) = seen.insert(&case.hash, case) {
            return Err(PlanError::Twice(other.folder.clone(), case.folder.clone()));
        }
    }
    Ok(())
}
