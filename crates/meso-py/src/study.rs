//! The Rust part of `mesocrete.study`: the plan, the run in a locked folder, records and tables.

use crate::beside::Told;
use crate::boundary::{file_error, guard};
use crate::files;
use crate::packing::PyPacking;
use crate::run::beside_python;
use crate::spec::{self, options, spec_error};
use crate::tree::{self, plain};
use meso_files::lock::LockError;
use meso_study::{
    Again, Axis, Case, CaseState, MODELS, Plan, PlanError, Planning, Record, RunError, Sampling, StudyRun, Table,
    ensemble, of_packing, save_tables,
};
use pyo3::exceptions::{PyBlockingIOError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The cases of a study.
#[pyclass(name = "_StudyPlan", module = "mesocrete._mesocrete", frozen)]
pub(crate) struct PyStudyPlan(Arc<Plan>);

/// A study while it runs; its folder is locked.
#[pyclass(name = "_StudyRun", module = "mesocrete._mesocrete", frozen)]
pub(crate) struct PyStudyRun(StudyRun);

/// The lists of a dict from dotted keys to iterables; errors name it `over` or `zip`.
fn lists(name: &str, table: &Bound<'_, PyDict>) -> PyResult<Vec<(String, Vec<Value>)>> {
    let list = |(key, values): (Bound<'_, PyAny>, Bound<'_, PyAny>)| -> PyResult<(String, Vec<Value>)> {
        let key: String = key
            .extract()
            .map_err(|_| PyTypeError::new_err(format!("the names in {name} are str, not {}", tree::type_name(&key))))?;
        let is_text = values.extract::<String>().is_ok();
        let listed = if is_text { None } else { values.try_iter().ok() };
        let path = format!("{name}[{key:?}]");
        let listed = listed.ok_or_else(|| {
            PyTypeError::new_err(format!("{path} is {values}; give an iterable of values, e.g. [{values}]"))
        })?;
        let values = listed.map(|value| tree::from_python(&path, &value?)).collect::<PyResult<_>>()?;
        Ok((key, values))
    };
    table.iter().map(list).collect()
}

/// The axes of listed specs, `over`, `zip` and `draw`, in this order.
fn all_axes(specs: Vec<Value>, asked: &Asked<'_, '_>) -> PyResult<Vec<Axis>> {
    let wrong = |error: PlanError| PyValueError::new_err(error.to_string());
    let named = |specs: Vec<Value>| specs.into_iter().enumerate().map(|(number, spec)| (number.into(), spec)).collect();
    let mut all: Vec<Axis> = (!specs.is_empty()).then(|| Axis::of_specs(named(specs))).into_iter().collect();
    all.extend(lists("over", asked.over)?.into_iter().map(|(key, values)| Axis::new(key, values)));
    if let Some(zip) = asked.zip.filter(|zip| !zip.is_empty()) {
        all.push(Axis::zipped(lists("zip", zip)?).map_err(wrong)?);
    }
    if let Some(draw) = asked.draw {
        let draw: Sampling = options(Some(draw))?;
        all.push(Axis::drawn(&draw, &all).map_err(wrong)?);
    }
    Ok(all)
}

/// The trees of a list of specs; files that they name are looked for in the current folder.
fn of_list(specs: &Bound<'_, PyList>) -> PyResult<Vec<Value>> {
    specs.iter().map(|spec| spec::tree_of(Some(&spec)).map(|(tree, _)| tree)).collect()
}

/// Tables of a study.
struct Asked<'a, 'py> {
    over: &'a Bound<'py, PyDict>,
    zip: Option<&'a Bound<'py, PyDict>>,
    draw: Option<&'a Bound<'py, PyDict>>,
}

fn plan_error(error: &PlanError) -> PyErr {
    match error {
        PlanError::Spec(case, error) => {
            let of_spec = spec_error(error);
            let text = format!("case {case}: {error}");
            Python::attach(|py| match of_spec.is_instance_of::<PyTypeError>(py) {
                true => PyTypeError::new_err(text),
                false => PyValueError::new_err(text),
            })
        }
        other => PyValueError::new_err(other.to_string()),
    }
}

/// Listens to signals while a study is planned.
struct Interruptible<'py> {
    py: Python<'py>,
    raised: Option<PyErr>,
}

