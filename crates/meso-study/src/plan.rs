//! The cases of a study: a base, and axes whose values are laid over it in every combination.

use crate::case::Case;
use meso_pack::spec::Files;
use meso_pack::{Spec, SpecError};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Most cases of one study: each has a folder, and its spec stays in memory.
pub const MOST_CASES: usize = 1_000_000;
/// Number of cases planned between two reports: about 50 ms.
const REPORT: usize = 1000;
/// Options outside the spec whose axes change the task, not the spec.
const TASKS: [&str; 3] = ["mesh", "solve", "test"];

/// An option and its values, e.g. `grading.d_max_mm` and 16, 20.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Dotted path of the option in a SPEC.toml; `mesh.` and `solve.` are flags of these commands, `test.` is a key of a
    /// TEST.toml.
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

/// Why a study cannot be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// An axis without values.
    #[error("over.{0} has no values; give it at least one, or leave it out")]
    Empty(String),
    /// Two axes of one option, or of an option and a part of it.
    #[error("over.{0} and over.{1} change the same option; keep one of the two")]
    Overlapping(String, String),
    /// A key that is not a dotted path.
    #[error("over.{0:?} is not an option; write its path in a SPEC.toml, e.g. \"grading.d_max_mm\"")]
    Key(String),
    /// Too many combinations.
    #[error("over has {0} combinations; a study has at most {MOST_CASES} cases")]
    TooMany(usize),
    /// A combination whose spec is invalid.
    #[error("case {0}: {1}")]
    Spec(String, SpecError),
    /// A combination whose task the listener refuses.
    #[error("case {0}: {1}")]
    Task(String, String),
    /// Two combinations that are the same.
    #[error("cases {0} and {1} are the same: a value occurs twice in over, or the spec does not depend on it")]
    Twice(String, String),
    /// Two different cases whose folders have one name.
    #[error("two cases have the folder {0}; name one of the options in over differently, or split the study")]
    Folder(String),
    /// The listener asked to stop.
    #[error("stopped")]
    Stopped,
}

/// A listener to the planning, which may take seconds.
pub trait Planning {
    /// Hears of the cases planned so far and of all, some 20 times a second; false stops the planning.
    fn goes_on(&mut self, _planned: usize, _cases: usize) -> bool {
        true
    }

    /// Completes a case's task before it is hashed, e.g. with the hashes of files that the task names.
    ///
    /// # Errors
    /// A message, which ends the planning.
    fn complete(&mut self, _task: &mut Value) -> Result<(), String> {
        Ok(())
    }
}

/// A listener that changes nothing.
impl Planning for () {}

impl Plan {
    /// Lays every combination of `axes` over `base` (a spec's tree of values, unresolved) and `task` (the steps after
    /// packing).
    ///
    /// # Errors
    /// Names the invalid axis or case, before any work.
    pub fn new(base: &Value, axes: &[Axis], task: &Value, files: &mut dyn Files) -> Result<Self, PlanError> {
        Self::new_while(base, axes, task, files, &mut ())
    }

    /// Plans as [`new`](Self::new) does, with a listener.
    ///
    /// # Errors
    /// [`PlanError::Stopped`] and [`PlanError::Task`] where the listener says so, and the errors of [`new`](Self::new).
    pub fn new_while(
        base: &Value,
        axes: &[Axis],
        task: &Value,
        files: &mut dyn Files,
        planning: &mut dyn Planning,
    ) -> Result<Self, PlanError> {
        check(axes)?;
        let count = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
        let count = count.filter(|count| *count <= MOST_CASES).ok_or_else(|| {
            PlanError::TooMany(axes.iter().fold(1, |count, axis| count.saturating_mul(axis.values.len())))
        })?;
        let base = with_specimen(base, axes);
        let mut cases = Vec::with_capacity(count);
        for number in 0..count {
            if number % REPORT == 0 && !planning.goes_on(number, count) {
                return Err(PlanError::Stopped);
            }
            cases.push(case(&base, &combination(axes, number), task, files, planning)?);
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

/// Whether the option `key` is `whole` or a part of it.
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

/// `base` with the default specimen, where it has none and an axis changes only a part of the specimen.
fn with_specimen(base: &Value, axes: &[Axis]) -> Value {
    let mut tree = base.clone();
    if let (Value::Object(sections), Ok(usual)) = (&mut tree, serde_json::to_value(Spec::default().specimen))
        && axes.iter().any(|axis| is_part(&axis.key, "specimen"))
    {
        sections.entry("specimen").or_insert(usual);
    }
    tree
}

fn case(
    base: &Value,
    values: &[(&str, &Value)],
    task: &Value,
    files: &mut dyn Files,
    planning: &mut dyn Planning,
) -> Result<Case, PlanError> {
    let (mut tree, mut task) = (base.clone(), task.clone());
    let (of_task, of_spec) = values.iter().partition(|(key, _)| TASKS.iter().any(|name| is_part(key, name)));
    Spec::overlay(&mut tree, one_tree(of_spec));
    Spec::overlay(&mut task, one_tree(of_task));
    let spec = Spec::from_value_with(&tree, files).map_err(|error| PlanError::Spec(describe(values), error))?;
    planning.complete(&mut task).map_err(|message| PlanError::Task(describe(values), message))?;
    Ok(Case::new(values, spec, task))
}

/// A tree with each value at its path; no path is a part of another.
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

/// Refuses equal cases, and different ones whose folders would be one.
fn distinct(cases: &[Case]) -> Result<(), PlanError> {
    let (mut hashes, mut folders) = (BTreeMap::new(), BTreeSet::new());
    for case in cases {
        if let Some(other) = hashes.insert(&case.hash, &case.folder) {
            return Err(PlanError::Twice(other.clone(), case.folder.clone()));
        }
        if !folders.insert(&case.folder) {
            return Err(PlanError::Folder(case.folder.clone()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 40 bits of the hash, once the whole of it in a name, agree for two of a million cases in every third study.
    #[test]
    fn different_cases_with_one_folder_are_refused() {
        let axis = Axis { key: "seed".to_owned(), values: vec![1.into(), 2.into()] };
        let base = serde_json::json!({ "fraction": 0.2 });
        let mut plan =
            Plan::new(&base, &[axis], &Value::Null, &mut meso_files::Beside(std::path::Path::new(""))).unwrap();
        assert_eq!(distinct(&plan.cases), Ok(()));
        plan.cases[1].folder = plan.cases[0].folder.clone();
        assert_eq!(distinct(&plan.cases), Err(PlanError::Folder(plan.cases[0].folder.clone())));
    }
}
