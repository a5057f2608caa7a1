//! The Rust part of `mesocrete.study`: the plan, the run in a locked folder, records and tables.

mod fit;
mod lock;

pub(crate) use fit::PyFit;
pub(crate) use lock::PyLock;

use crate::beside::Told;
use crate::boundary::{file_error, guard, raised};
use crate::files::Stop;
use crate::mesh;
use crate::packing::PyPacking;
use crate::pickle;
use crate::response::device_doubt;
use crate::run::{Watch, beside_python_on};
use crate::spec::{self, options, spec_error};
use crate::tree::{self, plain};
use meso_ask::{AskError, Giver, Machine};
use meso_core::mesh::Tools;
use meso_core::saved;

use meso_core::{Model, Silent};
use meso_files::free;
use meso_files::lock::{LOCK, LockError};
use meso_gpu::Choice;
use meso_solve::Run;
use meso_study::{
    Again, Attached, Axis, Begun, Case, CaseOutcome, CaseTurn, Doing, Keep, MODELS, NamedFiles, Plan, PlanError,
    Planning, Record, RunError, Sampling, Seen, Share, Status, Steps, StudyFile, StudyLayout, StudyRun, Table,
    ensemble, of_packing, read_text, records, save_tables,
};
use pyo3::exceptions::{PyBlockingIOError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The cases of a study.
#[pyclass(name = "_StudyPlan", module = "mesocrete._mesocrete", frozen)]
pub(crate) struct PyStudyPlan {
    plan: Arc<Plan>,
    steps: Task,
}

/// How the steps of a study's cases are read.
#[derive(Clone, Serialize, Deserialize)]
struct Task {
    keep: Keep,
    /// Folder of the files that they name.
    folder: PathBuf,
    spelling: Spelling,
}

/// Spelling of the options of a study.
#[derive(Clone, Copy, Serialize, Deserialize)]
enum Spelling {
    /// Sections of a STUDY.toml.
    Sections,
    /// Dicts that are keywords.
    Dicts,
    /// Keywords of a fit.
    Keywords,
}

impl Task {
    fn steps(&self, task: &Value) -> Result<Steps, AskError> {
        let giver = |section: &'static str| match self.spelling {
            Spelling::Sections => Giver::Section(section),
            Spelling::Dicts => Giver::Keyword(section),
            Spelling::Keywords => Giver::Keywords,
        };
        Steps::of(task, self.keep, &self.folder, &giver, &read_text)
    }
}

/// Devices by their names.
fn device(name: &str, run: Option<&mut Run<'_>>) -> Result<Attached, AskError> {
    let lease = name.parse::<Choice>().and_then(Choice::find).map_err(AskError::Usage)?;
    let (Some(lease), Some(run)) = (lease, run) else { return Ok(Attached::default()) };
    meso_gpu::attach(run, &lease.device).map_err(|error| AskError::Run(error.to_string()))?;
    Ok(Attached { doubt: device_doubt(&lease.device), hold: Some(Box::new(lease)) })
}

/// A study while it runs.
#[pyclass(name = "_StudyRun", module = "mesocrete._mesocrete", frozen)]
pub(crate) struct PyStudyRun {
    run: StudyRun,
    plan: Arc<Plan>,
    of: CaseOf,
}

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
struct Interruptible<'py, 'a> {
    py: Python<'py>,
    raised: Option<PyErr>,
    named: NamedFiles<'a>,
}

impl Planning for Interruptible<'_, '_> {
    fn complete(&mut self, task: &mut Value) -> Result<(), String> {
        self.named.complete(task)
    }

    fn goes_on(&mut self, _: usize, _: usize) -> bool {
        self.raised = self.py.check_signals().err();
        self.raised.is_none()
    }
}

