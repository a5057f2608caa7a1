//! The Rust part of `mesocrete.fit`: points, records and results.

use super::{PyStudyPlan, run_error};
use crate::beside::Told;
use crate::boundary::{file_error, guard, raised};
use crate::spec::{self, options};
use crate::tree::{self, plain};
use meso_ask::{FitAsk, Given, Giver};
use meso_files::lock::Held;
use meso_study::fit::{FitRun, curve};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value};
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A fit at work, in a locked folder.
#[pyclass(name = "_Fit", module = "mesocrete._mesocrete", frozen)]
pub(crate) struct PyFit {
    fit: Mutex<FitRun>,
    /// Folder of the files that the spec names.
    folder: PathBuf,
    out: PathBuf,
    held: Mutex<Option<Held>>,
}

impl PyFit {
    fn fit(&self) -> MutexGuard<'_, FitRun> {
        self.fit.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn plan_of(&self, plan: meso_study::Plan) -> PyStudyPlan {
        PyStudyPlan::of_fit(plan, self.out.clone())
    }
}

#[pymethods]
impl PyFit {
    /// A fit of `spec` to the points of a curve, or to that of a file.
    #[new]
    #[pyo3(signature = (points, file, spec, given, materials, out))]
    fn new(
        py: Python<'_>,
        points: Option<Vec<[f64; 2]>>,
        file: Option<PathBuf>,
        spec: Option<&Bound<'_, PyAny>>,
        given: &Bound<'_, PyDict>,
        materials: Option<&Bound<'_, PyDict>>,
        out: PathBuf,
    ) -> PyResult<Self> {
        guard(|| {
            let options_tree = tree::from_python("", given.as_any())?;
            let options_tree = if let Value::Object(options) = options_tree { options } else { Map::new() };
            let ask = Given::<FitAsk>::of(options_tree, Giver::Keywords).map_err(|fault| raised(&fault))?;
            let (tree, folder) = spec::tree_of(spec)?;
            let name = file.as_ref().map_or("curve".to_owned(), |path| path.display().to_string());
            let read = |path: &PathBuf| std::fs::read(path).map_err(|error| file_error(path, error));
            let bytes = file.as_ref().map(read).transpose()?;
            let measured = |height_mm: f64| match (&points, &bytes) {
                (Some(points), _) => Ok(points.clone()),
                (None, bytes) => curve(bytes.as_deref().unwrap_or_default(), height_mm),
            };
            let mut beside = Told::beside(&folder);
            let fit = FitRun::new(ask, tree, &mut beside, (&name, &measured), options(materials)?, &out);
            let fit = fit.map_err(|fault| raised(&fault))?;
            let first = fit.first(&mut beside).map_err(|fault| raised(&fault))?;
            let this = Self { fit: Mutex::new(fit), folder, out, held: Mutex::default() };
            this.plan_of(first).accept(py)?;
            std::fs::create_dir_all(&this.out).map_err(|error| file_error(&this.out, error))?;
            let held = this.fit().begin().map_err(run_error)?;
            *this.held.lock().unwrap_or_else(PoisonError::into_inner) = Some(held);
            Ok(this)
        })
    }

    /// The cases of the points that are tested next; None once the fit is over.
    fn plan(&self) -> PyResult<Option<PyStudyPlan>> {
        let plan = self.fit().plan((), &mut Told::beside(&self.folder)).map_err(|fault| raised(&fault))?;
        Ok(plan.map(|plan| self.plan_of(plan)))
    }

    /// The folder of the cases.
    #[getter]
    fn cases(&self) -> PathBuf {
        self.fit().cases()
    }

    /// Takes in the records of the cases of a plan; returns a line about the fit.
    fn learn(&self, plan: &PyStudyPlan) -> PyResult<String> {
        let mut fit = self.fit();
        let records = plan.records("", &fit.cases());
        fit.learn(&records).map_err(|fault| raised(&fault))
    }

    /// Writes the results, and frees the folder.
    fn save(&self, title: &str) -> PyResult<()> {
        guard(|| self.fit().save(title, true, ()).map_err(|fault| raised(&fault)))
    }

    /// Frees the folder for other runs.
    fn close(&self) {
        drop(self.held.lock().unwrap_or_else(PoisonError::into_inner).take());
    }

    /// The materials at the best point, as a dict.
    fn materials<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.fit().materials())
    }

    /// The content of `fit.json`.
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        plain(py, &self.fit().report())
    }
}
