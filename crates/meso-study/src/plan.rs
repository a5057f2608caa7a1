//! The cases of a study: a base, and axes whose values are laid over it in every combination.

use crate::case::{Case, SpecTexts};
use meso_pack::spec::Files;
use meso_pack::{Spec, SpecError};
use serde_json::{Map, Value};
use std::collections::{BTreeMap, BTreeSet};

/// Most cases of one study: each has a folder, and its spec stays in memory.
pub const MOST_CASES: usize = 1_000_000;
/// Number of cases planned between two reports: about 50 ms.
const REPORT: usize = 1000;
/// Sections of a task, each a step after the packing.
pub(crate) const STEPS: [&str; 3] = ["mesh", "solve", "effective"];
/// Key of the test of a task.
const TEST: &str = "test";
/// Column with the names of listed specs.
const SPEC: &str = "spec";

/// Options that change together, often one, e.g. `grading.d_max_mm` with 16, 20.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Dotted paths of the options in a SPEC.toml; `mesh.`, `solve.` and `effective.` are flags of these commands, `test.` is a key of
    /// a TEST.toml.
    pub keys: Vec<String>,
    /// Values of all options, row by row.
    pub rows: Vec<Vec<Value>>,
    /// Specs that replace the base, one per row; empty where all rows have one base.
    pub specs: Vec<Value>,
}

impl Axis {
    /// One option and its values.
    pub fn new(key: impl Into<String>, values: Vec<Value>) -> Self {
        let rows = values.into_iter().map(|value| vec![value]).collect();
        Self { keys: vec![key.into()], rows, specs: Vec::new() }
    }

    /// A list of specs and their names, which are the values of the column `spec`.
    pub fn of_specs(named: Vec<(Value, Value)>) -> Self {
        let (names, specs): (Vec<_>, Vec<_>) = named.into_iter().unzip();
        Self { specs, ..Self::new(SPEC, names) }
    }
}

/// All cases of a study, in order: the last axis runs fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The axes' keys.
    pub keys: Vec<String>,
    /// The cases.
    pub cases: Vec<Case>,
    /// Name of the work that plans of one fit have in common; absent where the cases are all of it.
    pub work: Option<String>,
}

/// Why a study cannot be planned.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// An axis without values.
    #[error("over.{0} has no values; give it at least one, or leave it out")]
    Empty(String),
    /// Two axes of one option, or of an option and a part of it.
    #[error("{}", overlapping(.0, .1))]
    Overlapping(String, String),
    /// Two zipped lists of different lengths.
    #[error("zip.{0} has {1} values and zip.{2} has {3}; zipped lists need one length")]
    Uneven(String, usize, String, usize),
    /// A draw from something that is neither a range nor a list.
    #[error("draw.over.{0} is {1}; give a range {{ low = 0.2, high = 0.4 }} or a list of values")]
    Range(String, String),
    /// A draw of no cases.
    #[error("draw.cases is 0; it must lie within 1 and {MOST_CASES}")]
    NoCases,
    /// An option of a step that the study does not have.
    #[error("{0} changes [{1}], which is not there; add it")]
    NoStep(String, String),
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

fn overlapping(key: &str, other: &str) -> String {
    let both = if key == other { format!("{key} is given twice") } else { format!("{key} and {other} overlap") };
    format!("{both} in over, zip and draw; keep one of the two")
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
        check(axes, task)?;
        let count = axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.rows.len()));
        let count = count.filter(|count| *count <= MOST_CASES).ok_or_else(|| {
            PlanError::TooMany(axes.iter().fold(1, |count, axis| count.saturating_mul(axis.rows.len())))
        })?;
        let bases: Vec<Value> = bases(base, axes).into_iter().map(|base| with_specimen(base, axes)).collect();
        let (mut cases, mut texts) = (Vec::with_capacity(count), SpecTexts::default());
        for number in 0..count {
            if number % REPORT == 0 && !planning.goes_on(number, count) {
                return Err(PlanError::Stopped);
            }
            let (values, base) = combination(axes, number);
            let (spec, task) = complete(&bases[base], &values, task, files, planning)?;
            cases.push(Case::new(&values, spec, task, &mut texts));
        }
        distinct(&cases)?;
        Ok(Self { keys: axes.iter().flat_map(|axis| axis.keys.clone()).collect(), cases, work: None })
    }
}