#[pymethods]
impl PyStudyPlan {
    /// Every combination of `over`, `zip` and `draw` laid over `spec`, as for `pack`, or over each of a list of specs; `steps`
    /// has the steps of a case by their names, and `model` the packing that it keeps.
    #[new]
    #[pyo3(signature = (spec, over, zip=None, draw=None, steps=None, model="json"))]
    fn new(
        spec: Option<&Bound<'_, PyAny>>,
        over: &Bound<'_, PyDict>,
        zip: Option<&Bound<'_, PyDict>>,
        draw: Option<&Bound<'_, PyDict>>,
        steps: Option<&Bound<'_, PyDict>>,
        model: &str,
    ) -> PyResult<Self> {
        guard(|| {
            let listed = spec.and_then(|spec| spec.cast::<PyList>().ok());
            let (base, folder) = spec::tree_of(spec.filter(|_| listed.is_none()))?;
            let specs = listed.map_or(Ok(Vec::new()), of_list)?;
            let axes = all_axes(specs, &Asked { over, zip, draw })?;
            let task = steps.map_or(Ok(Value::Object(Map::new())), |steps| tree::from_python("", steps.as_any()))?;
            let named = NamedFiles::beside(Path::new(""));
            let mut planning = Interruptible { py: over.py(), raised: None, named };
            let plan = Plan::new_while(&base, &axes, &task, &mut Told::beside(&folder), &mut planning);
            let plan = plan.map_err(|error| planning.raised.unwrap_or_else(|| plan_error(&error)))?;
            let keep = serde_json::from_value(model.into()).unwrap_or_default();
            let steps = Task { keep, folder: PathBuf::new(), spelling: Spelling::Dicts };
            let plan = Self { plan: Arc::new(plan), steps };
            plan.accept(over.py()).map(|()| plan)
        })
    }

    /// The study of a STUDY.toml; None where the file is a spec.
    #[staticmethod]
    fn of_file(py: Python<'_>, path: PathBuf) -> PyResult<Option<Self>> {
        guard(|| {
            let text = std::fs::read_to_string(&path);
            if !text.is_ok_and(|text| StudyFile::is_study(&text)) {
                return Ok(None);
            }
            let file = StudyFile::read(&path, &read_text).map_err(|fault| raised(&fault))?;
            let plan = file.plan(&mut |_, _| ()).map_err(|fault| raised(&fault))?;
            let steps = Task { keep: file.keep(), folder: file.beside().to_owned(), spelling: Spelling::Sections };
            let plan = Self { plan: Arc::new(plan), steps };
            plan.accept(py).map_err(|error| match error.is_instance_of::<PyValueError>(py) {
                true => raised(&file.wrong(&AskError::Usage(error.value(py).to_string()))),
                false => error,
            })?;
            Ok(Some(plan))
        })
    }

    /// The spec that a case packs, with the gaps that its mesh and its test need.
    fn packed_spec(&self, number: usize) -> PyResult<spec::PySpec> {
        let case = self.case(number)?;
        let spec = self.steps.steps(&case.task).and_then(|steps| steps.spec(&case.spec, &Silent));
        spec.map(spec::PySpec).map_err(|fault| raised(&fault))
    }

    /// The axes' keys.
    #[getter]
    fn keys(&self) -> Vec<String> {
        self.plan.keys.clone()
    }

    /// The folders' names, in the cases' order.
    #[getter]
    fn folders(&self) -> Vec<&str> {
        self.plan.cases.iter().map(|case| case.folder.as_str()).collect()
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
        let table = save_tables(&self.plan, then, &out, ()).map_err(run_error)?;
        let groups = ensemble(&table, &self.plan.keys, meso_study::REPLICATE);
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
        if !self.plan.keys.iter().any(|key| key == replicate) {
            let keys = self.plan.keys.join(", ");
            let message = format!("replicate is {replicate:?}; it must be an axis of the study: {keys}");
            return Err(PyValueError::new_err(message));
        }
        let table = meso_study::tabulate(&self.plan.keys, &self.records(then, &out));
        columns(py, &ensemble(&table, &self.plan.keys, replicate))
    }

