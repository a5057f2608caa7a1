//! Effective properties of a packing, as dicts.

use crate::boundary::{accept_in_memory, guard, wrong_value};
use crate::run::{Plan, in_stages, listener};
use crate::spec::spec_error;
use crate::tree::{from_python, plain};
use meso_core::Watch;
use meso_core::watch::Stage;
use meso_core::{Model, spec};
use meso_effective::{
    EffectiveError, EffectiveOptions, PhaseModuli, Phases, Property, StiffnessOptions, effective, stiffness,
};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// What is asked for, by the names in Python.
pub(super) struct Asked<'a> {
    pub(super) what: &'a str,
    pub(super) voxel_size: Option<f64>,
    pub(super) phases: Option<&'a Bound<'a, PyAny>>,
    pub(super) eigenstrain: Option<&'a Bound<'a, PyAny>>,
    pub(super) axes: &'a str,
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
        if property.is_none() && self.axes != "xyz" {
            return Err(wrong_value(format!("axes is {:?}; stiffness takes all, \"xyz\"", self.axes)));
        }
        Ok(property)
    }

    fn size(&self, model: &Model) -> f64 {
        self.voxel_size.unwrap_or_else(|| EffectiveOptions::default_voxel_size(model.spec.grading.d_min_mm))
    }

    fn options(&self, what: Property, model: &Model) -> PyResult<EffectiveOptions> {
        let axes = ['x', 'y', 'z'].map(|axis| self.axes.contains(axis));
        let named = axes.iter().filter(|axis| **axis).count();
        if named == 0 || self.axes.chars().count() != named {
            return Err(wrong_value(format!(
                "axes is {:?}; it must be some of x, y, z, each once, as in \"xz\"",
                self.axes
            )));
        }
        Ok(EffectiveOptions { axes, ..EffectiveOptions::new(what, self.size(model)) })
    }

    /// Elastic constants with the eigenstrains.
    fn moduli(&self) -> PyResult<PhaseModuli> {
        let read = |given| spec::options_from_value(&from_python("phases", given)?).map_err(|error| spec_error(&error));
        let mut moduli: PhaseModuli = self.phases.map_or_else(|| Ok(PhaseModuli::default()), read)?;
        let strains =
            self.eigenstrain.map_or_else(|| Ok(BTreeMap::new()), |given| given.extract::<BTreeMap<String, f64>>())?;
        for (name, strain) in strains {
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
        Some(what) => {
            let (options, phases) = (asked.options(what, model)?, asked.phases(what)?);
            let bytes = options.bytes(&model.spec.specimen);
            solve(py, model, bytes, progress, move |model, watch| {
                effective(model, &phases, &options, watch).map(|(found, _)| found)
            })
        }
        None => {
            let (options, moduli) = (StiffnessOptions::new(asked.size(model)), asked.moduli()?);
            let bytes = options.bytes(&model.spec.specimen);
            solve(py, model, bytes, progress, move |model, watch| stiffness(model, &moduli, &options, watch))
        }
    })
}

/// Runs `work` beside Python if its `bytes` fit into memory.
fn solve<'py, T: Serialize + Send + 'static>(
    py: Python<'py>,
    model: &Arc<Model>,
    bytes: Result<f64, EffectiveError>,
    progress: Option<&Bound<'py, PyAny>>,
    work: impl FnOnce(&Model, &dyn Watch) -> Result<T, EffectiveError> + Send + 'static,
) -> PyResult<Bound<'py, PyAny>> {
    accept_in_memory("effective", bytes.map_err(|error| raised(&error))?, "voxel_size")?;
    let (model, progress) = (Arc::clone(model), listener(py, progress)?);
    let plan = Plan::new(&[(Stage::Solve, 1.0)], Some(1.0));
    let found = in_stages(py, progress.as_ref(), plan, move |watch| {
        watch.stops_soon();
        work(&model, watch)
    })?;
    plain(py, &found.map_err(|error| raised(&error))?)
}

fn raised(error: &EffectiveError) -> PyErr {
    match error {
        EffectiveError::Diverged { .. } => PyRuntimeError::new_err(error.to_string()),
        _ => wrong_value(error.to_string().replace("effective.voxel_size_mm", "voxel_size")),
    }
}
