//! `pack`: Python's arguments are checked, then packed beside Python.

use crate::boundary::{guard, mesh_error, raised, wrong_type, wrong_value};
use crate::mesh;
use crate::packing::PyPacking;
use crate::run::{Plan, Watch, beside_python, beside_python_on, checked_threads, listener};
use crate::{spec, tree};
use meso_ask::footing;
use meso_ask::{Giver, Over};
use meso_core::mesh::{MeshTable, Purpose};
use meso_core::watch::Stage;
use meso_core::{Silent, Spec};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use std::ffi::CString;
use std::sync::Arc;

/// Generates and places the aggregates that a spec asks for.
///
/// Parameters
/// ----------
/// spec : None, dict, path or Spec
///     The spec; None is the paper's specimen.
/// seed : int, optional
///     Replaces the spec's seed; 0 to 2^64 - 1.
/// fraction : float, optional
///     Replaces the spec's fraction: aggregate volume over specimen volume, above 0 and below 1.
/// threads : int, optional
///     All cores when absent. It changes the time, never the result.
/// time_limit : float, optional
///     Stop after so many seconds with the best packing found; replaces the spec's.
/// for_test : bool, optional
///     Whether the packing is for a test: aggregates keep gaps of half an element, or less in dense packings, where the
///     spec leaves `min_gap_mm` at 0. `mesocrete pack --analysis compression` packs in the same way.
/// method : str, optional
///     Method of the mesh that follows. "conforming" needs gaps of 0.05 mm, which are left where the spec has none. It
///     is "lattice" by default with `for_test`.
/// element_size : float or "auto", optional
///     Edge length of the elements of the mesh that follows, mm; default 2. "auto" tries sizes on a small cube of the
///     packing, and takes the largest that keeps every phase within 5 %.
/// progress : bool or callable, optional
///     True shows a bar, in a notebook, too. A callable is called about 25 times a second as `progress(done, total)`:
///     `total` is the fraction asked for, and `done` never falls. If it has a parameter `stage`, it gets the stage's
///     name, too: "take", "place", "jammed" or "prove", and before them "read" where the specimen is a surface. When it returns
///     False, the best valid packing found so far is returned.
///
/// Returns
/// -------
/// Packing
///     Also where the target was not reached: `report()["stop_reason"]` says why.
///
/// Raises
/// ------
/// ValueError, TypeError
///     For a spec that cannot be, before any work starts.
/// OSError
///     Where the spec's file cannot be read.
/// TimeoutError
///     Where the time limit ended the proof of the specimen's surface, so that there is nothing to return.
/// KeyboardInterrupt
///     On Ctrl-C, within 0.2 s.
///
/// Warns
/// -----
/// UserWarning
///     Before the work, where the target exceeds the fraction that the strategy was measured to reach, or a class is
///     too small for a single aggregate.
#[pyfunction]
#[pyo3(
    signature = (spec=None, *, seed=None, fraction=None, threads=None, time_limit=None, for_test=false, method=None,
        element_size=None, progress=None, **others),
    text_signature = "(spec=None, *, seed=None, fraction=None, threads=None, time_limit=None, for_test=False, method=None, element_size=None, progress=None)"
)]
#[allow(clippy::too_many_arguments, reason = "keywords of one call")]
pub(crate) fn pack(
    py: Python<'_>,
    spec: Option<&Bound<'_, PyAny>>,
    seed: Option<&Bound<'_, PyAny>>,
    fraction: Option<&Bound<'_, PyAny>>,
    threads: Option<&Bound<'_, PyAny>>,
    time_limit: Option<&Bound<'_, PyAny>>,
    for_test: bool,
    method: Option<&Bound<'_, PyAny>>,
    element_size: Option<&Bound<'_, PyAny>>,
    progress: Option<&Bound<'_, PyAny>>,
    others: Option<&Bound<'_, PyDict>>,
) -> PyResult<PyPacking> {
    guard(|| {
        others.and_then(|others| others.keys().iter().next()).map_or(Ok(()), |name| Err(unknown(&name)))?;
        let given = spec::given(spec)?;
        let seed = seed.map(checked_seed).transpose()?;
        let fraction = fraction.map(checked_fraction).transpose()?;
        let seconds = |limit| checked_number("time_limit", "a number of seconds", limit);
        let time_limit = time_limit.map(seconds).transpose()?;
        let over = Over { seed, fraction, time_limit_s: time_limit, ..Over::default() };
        over.accept(Giver::Keywords).map_err(|fault| raised(&fault))?;
        let threads = threads.map(checked_threads).transpose()?;
        let wanted = mesh::table(method, element_size, &PyDict::new(py))?;
        let progress = listener(py, progress)?;
        let plan = Plan::new(&STAGES, fraction);
        let mut spec = match given.may_take_long() {
            true => {
                let read = move |watch: &Watch| given.read(watch, time_limit);
                beside_python_on(py, threads, progress.as_ref(), Some(plan.clone()), read)??
            }
            false => given.read(&Silent, None)?,
        };
        over.lay(&mut spec);
        spec.validate().map_err(|error| spec::spec_error(&error))?;
        if for_test || wanted != MeshTable::default() {
            spec = leave_room(py, spec, wanted, mesh::purpose(for_test))?;
        }
        warn_of(py, &spec)?;
        let plan = plan.of_whole(spec.fraction);
        let work = move |watch: &Watch| meso_core::pack(&spec, watch);
        let model = beside_python_on(py, threads, progress.as_ref(), Some(plan), work)?;
        Ok(PyPacking(Arc::new(model.map_err(|error| spec::spec_error(&error))?)))
    })
}