    /// The records of the cases that are over, as dicts.
    fn results<'py>(&self, py: Python<'py>, then: &str, out: PathBuf) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.records(then, &out))
    }

    fn __len__(&self) -> usize {
        self.plan.cases.len()
    }
}

pub(crate) fn run_error(error: RunError) -> PyErr {
    match error {
        RunError::Lock(LockError::Busy { .. }) => PyBlockingIOError::new_err(error.to_string()),
        RunError::Layout(_) => PyValueError::new_err(error.to_string()),
        RunError::Full(fault) => raised(&fault),
        RunError::Lock(LockError::File { path, error }) | RunError::File { path, error } => file_error(&path, error),
    }
}

#[pymethods]
impl PyStudyRun {
    /// Looks which cases of `plan` are over in the folder `out`; `then` names the work beyond packing.
    #[new]
    #[pyo3(signature = (plan, then, out, retry_failed, layout=None))]
    fn new(plan: &PyStudyPlan, then: &str, out: PathBuf, retry_failed: bool, layout: Option<&str>) -> PyResult<Self> {
        let again = if retry_failed { Again::Failed } else { Again::None };
        let layout = layout.and_then(StudyLayout::named);
        guard(|| {
            let run =
                StudyRun::open(Arc::clone(&plan.plan), then, &out, again, Share::ALL, layout).map_err(run_error)?;
            let (how, seen) = (plan.steps.clone(), Seen::default());
            let of = CaseOf { case: None, how, then: then.to_owned(), out, again, seen };
            Ok(Self { run, plan: Arc::clone(&plan.plan), of })
        })
    }

    /// Numbers of the cases that are not over.
    #[getter]
    fn left(&self) -> Vec<usize> {
        self.run.left()
    }

    /// Number of the cases that are over.
    #[getter]
    fn over(&self) -> usize {
        self.run.tally().over()
    }

    /// Number of the cases that failed.
    #[getter]
    fn failed(&self) -> usize {
        self.run.tally().failed
    }

    /// False on a file system without locks.
    #[getter]
    fn is_exclusive(&self) -> bool {
        self.run.is_exclusive()
    }

    /// A case, for whoever does it.
    fn case(&self, number: usize) -> PyResult<PyStudyCase> {
        let case = self.plan.cases.get(number).cloned();
        let seen = self.run.look_again(number).map_err(run_error)?;
        Ok(PyStudyCase { of: CaseOf { case, seen, ..self.of.clone() }, turn: Mutex::default() })
    }

    /// Raises where a case that a worker has recorded is not in the folder.
    fn seen(&self, number: usize) -> PyResult<()> {
        if self.run.is_recorded(number) {
            return Ok(());
        }
        let folder = self.of.out.join(&self.plan.cases[number].folder);
        let folder = folder.display();
        let message =
            format!("a worker recorded a case in {folder}; all workers must see this folder (a shared file system)");
        Err(PyRuntimeError::new_err(message))
    }

    /// Takes note of a case that is over.
    fn note(&self, number: usize, failed: bool) {
        self.run.note(number, if failed { Status::Failed } else { Status::Done });
    }

    /// Writes the tables of the cases that are over, and frees the folder.
    fn close(&self) -> PyResult<()> {
        guard(|| {
            let saved = self.run.save_tables(()).map(drop);
            self.run.close();
            saved.map_err(run_error)
        })
    }

    /// Closes the lock in a forked process, where it belongs to the parent.
    fn leave_lock_to_parent(&self) {
        self.run.leave_lock_to_parent();
    }
}

/// Whether a case has steps after the packing.
fn has_steps(case: &Case) -> bool {
    case.task.as_object().is_some_and(|task| !task.is_empty())
}

/// A case and what is done with it: all that a worker needs.
#[derive(Clone, Serialize, Deserialize)]
struct CaseOf {
    /// Absent only for a number that the plan lacks.
    case: Option<Case>,
    how: Task,
    then: String,
    out: PathBuf,
    again: Again,
    /// Of records in one file those that the driver has read.
    seen: Seen,
}

