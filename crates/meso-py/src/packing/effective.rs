//! Effective properties of a packing or a label volume, as dicts.

use crate::boundary::{accept_in_memory, guard, keyword, without_unit, wrong_type, wrong_value};
use crate::run::{Plan, in_stages, listener};
use crate::spec::spec_error;
use crate::tree::{from_python, plain};
use meso_core::Watch;
use meso_core::import::volume::{LabelNumber, Volume};
use meso_core::watch::Stage;
use meso_core::{Model, spec};
use meso_effective::{
    Boundary, EffectiveError, EffectiveOptions, LabelPhases, LabelSpecimen, PhaseModuli, Phases, Property,
    StiffnessOptions, effective, effective_in_tetrahedra, effective_of_labels, stiffness, stiffness_in_tetrahedra,
    stiffness_of_labels,
};
use numpy::{PyArray1, PyArrayMethods};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Serialize;
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is asked for, by the names in Python.
pub(super) struct Asked<'a> {
    pub(super) what: &'a str,
    pub(super) voxel_size: Option<f64>,
    pub(super) method: &'a str,
    pub(super) element_size: Option<f64>,
    pub(super) phases: Option<&'a Bound<'a, PyAny>>,
    pub(super) eigenstrain: Option<&'a Bound<'a, PyAny>>,
    pub(super) axes: &'a str,
    pub(super) boundary: &'a str,
    pub(super) tolerance: Option<f64>,
}

impl Asked<'_> {
    /// The property, or none for stiffness.
    fn property(&self) -> PyResult<Option<Property>> {
        let property = match self.what {
            "diffusivity" => Some(Property::Diffusivity),
            "conductivity" => Some(Property::Conductivity),
            "stiffness" => None,
            other => {
                let accepted = "it must be one of \"diffusivity\", \"conductivity\", \"stiffness\"";
                return Err(wrong_value(format!("what is {other:?}; {accepted}")));
            }
        };
        if property.is_some() && self.eigenstrain.is_some() {
            return Err(wrong_value(format!("eigenstrain needs what=\"stiffness\", not {:?}", self.what)));
        }
        if property.is_none() && self.boundary()? != Boundary::Fixed {
            return Err(wrong_value(format!("boundary is {:?}; stiffness takes \"fixed\"", self.boundary)));
        }
        if property.is_none() && self.axes != "xyz" {
            return Err(wrong_value(format!("axes is {:?}; stiffness takes all, \"xyz\"", self.axes)));
        }
        Ok(property)
    }

    fn boundary(&self) -> PyResult<Boundary> {
        let wrong = || {
            wrong_value(format!("boundary is {:?}; it must be one of {}", self.boundary, Boundary::NAMES.join(", ")))
        };
        Boundary::named(self.boundary).ok_or_else(wrong)
    }

    /// Whether the specimen is divided into tetrahedra.
    fn in_tetrahedra(&self) -> PyResult<bool> {
        let wrong = match self.method {
            "voxel" if self.element_size.is_some() => "element_size needs method=\"lattice\"".to_owned(),
            "lattice" if self.voxel_size.is_some() => "method=\"lattice\" takes element_size".to_owned(),
            "voxel" => return Ok(false),
            "lattice" => return Ok(true),
            other => format!("method is {other:?}; it must be one of \"voxel\", \"lattice\""),
        };
        Err(wrong_value(wrong))
    }

    fn size(&self, model: &Model) -> f64 {
        let smallest = model.spec.grading.d_min_mm;
        if self.method == "lattice" {
            return self.element_size.unwrap_or_else(|| EffectiveOptions::default_element_size(smallest));
        }
        self.voxel_size.unwrap_or_else(|| EffectiveOptions::default_voxel_size(smallest))
    }

    fn options(&self, what: Property, voxel_size_mm: f64) -> PyResult<EffectiveOptions> {
        let axes = axes("axes", self.axes)?;
        if axes == [false; 3] {
            return Err(wrong_value("axes is \"\"; it must be some of x, y, z, each once, as in \"xz\""));
        }
        let usual = EffectiveOptions::new(what, voxel_size_mm);
        let tolerance = self.tolerance.unwrap_or(usual.tolerance);
        Ok(EffectiveOptions { axes, tolerance, boundary: self.boundary()?, ..usual })
    }

    fn stiffness_options(&self, voxel_size_mm: f64) -> StiffnessOptions {
        let usual = StiffnessOptions::new(voxel_size_mm);
        StiffnessOptions { tolerance: self.tolerance.unwrap_or(usual.tolerance), ..usual }
    }

    /// Strains by the name of their phase.
    fn eigenstrains(&self) -> PyResult<BTreeMap<String, f64>> {
        let Some(given) = self.eigenstrain else { return Ok(BTreeMap::new()) };
        let wrong = |_| wrong_type(format!("eigenstrain is {given}; it must be a dict of numbers by phase"));
        by_text(given)?.extract().map_err(wrong)
    }

    /// Values of this property by label.
    fn label_phases(&self, what: Option<Property>) -> PyResult<LabelPhases> {
        let table = match what {
            Some(Property::Diffusivity) => "diffusivity",
            Some(Property::Conductivity) => "conductivity",
            None => "stiffness",
        };
        let given = self.phases.map_or_else(|| Ok(json!({})), |given| from_python("phases", &by_text(given)?))?;
        let mut phases: LabelPhases =
            spec::options_from_value(&json!({ table: given })).map_err(|error| spec_error(&error))?;
        for (name, strain) in self.eigenstrains()? {
            phases.stiffness.entry(name).or_default().eigenstrain = Some(strain);
        }
        Ok(phases)
    }

    /// Elastic constants with the eigenstrains.
    fn moduli(&self) -> PyResult<PhaseModuli> {
        let read = |given| spec::options_from_value(&from_python("phases", given)?).map_err(|error| spec_error(&error));
        let mut moduli: PhaseModuli = self.phases.map_or_else(|| Ok(PhaseModuli::default()), read)?;
        for (name, strain) in self.eigenstrains()? {
            let phase = moduli.phase_mut(&name).ok_or_else(|| {
                wrong_value(format!("eigenstrain names {name:?}; it must be mortar, itz, aggregate, void or fibre"))
            })?;
            phase.eigenstrain = Some(strain);
        }
        moduli.validate().map_err(|error| raised(&error.into()))?;
        Ok(moduli)
    }

    /// The values of this property alone: `phases` is its table.
    fn phases(&self, what: Property) -> PyResult<Phases> {
        let Some(given) = self.phases else { return Ok(Phases::default()) };
        let given = spec::options_from_value(&from_python("phases", given)?).map_err(|error| spec_error(&error))?;
        Ok(match what {
            Property::Diffusivity => Phases { diffusivity: given, ..Phases::default() },
            Property::Conductivity => Phases { conductivity: given, ..Phases::default() },
        })
    }
}