/// The stages with their weights; the first is for surfaces alone.
const STAGES: [(Stage, f64); 4] = [(Stage::Read, 8.0), (Stage::Take, 2.0), (Stage::Place, 5.0), (Stage::Prove, 1.0)];

/// The spec with the gaps that the mesh needs and the spec leaves open.
fn leave_room(py: Python<'_>, mut spec: Spec, wanted: MeshTable, purpose: Purpose) -> PyResult<Spec> {
    let left = beside_python(py, None, move |watch| {
        let options = footing::options(&wanted, purpose, &spec, true, watch)?;
        footing::leave_room(&mut spec, &options, purpose).map(|_| spec)
    })?;
    let spec = left.map_err(mesh_error)?;
    spec.validate().map_err(|error| spec::spec_error(&error))?;
    Ok(spec)
}

/// Keywords of `pack`.
const KEYWORDS: [&str; 9] =
    ["spec", "seed", "fraction", "threads", "time_limit", "for_test", "method", "element_size", "progress"];

/// The error of an unknown keyword: a slip of the keys, or an option of the spec, which is one argument.
fn unknown(name: &Bound<'_, PyAny>) -> PyErr {
    let near = |name: &Bound<'_, PyAny>| -> PyResult<String> {
        let found = name.py().import("difflib")?.call_method1("get_close_matches", (name, KEYWORDS, 1, 0.8))?;
        found.get_item(0)?.extract()
    };
    let remedy = match near(name) {
        Ok(near) => format!("did you mean {near}?"),
        Err(_) => "what to pack is one argument, as mc.pack(mc.Spec(specimen=mc.Specimen.cube(100)))".to_owned(),
    };
    wrong_type(format!("pack() has no argument {name}; {remedy}"))
}

/// Hopeless targets and the like are `UserWarning`s at the caller's line, before the work.
fn warn_of(py: Python<'_>, spec: &Spec) -> PyResult<()> {
    let category = py.get_type::<PyUserWarning>();
    spec.doubts().into_iter().try_for_each(|doubt| PyErr::warn(py, &category, &CString::new(doubt)?, 1))
}

fn checked_seed(seed: &Bound<'_, PyAny>) -> PyResult<u64> {
    let given = || tree::type_name(seed);
    // numpy's integers count by __index__; True is a mistake.
    if seed.is_instance_of::<PyBool>() || !seed.hasattr("__index__")? {
        return Err(wrong_type(format!("seed is of type {}; it must be an int from 0 to 2^64 - 1", given())));
    }
    seed.extract().map_err(|_| wrong_value(format!("seed is {seed}; it must be an int from 0 to 2^64 - 1")))
}

fn checked_fraction(fraction: &Bound<'_, PyAny>) -> PyResult<f64> {
    checked_number("fraction", "a number above 0 and below 1", fraction)
}

/// A number; True is a mistake, and ranges are the spec's business.
fn checked_number(name: &str, accepted: &str, value: &Bound<'_, PyAny>) -> PyResult<f64> {
    let number = if value.is_instance_of::<PyBool>() { None } else { value.extract().ok() };
    let given = || tree::type_name(value);
    number.ok_or_else(|| wrong_type(format!("{name} is of type {}; it must be {accepted}", given())))
}