impl Planning for Interruptible<'_> {
    fn goes_on(&mut self, _: usize, _: usize) -> bool {
        self.raised = self.py.check_signals().err();
        self.raised.is_none()
    }
}

#[pymethods]
impl PyStudyPlan {
    /// Every combination of `over`, `zip` and `draw` laid over `spec`, as for `pack`, or over each of a list of specs.
    #[new]
    #[pyo3(signature = (spec, over, zip=None, draw=None))]
    fn new(
        spec: Option<&Bound<'_, PyAny>>,
        over: &Bound<'_, PyDict>,
        zip: Option<&Bound<'_, PyDict>>,
        draw: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<Self> {
        guard(|| {
            let listed = spec.and_then(|spec| spec.cast::<PyList>().ok());
            let (base, folder) = spec::tree_of(spec.filter(|_| listed.is_none()))?;
            let specs = listed.map_or(Ok(Vec::new()), of_list)?;
            let axes = all_axes(specs, &Asked { over, zip, draw })?;
            let mut planning = Interruptible { py: over.py(), raised: None };
            let task = Value::Object(Map::new());
            let plan = Plan::new_while(&base, &axes, &task, &mut Told::beside(&folder), &mut planning);
            plan.map(|plan| Self(Arc::new(plan))).map_err(|error| planning.raised.unwrap_or_else(|| plan_error(&error)))
        })
    }

    /// The axes' keys.
    #[getter]
    fn keys(&self) -> Vec<String> {
        self.0.keys.clone()
    }

    /// The folders' names, in the cases' order.
    #[getter]
    fn folders(&self) -> Vec<&str> {
        self.0.cases.iter().map(|case| case.folder.as_str()).collect()
    }

    /// The axes' values of a case.
    fn values<'py>(&self, py: Python<'py>, number: usize) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.case(number)?.values.iter().cloned().collect::<Map<_, _>>())
    }

    /// The complete spec of a case.
    fn spec(&self, number: usize) -> PyResult<spec::PySpec> {
        Ok(spec::PySpec(self.case(number)?.spec.clone()))
    }

    /// Writes the tables of the cases that are over into `out`; returns the columns of the cases, and of the ensembles.
    fn tables<'py>(
        &self,
        py: Python<'py>,
        then: &str,
        out: PathBuf,
    ) -> PyResult<(Bound<'py, PyDict>, Bound<'py, PyDict>)> {
        let records = self.records(then, &out);
        let table = save_tables(&out, &self.0.keys, &records, ()).map_err(|error| file_error(&out, error))?;
        let groups = ensemble(&table, &self.0.keys, meso_study::REPLICATE);
        Ok((columns(py, &table)?, columns(py, &groups)?))
    }

    /// Mean and scatter over the axis `replicate`.
    fn ensemble<'py>(
        &self,
        py: Python<'py>,
        then: &str,
        out: PathBuf,
        replicate: &str,
    ) -> PyResult<Bound<'py, PyDict>> {
        if !self.0.keys.iter().any(|key| key == replicate) {
            let keys = self.0.keys.join(", ");
            let message = format!("replicate is {replicate:?}; it must be an axis of the study: {keys}");
            return Err(PyValueError::new_err(message));
        }
        let table = meso_study::tabulate(&self.0.keys, &self.records(then, &out));
        columns(py, &ensemble(&table, &self.0.keys, replicate))
    }

    /// The records of the cases that are over, as dicts.
    fn results<'py>(&self, py: Python<'py>, then: &str, out: PathBuf) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.records(then, &out))
    }

    fn __len__(&self) -> usize {
        self.0.cases.len()
    }
}