/// Computes the property beside Python.
pub(super) fn compute<'py>(
    py: Python<'py>,
    model: &Arc<Model>,
    asked: &Asked<'_>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    guard(|| match asked.property()? {
        Some(what) if asked.in_tetrahedra()? => {
            let (size, phases) = (asked.size(model), asked.phases(what)?);
            let options = asked.options(what, size)?;
            let bytes = options.bytes_in_tetrahedra(&model.spec.specimen, size);
            let model = Arc::clone(model);
            solve(py, bytes, progress, move |watch| {
                effective_in_tetrahedra(&*model, &phases, &options, size, watch).map(|(found, _)| found)
            })
        }
        None if asked.in_tetrahedra()? => {
            let (size, moduli) = (asked.size(model), asked.moduli()?);
            let options = asked.stiffness_options(size);
            let bytes = options.bytes_in_tetrahedra(&model.spec.specimen, size);
            let model = Arc::clone(model);
            solve(py, bytes, progress, move |watch| {
                stiffness_in_tetrahedra(&*model, &moduli, &options, size, watch).map(|(found, _)| found)
            })
        }
        Some(what) => {
            let (options, phases) = (asked.options(what, asked.size(model))?, asked.phases(what)?);
            let bytes = options.bytes(&model.spec.specimen);
            let model = Arc::clone(model);
            solve(py, bytes, progress, move |watch| {
                effective(&*model, &phases, &options, watch).map(|(found, _)| found)
            })
        }
        None => {
            let (options, moduli) = (asked.stiffness_options(asked.size(model)), asked.moduli()?);
            let bytes = options.bytes(&model.spec.specimen);
            let model = Arc::clone(model);
            solve(py, bytes, progress, move |watch| {
                stiffness(&*model, &moduli, &options, watch).map(|(found, _)| found)
            })
        }
    })
}

