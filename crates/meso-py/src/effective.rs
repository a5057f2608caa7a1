//! Effective properties of a packing, a label volume or the frames of a test, as dicts.

use crate::boundary::{self, accept_in_memory, guard, wrong_type, wrong_value};
use crate::run::{Plan, in_stages, listener};
use crate::spec::spec_error;
use crate::tree::{from_python, plain};
use meso_ask::{
    EffectiveAsk, EffectiveTask, Facts, FramePick, Giver, Input, PhaseTables, PhasesGiven, RunRecord, Subject, What,
};
use meso_core::import::volume::{LabelNumber, Volume};
use meso_core::mesh::Mesh;
use meso_core::watch::Stage;
use meso_core::{Model, Watch, spec};
use meso_effective::results::Found;
use meso_effective::{EffectiveError, LabelSpecimen};
use meso_solve::Response;
use meso_solve::results::{Moment, Snapshot};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::ffi::CString;
use std::sync::Arc;

/// The request of some names, and of other keywords, of which those that are `None` keep their defaults.
pub(crate) fn asked(names: &[(&str, &str)], others: &[(&str, Option<&Bound<'_, PyAny>>)]) -> PyResult<EffectiveAsk> {
    let names = names.iter().map(|(key, name)| Ok(((*key).to_owned(), json!(name))));
    let given = others.iter().filter_map(|(key, value)| Some((*key, (*value)?)));
    let others = given.map(|(key, value)| Ok((key.to_owned(), from_python(key, &by_text(value)?)?)));
    let tree = Value::Object(names.chain(others).collect::<PyResult<_>>()?);
    let mut ask: EffectiveAsk = spec::options_from_value(&tree).map_err(|error| spec_error(&error))?;
    // In Python, the values of one property have no table of its name around them.
    ask.name_phases();
    Ok(ask)
}

/// The values of the phases.
fn phases<T: DeserializeOwned + Default>(ask: &EffectiveAsk) -> PyResult<T> {
    match &ask.phases {
        Some(PhasesGiven::Tables(tables)) => spec::options_from_value(tables).map_err(|error| spec_error(&error)),
        Some(PhasesGiven::File(name)) => Err(wrong_type(format!("phases is {name:?}; it must be a dict of values"))),
        None => Ok(T::default()),
    }
}

/// Computes the properties of a packing beside Python.
pub(crate) fn compute<'py>(
    py: Python<'py>,
    model: &Arc<Model>,
    ask: &EffectiveAsk,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    guard(|| {
        let values = PhaseTables::Packing(Box::new(phases(ask)?));
        let tasks = ask.settle(Facts::Packing(&model.spec), values).map_err(|error| raised(&error))?;
        let model = Arc::clone(model);
        solve(py, ask.what == What::All, tasks, progress, move |_, task, watch| {
            task.solve(Subject::Packing(&model), watch).map(|(found, _)| found)
        })
    })
}

/// Computes the properties of the frames that are asked for of a test beside Python.
pub(crate) fn in_frames<'py>(
    py: Python<'py>,
    ask: &EffectiveAsk,
    (response, mesh): (&Response, &Arc<Mesh>),
    frames: &[Arc<Snapshot>],
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    guard(|| {
        let giver = Giver::Keywords;
        let refused = |wrong| raised(&EffectiveError::Value(wrong));
        ask.accept(Input::Run).map_err(refused)?;
        let record = RunRecord::of(response, frames.iter().map(|frame| frame.moment).collect());
        let pick = ask.frame.unwrap_or_default();
        let chosen = record.choose(pick, giver).map_err(|error| boundary::raised(&error))?;
        let frame = |moment: &Moment| frames.iter().find(|frame| frame.moment == *moment).map(Arc::clone);
        let chosen: Vec<Arc<Snapshot>> = chosen.iter().filter_map(frame).collect();
        for doubt in chosen.iter().filter_map(|frame| record.doubt(pick, &frame.moment, giver)) {
            PyErr::warn(py, &py.get_type::<PyUserWarning>(), &CString::new(doubt)?, 1)?;
        }
        let values = record.values(PhaseTables::Packing(Box::new(phases(ask)?)));
        let settled = |frame: &Arc<Snapshot>| {
            let tasks = ask.settle(Facts::Frame(record.cracked(mesh, frame)), values.clone());
            tasks.map_err(|error| raised(&error))
        };
        let tasks = chosen.iter().map(settled).collect::<PyResult<Vec<_>>>()?.concat();
        let each = tasks.len() / chosen.len();
        let is_list = ask.what == What::All || pick == FramePick::All;
        let mesh = Arc::clone(mesh);
        solve(py, is_list, tasks, progress, move |number, task, watch| {
            let subject = Subject::Frame(record.cracked(&mesh, &chosen[number / each]));
            task.solve(subject, watch).map(|(found, _)| found)
        })
    })
}