/// A case for a worker. It is sent as JSON.
#[pyclass(name = "_StudyCase", module = "mesocrete._mesocrete", frozen)]
pub(crate) struct PyStudyCase {
    of: CaseOf,
    turn: Mutex<Option<CaseTurn>>,
}

impl PyStudyCase {
    fn whole(&self) -> PyResult<&Case> {
        self.of.case.as_ref().ok_or_else(|| PyValueError::new_err("there is no such case"))
    }

    fn turn(&self) -> MutexGuard<'_, Option<CaseTurn>> {
        self.turn.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[pymethods]
impl PyStudyCase {
    /// Takes the turn of this process: "turn", "done" and "failed" for a case that is over, "busy" for one of another process.
    fn begin(&self) -> PyResult<&'static str> {
        guard(|| {
            let CaseOf { then, out, again, seen, .. } = &self.of;
            let begun = CaseTurn::begin(self.whole()?, then, out, *again, *seen, &()).map_err(run_error)?;
            Ok(match begun {
                Begun::Turn(turn) => {
                    *self.turn() = Some(turn);
                    "turn"
                }
                Begun::Over(Status::Done) => "done",
                Begun::Over(Status::Failed) => "failed",
                Begun::Busy => "busy",
            })
        })
    }

    /// Folder of the case.
    #[getter]
    fn folder(&self) -> PyResult<PathBuf> {
        Ok(self.of.out.join(&self.whole()?.folder))
    }

    /// Whether a process works on the case, or has died at it.
    #[getter]
    fn is_marked(&self) -> PyResult<bool> {
        Ok(self.folder()?.join(LOCK).exists())
    }

    /// Whether the case has steps after the packing.
    #[getter]
    fn has_steps(&self) -> PyResult<bool> {
        Ok(has_steps(self.whole()?))
    }

    /// Refuses a machine that has not the device of the case's test.
    fn find_device(&self) -> PyResult<()> {
        let case = self.whole()?;
        // Most tests name none, and steps read files.
        if case.task.pointer("/solve/device").is_none() {
            return Ok(());
        }
        // A fault of the steps is that of their work.
        self.of.how.steps(&case.task).map_or(Ok(()), |steps| steps.find_device(&device).map_err(|fault| raised(&fault)))
    }

    /// Memory that the mesh and the test are estimated to take, bytes.
    #[getter]
    fn memory(&self, py: Python<'_>) -> PyResult<f64> {
        let (case, gmsh) = (self.whole()?, mesh::gmsh(py)?);
        Ok(self.of.how.steps(&case.task).map_or(0.0, |steps| steps.memory(&case.spec, &gmsh)))
    }

    /// Does the steps of the case, from its packing if there is one: the packing, the results as JSON, the message of its failure,
    /// and warnings.
    #[pyo3(signature = (threads=None))]
    fn work(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
    ) -> PyResult<(PyPacking, String, Option<String>, Vec<String>)> {
        let gmsh = mesh::gmsh(py)?;
        let (how, case, folder) = (self.of.how.clone(), self.whole()?.clone(), self.folder()?);
        let is_packed = self.turn().as_ref().is_some_and(CaseTurn::is_packed);
        let work = move |watch: &Watch| -> Result<_, AskError> {
            let steps = how.steps(&case.task)?;
            let warnings = Mutex::new(Vec::new());
            let tell = |word: &str, text: &str| {
                if word == "warning" {
                    warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
                }
            };
            let doing = Doing { watch, keeper: Stop(watch), gmsh: &gmsh, devices: &device, tell: &tell };
            let kept = if is_packed { kept(&folder, watch) } else { None };
            let model = Arc::new(kept.map_or_else(|| steps.pack(&case.spec, watch), Ok)?);
            let results = steps.run(&model, &folder, &doing);
            Ok((model, results, warnings.into_inner().unwrap_or_else(PoisonError::into_inner)))
        };
        guard(|| {
            let done = beside_python_on(py, threads, None, None, work)?;
            let (model, results, warnings) = done.map_err(|fault| raised(&fault))?;
            let (results, error) = match results {
                Ok(results) => (Value::Object(results).to_string(), None),
                Err(fault @ AskError::Full(_)) => return Err(raised(&fault)),
                Err(fault) => ("{}".to_owned(), Some(fault.message().to_owned())),
            };
            Ok((PyPacking(model), results, error, warnings))
        })
    }