/// Effective diffusivity, conductivity or stiffness of a label volume, with its error.
///
/// Every voxel has the value of its label. `fine` is the volume's own value; `tensor` is extrapolated from it and a
/// volume of every second voxel, since labels have errors of first order.
///
/// Parameters
/// ----------
/// labels : array_like of int, shape (nz, ny, nx) or (ny, nx)
///     One integer a phase, at most 256.
/// what : {"diffusivity", "conductivity", "stiffness"}
///     The property.
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
/// progress : bool or callable, optional
///     True shows a bar; a callable is called as `progress(done, total)`, from 0 to 1. When it returns False,
///     the work ends with a `RuntimeError`.
///
/// Returns
/// -------
/// Effective
///     See `Packing.effective`; names of phases are their labels.
///
/// Raises
/// ------
/// ValueError, TypeError
///     Names the option, its value and the accepted range; a label without a value.
/// RuntimeError
///     Where the equations do not converge.
#[pyfunction(name = "effective")]
#[pyo3(signature = (labels, what="diffusivity", *, voxel_size=None, phases=None, eigenstrain=None, axes="xyz", tolerance=None, periodic="", progress=None))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub(crate) fn of_labels<'py>(
    py: Python<'py>,
    labels: &Bound<'py, PyAny>,
    what: &str,
    voxel_size: Option<&Bound<'py, PyAny>>,
    phases: Option<&Bound<'py, PyAny>>,
    eigenstrain: Option<&Bound<'py, PyAny>>,
    axes: &str,
    tolerance: Option<f64>,
    periodic: &str,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let (method, boundary) = ("voxel", "fixed");
    let asked =
        Asked { what, voxel_size: None, method, element_size: None, phases, eigenstrain, axes, boundary, tolerance };
    guard(|| {
        let property = asked.property()?;
        let phases = asked.label_phases(property)?;
        let spacing_mm = spacing(voxel_size)?;
        let periodic = self::axes("periodic", periodic)?;
        let specimen = LabelSpecimen { volume: volume(labels)?, spacing_mm, periodic };
        let counts = specimen.volume.counts;
        match property {
            Some(property) => {
                phases.values(property, &specimen.volume).map_err(|error| raised(&error))?;
                let options = asked.options(property, spacing_mm[0])?;
                solve(py, Ok(options.bytes_of(counts)), progress, move |watch| {
                    effective_of_labels(&specimen, &phases, &options, watch).map(|(found, _)| found)
                })
            }
            None => {
                phases.moduli(&specimen.volume).map_err(|error| raised(&error))?;
                let options = asked.stiffness_options(spacing_mm[0]);
                solve(py, Ok(options.bytes_of(counts)), progress, move |watch| {
                    stiffness_of_labels(&specimen, &phases, &options, watch).map(|(found, _)| found)
                })
            }
        }
    })
}

/// Which of x, y, z a text names.
fn axes(keyword: &str, text: &str) -> PyResult<[bool; 3]> {
    let axes = ['x', 'y', 'z'].map(|axis| text.contains(axis));
    if text.chars().count() == axes.iter().filter(|axis| **axis).count() {
        return Ok(axes);
    }
    Err(wrong_value(format!("{keyword} is {text:?}; it must be some of x, y, z, each once, as in \"xz\"")))
}

/// A dict whose keys are text: labels are integers in Python.
fn by_text<'py>(given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let Ok(given) = given.cast::<PyDict>() else { return Ok(given.clone()) };
    let texts = PyDict::new(given.py());
    given.iter().try_for_each(|(key, value)| texts.set_item(key.str()?, value))?;
    Ok(texts.into_any())
}

/// Edges of a voxel along x, y, z, mm.
pub(super) fn spacing(given: Option<&Bound<'_, PyAny>>) -> PyResult<[f64; 3]> {
    let Some(given) = given else { return Ok([1.0; 3]) };
    let spacing = given.extract().map(|h: f64| [h; 3]).or_else(|_| given.extract::<[f64; 3]>());
    let spacing = spacing.map_err(|_| wrong_type(format!("voxel_size is {given}; it must be a number or three")))?;
    if spacing.iter().all(|h| h.is_finite() && *h > 0.0) {
        return Ok(spacing);
    }
    Err(wrong_value(format!("voxel_size is {given}; it must be a positive number, mm")))
}

/// The label volume that an array is.
pub(super) fn volume<N: LabelNumber>(labels: &Bound<'_, PyAny>) -> PyResult<Volume<N>> {
    let numpy = labels.py().import("numpy")?;
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
        _ => return Err(wrong_value(format!("labels has {} axes; it must have two or three", shape.len()))),
    };
    let flat = numpy.call_method1("ascontiguousarray", (array, "int64"))?.call_method1("reshape", (-1,))?;
    let flat = flat.cast_into::<PyArray1<i64>>()?;
    let values = flat.try_readonly().map_err(|error| wrong_value(error.to_string()))?;
    let values = values.as_slice()?.iter().copied();
    Volume::new(counts, None, values).map_err(|error| wrong_value(format!("labels: {error}")))
}

/// Runs `work` beside Python if its `bytes` fit into memory.
fn solve<'py, T: Serialize + Send + 'static>(
    py: Python<'py>,
    bytes: Result<f64, EffectiveError>,
    progress: Option<&Bound<'py, PyAny>>,
    work: impl FnOnce(&dyn Watch) -> Result<T, EffectiveError> + Send + 'static,
) -> PyResult<Bound<'py, PyAny>> {
    accept_in_memory("effective", bytes.map_err(|error| raised(&error))?, "voxel_size")?;
    let progress = listener(py, progress)?;
    let plan = Plan::new(&[(Stage::Solve, 1.0)], Some(1.0));
    let found = in_stages(py, progress.as_ref(), plan, move |watch| {
        watch.stops_soon();
        work(watch)
    })?;
    let found = plain(py, &found.map_err(|error| raised(&error))?)?;
    py.import("mesocrete._effective")?.call_method1("Effective", (found,))
}

fn raised(error: &EffectiveError) -> PyErr {
    match error {
        EffectiveError::Diverged { .. } => PyRuntimeError::new_err(error.to_string()),
        EffectiveError::Value(wrong) if wrong.table == "effective" => without_unit(wrong),
        EffectiveError::Mesh(error) => wrong_value(error.message(keyword)),
        _ => wrong_value(error.to_string()),
    }
}