fn run_error(error: RunError) -> PyErr {
    match error {
        RunError::Lock(LockError::Busy { .. }) => PyBlockingIOError::new_err(error.to_string()),
        RunError::Lock(LockError::File { path, error }) | RunError::File { path, error } => file_error(&path, error),
    }
}

#[pymethods]
impl PyStudyRun {
    /// Locks the folder `out` and looks which cases of `plan` are over; `then` names the work beyond packing.
    #[new]
    fn new(plan: &PyStudyPlan, then: &str, out: PathBuf, retry_failed: bool) -> PyResult<Self> {
        let again = if retry_failed { Again::Failed } else { Again::None };
        guard(|| StudyRun::open(Arc::clone(&plan.0), then, &out, again).map(Self).map_err(run_error))
    }

    /// Numbers of the cases that are not over.
    #[getter]
    fn left(&self) -> Vec<usize> {
        self.0.left()
    }

    /// Number of the cases that are over.
    #[getter]
    fn over(&self) -> usize {
        self.0.tally().over()
    }

    /// Prepares the folder of a case; returns whether its packing is there.
    fn begin(&self, number: usize) -> PyResult<bool> {
        guard(|| self.0.begin(number).map_err(run_error))
    }

    /// Records a case: its results as JSON, or the message of its failure.
    #[pyo3(signature = (number, results, error))]
    fn end(&self, number: usize, results: &str, error: Option<String>) -> PyResult<()> {
        guard(|| {
            let read = || serde_json::from_str::<Map<String, Value>>(results).map_err(|error| error.to_string());
            let outcome = error.map_or_else(read, Err).into();
            self.0.end(number, outcome, ()).map_err(run_error)
        })
    }

    /// Writes the tables of the cases that are over, and frees the folder.
    fn close(&self) -> PyResult<()> {
        guard(|| {
            let saved = self.0.save_tables(()).map(drop);
            self.0.close();
            saved.map_err(run_error)
        })
    }

    /// Closes the lock in a forked process, where it belongs to the parent.
    fn leave_lock_to_parent(&self) {
        self.0.leave_lock_to_parent();
    }
}

impl PyStudyPlan {
    fn case(&self, number: usize) -> PyResult<&Case> {
        self.0.cases.get(number).ok_or_else(|| PyValueError::new_err(format!("there is no case {number}")))
    }

    fn records(&self, then: &str, out: &Path) -> Vec<Record> {
        let state = |case: &Case| CaseState::of(case, then, &out.join(&case.folder));
        let states = self.0.cases.iter().map(state);
        states.filter_map(|state| if let CaseState::Over(record) = state { Some(*record) } else { None }).collect()
    }
}

/// A table as a dict of lists, None where there is no value.
fn columns<'py>(py: Python<'py>, table: &Table) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for column in &table.columns {
        let cells = (0..table.rows()).map(|row| tree::to_python(py, &column.values.json(row)));
        dict.set_item(&column.name, PyList::new(py, cells.collect::<PyResult<Vec<_>>>()?)?)?;
    }
    Ok(dict)
}

/// Writes a packing into the folder of its case.
#[pyfunction(name = "_study_write")]
pub(crate) fn study_write(py: Python<'_>, packing: &PyPacking, folder: PathBuf, compressed: bool) -> PyResult<()> {
    let (model, path) = (Arc::clone(&packing.0), folder.join(MODELS[usize::from(compressed)]));
    guard(|| beside_python(py, None, move |watch| files::write_case(&model, &path, watch))?)
}

/// Results that a study records of a packing, where nothing else is done with it.
#[pyfunction(name = "_study_results")]
pub(crate) fn study_results<'py>(py: Python<'py>, packing: &PyPacking) -> PyResult<Bound<'py, PyAny>> {
    plain(py, &of_packing(&packing.0.report))
}