    /// Records the case: its results as JSON, or the message of its failure. Returns "done" or "failed".
    #[pyo3(signature = (results, error, warnings))]
    fn end(&self, results: &str, error: Option<String>, warnings: Vec<String>) -> PyResult<&'static str> {
        guard(|| {
            let read = || serde_json::from_str::<Map<String, Value>>(results).map_err(|error| error.to_string());
            let outcome = CaseOutcome { results: error.map_or_else(read, Err), warnings };
            let Some(turn) = self.turn().take() else {
                return Err(PyValueError::new_err("the case has not begun"));
            };
            let status = turn.end(self.whole()?, &self.of.then, outcome, ()).map_err(run_error)?;
            Ok(if status == Status::Done { "done" } else { "failed" })
        })
    }

    /// Frees the folder of a case that has not ended.
    fn leave(&self) {
        drop(self.turn().take());
    }

    /// Closes the lock in a forked process, where it belongs to the parent.
    fn leave_lock_to_parent(&self) {
        // Another thread of the parent may have held the mutex while the process was forked.
        if let Some(turn) = self.turn.try_lock().ok().and_then(|mut turn| turn.take()) {
            turn.leave_to_parent();
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_study_case")?;
        (restore, (pickle::json(&self.of)?,)).into_pyobject(py)
    }
}

/// The saved model of a case, which its record vouches for.
fn kept(folder: &Path, watch: &Watch) -> Option<Model> {
    let read = |name: &&str| std::fs::read(folder.join(name)).ok();
    let bytes = MODELS.iter().find_map(read)?;
    saved::read_while(&bytes, watch).ok()
}

/// Unpickles a case.
#[pyfunction(name = "_study_case")]
pub(crate) fn study_case(of: &str) -> PyResult<PyStudyCase> {
    Ok(PyStudyCase { of: pickle::from_json(of)?, turn: Mutex::default() })
}

impl PyStudyPlan {
    /// The cases of a fit, whose materials lie in `folder`.
    pub(crate) fn of_fit(plan: Plan, folder: PathBuf) -> Self {
        Self { plan: Arc::new(plan), steps: Task { keep: Keep::Json, folder, spelling: Spelling::Keywords } }
    }

    /// Refuses a case with options that its packing cannot have.
    pub(crate) fn accept(&self, py: Python<'_>) -> PyResult<()> {
        if !self.plan.cases.first().is_some_and(has_steps) {
            return Ok(());
        }
        let tools = Tools { gmsh: &mesh::gmsh(py)?, ..Tools::default() };
        let machine = Machine { memory: free::memory(), tools, asked: None };
        self.plan.cases.iter().try_for_each(|case| {
            py.check_signals()?;
            let steps = self.steps.steps(&case.task).map_err(|fault| raised(&fault))?;
            steps.accept(&case.spec, &machine, &device).map_err(|fault| raised(&fault))
        })
    }

    fn case(&self, number: usize) -> PyResult<&Case> {
        self.plan.cases.get(number).ok_or_else(|| PyValueError::new_err(format!("there is no case {number}")))
    }

    pub(crate) fn records(&self, then: &str, out: &Path) -> Vec<Record> {
        records(&self.plan, then, out, &|_| true)
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

/// Results that a study records of a packing, where nothing else is done with it.
#[pyfunction(name = "_study_results")]
pub(crate) fn study_results<'py>(py: Python<'py>, packing: &PyPacking) -> PyResult<Bound<'py, PyAny>> {
    plain(py, &of_packing(&packing.0.report))
}