/// Effective diffusivity, conductivity, permeability or stiffness of a label volume, with its error.
///
/// Every voxel has the value of its label. `fine` is the volume's own value; `tensor` is extrapolated from it and a
/// volume of every second voxel, since labels have errors of first order.
///
/// Parameters
/// ----------
/// labels : array_like of int, shape (nz, ny, nx) or (ny, nx)
///     One integer a phase, at most 256. With an `executor`: a sequence of such volumes, or of paths of `.npy` files.
/// what : {"diffusivity", "conductivity", "permeability", "stiffness", "all"}
///     The property. All are diffusivity, conductivity and stiffness; `phases` has a mapping for each, and a list of three is
///     returned.
/// voxel_size : float or sequence of three float
///     Edge of a voxel, mm; three are along x, y, z.
/// phases : mapping, optional
///     Values by label, as in `{0: 1.0, 1: 0.0}`; for stiffness, each label has a mapping of `youngs_modulus_mpa`,
///     `poisson_ratio`, `eigenstrain`. Without, labels are those of `Packing.voxelize`, with its phases' defaults.
/// eigenstrain : mapping, optional
///     Strains without stress by label, for stiffness.
/// axes : str
///     Axes of the gradient, some of x, y, z; each takes a solution. Stiffness always has all.
/// tolerance : float, optional
///     Error of the equations, over the result; 1e-9, and 1e-12 for stiffness, if omitted.
/// periodic : str
///     Axes along which the volume repeats itself; along others both faces have given values.
/// executor : concurrent.futures.Executor or dask.distributed.Client, optional
///     Does many volumes, one a call, each on one thread; see `study`. Paths are read by its workers.
/// progress : bool or callable, optional
///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1, or in volumes. When it returns
///     False, the work ends with a `RuntimeError`.
///
/// Returns
/// -------
/// Effective
///     See `Packing.effective`; names of phases are their labels. With an `executor`, a list in the order of the volumes.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Names the option, its value and the accepted range; a label without a value.
/// RuntimeError
///     Where the equations do not converge, or an executor has lost its workers.
#[pyfunction(name = "effective")]
#[pyo3(signature = (labels, what="diffusivity", *, voxel_size=None, phases=None, eigenstrain=None, axes="xyz", tolerance=None, periodic="", executor=None, progress=None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn of_labels<'py>(
    py: Python<'py>,
    labels: &Bound<'py, PyAny>,
    what: &str,
    voxel_size: Option<&Bound<'py, PyAny>>,
    phases: Option<&Bound<'py, PyAny>>,
    eigenstrain: Option<&Bound<'py, PyAny>>,
    axes: &str,
    tolerance: Option<&Bound<'py, PyAny>>,
    periodic: &str,
    executor: Option<&Bound<'py, PyAny>>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    if let Some(executor) = executor {
        let keywords = PyDict::new(py);
        let values =
            [("voxel_size", voxel_size), ("phases", phases), ("eigenstrain", eigenstrain), ("tolerance", tolerance)];
        values.iter().try_for_each(|(key, value)| keywords.set_item(key, value))?;
        [("what", what), ("axes", axes), ("periodic", periodic)]
            .iter()
            .try_for_each(|(key, name)| keywords.set_item(key, name))?;
        return py.import("mesocrete._effective")?.call_method1("of_many", (labels, executor, keywords, progress));
    }
    guard(|| {
        let periods: &[_] = if periodic.is_empty() { &[] } else { &[("periodic", periodic)] };
        let names = [&[("what", what), ("axes", axes)], periods].concat();
        let ask = asked(&names, &[("phases", phases), ("eigenstrain", eigenstrain), ("tolerance", tolerance)])?;
        let spacing_mm = spacing(voxel_size)?;
        let periodic = ask.periodic.map_or([false; 3], |axes| axes.flags());
        let specimen = LabelSpecimen { volume: volume(labels)?, spacing_mm, periodic };
        let values = PhaseTables::Labels(self::phases(&ask)?);
        let tasks = ask.settle(Facts::Labels(&specimen), values).map_err(|error| raised(&error))?;
        solve(py, ask.what == What::All, tasks, progress, move |_, task, watch| {
            task.solve(Subject::Labels(&specimen), watch).map(|(found, _)| found)
        })
    })
}