fn check(axes: &[Axis], task: &Value) -> Result<(), PlanError> {
    let mut keys: Vec<&String> = Vec::new();
    for axis in axes {
        for key in &axis.keys {
            if key.split('.').any(str::is_empty) {
                return Err(PlanError::Key(key.clone()));
            }
            if axis.rows.is_empty() {
                return Err(PlanError::Empty(key.clone()));
            }
            if let Some(other) = keys.iter().find(|other| is_part(key, other) || is_part(other, key)) {
                return Err(PlanError::Overlapping(key.clone(), (*other).clone()));
            }
            let step = key.split('.').next().unwrap_or_default();
            if is_of_task(step) && task.get(step).is_none() {
                return Err(PlanError::NoStep(key.clone(), step.to_owned()));
            }
            keys.push(key);
        }
    }
    Ok(())
}

/// Whether an axis of this section changes the task, and not the spec.
fn is_of_task(section: &str) -> bool {
    section == TEST || STEPS.contains(&section)
}

/// Whether the option `key` is `whole` or a part of it.
fn is_part(key: &str, whole: &str) -> bool {
    key.strip_prefix(whole).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// Trees that the axes' values are laid over: the listed specs, or the one base.
fn bases<'a>(base: &'a Value, axes: &'a [Axis]) -> Vec<&'a Value> {
    let listed: Vec<&Value> = axes.iter().flat_map(|axis| &axis.specs).collect();
    if listed.is_empty() { vec![base] } else { listed }
}

/// The values of combination `number`, axis by axis, and the number of its base.
fn combination(axes: &[Axis], mut number: usize) -> (Vec<(&str, &Value)>, usize) {
    let (mut values, mut base) = (Vec::with_capacity(axes.len()), 0);
    for axis in axes.iter().rev() {
        let row = number % axis.rows.len();
        values.extend(axis.keys.iter().map(String::as_str).zip(&axis.rows[row]).rev());
        base = if axis.specs.is_empty() { base } else { row };
        number /= axis.rows.len();
    }
    values.reverse();
    (values, base)
}

/// `base` with the default specimen, where it has none and an axis changes only a part of the specimen.
fn with_specimen(base: &Value, axes: &[Axis]) -> Value {
    let mut tree = base.clone();
    if let (Value::Object(sections), Ok(usual)) = (&mut tree, serde_json::to_value(Spec::default().specimen))
        && axes.iter().flat_map(|axis| &axis.keys).any(|key| is_part(key, "specimen"))
    {
        sections.entry("specimen").or_insert(usual);
    }
    tree
}

/// The spec and the task of a combination.
fn complete(
    base: &Value,
    values: &[(&str, &Value)],
    task: &Value,
    files: &mut dyn Files,
    planning: &mut dyn Planning,
) -> Result<(Spec, Value), PlanError> {
    let (mut tree, mut task) = (base.clone(), task.clone());
    let options = values.iter().filter(|(key, _)| *key != SPEC);
    let (of_task, of_spec) = options.partition(|(key, _)| is_of_task(key.split('.').next().unwrap_or_default()));
    Spec::overlay(&mut tree, one_tree(of_spec));
    Spec::overlay(&mut task, one_tree(of_task));
    let spec = Spec::from_value_with(&tree, files).map_err(|error| PlanError::Spec(describe(values), error))?;
    planning.complete(&mut task).map_err(|message| PlanError::Task(describe(values), message))?;
    Ok((spec, task))
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
        let axis = Axis::new("seed", vec![1.into(), 2.into()]);
        let base = serde_json::json!({ "fraction": 0.2 });
        let mut plan =
            Plan::new(&base, &[axis], &Value::Null, &mut meso_files::Beside(std::path::Path::new(""))).unwrap();
        assert_eq!(distinct(&plan.cases), Ok(()));
        plan.cases[1].folder = plan.cases[0].folder.clone();
        assert_eq!(distinct(&plan.cases), Err(PlanError::Folder(plan.cases[0].folder.clone())));
    }
}