/// A dict whose keys are text: labels are integers in Python.
fn by_text<'py>(given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let Ok(given) = given.cast::<PyDict>() else { return Ok(given.clone()) };
    let texts = PyDict::new(given.py());
    for (key, value) in given {
        let text = key.str()?;
        if texts.contains(&text)? {
            return Err(wrong_value(format!(
                "the key {text} is given twice, as a number and as text; keep one of the two"
            )));
        }
        texts.set_item(text, value)?;
    }
    Ok(texts.into_any())
}

/// Edges of a voxel along x, y, z, mm.
pub(crate) fn spacing(given: Option<&Bound<'_, PyAny>>) -> PyResult<[f64; 3]> {
    let Some(given) = given else { return Ok([1.0; 3]) };
    let spacing = given.extract().map(|h: f64| [h; 3]).or_else(|_| given.extract::<[f64; 3]>());
    let spacing = spacing.map_err(|_| wrong_type(format!("voxel_size is {given}; it must be a number or three")))?;
    if spacing.iter().all(|h| h.is_finite() && *h > 0.0) {
        return Ok(spacing);
    }
    Err(wrong_value(format!("voxel_size is {given}; it must be a positive number, mm")))
}

/// The label volume that an array is.
pub(crate) fn volume<N: LabelNumber>(labels: &Bound<'_, PyAny>) -> PyResult<Volume<N>> {
    let numpy = labels.py().import("numpy")?;
    if labels.hasattr("mask")? && numpy.call_method1("any", (labels.getattr("mask")?,))?.is_truthy()? {
        return Err(wrong_value(
            "labels is a masked array with masked voxels; give these a label, as in labels.filled(0)",
        ));
    }
    let array = numpy.call_method1("asarray", (labels,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !["b", "i", "u"].contains(&kind.as_str()) {
        let dtype = array.getattr("dtype")?;
        return Err(wrong_type(format!("labels has dtype {dtype}; it must be integers, one a phase")));
    }
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let counts = match shape[..] {
        [y, x] => [x, y, 1],
        [z, y, x] => [x, y, z],
        _ => {
            let is_squeezable = shape.len() > 3 && shape.iter().filter(|length| **length != 1).count() <= 3;
            let fix = if is_squeezable { ": remove those of length 1 by labels.squeeze()" } else { "" };
            return Err(wrong_value(format!("labels has {} axes; it must have two or three{fix}", shape.len())));
        }
    };
    if kind == "u" && array.getattr("size")?.is_truthy()? {
        let largest: u64 = array.call_method0("max")?.extract()?;
        if i64::try_from(largest).is_err() {
            let most = i64::MAX;
            return Err(wrong_value(format!(
                "labels has the label {largest}; labels are at most {most}: number them anew"
            )));
        }
    }
    let flat = numpy.call_method1("ascontiguousarray", (array, "int64"))?.call_method1("reshape", (-1,))?;
    let flat = flat.cast_into::<PyArray1<i64>>()?;
    let values = flat.try_readonly().map_err(|error| wrong_value(error.to_string()))?;
    let values = values.as_slice()?.iter().copied();
    Volume::new(counts, None, values).map_err(|error| wrong_value(format!("labels: {error}")))
}

/// Solves all tasks beside Python if the memory holds them: one result, or a list of all.
fn solve<'py>(
    py: Python<'py>,
    is_list: bool,
    tasks: Vec<EffectiveTask>,
    progress: Option<&Bound<'py, PyAny>>,
    work: impl Fn(usize, &EffectiveTask, &dyn Watch) -> Result<Found, EffectiveError> + Send + 'static,
) -> PyResult<Bound<'py, PyAny>> {
    for task in &tasks {
        accept_in_memory("effective", task.bytes, &Giver::Keywords.option(task.size().0))?;
    }
    let progress = listener(py, progress)?;
    let plan = Plan::new(&[(Stage::Solve, 1.0)], Some(1.0));
    let found = in_stages(py, progress.as_ref(), plan, move |watch| {
        watch.stops_soon();
        tasks.iter().enumerate().map(|(number, task)| work(number, task, watch)).collect::<Result<Vec<_>, _>>()
    })?;
    let class = py.import("mesocrete._effective")?.getattr("Effective")?;
    let found = found.map_err(|error| raised(&error))?;
    let mut found = found.iter().map(|found| class.call1((plain(py, found)?,))).collect::<PyResult<Vec<_>>>()?;
    if is_list { found.into_bound_py_any(py) } else { Ok(found.remove(0)) }
}

fn raised(error: &EffectiveError) -> PyErr {
    boundary::raised(&EffectiveAsk::fault(error, Giver::Keywords))
}
