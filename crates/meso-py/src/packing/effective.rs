//! Effective properties of a packing, as dicts.

use crate::boundary::{accept_in_memory, guard, wrong_value};
use crate::run::{Plan, in_stages, listener};
use crate::spec::spec_error;
use crate::tree::{from_python, plain};
use meso_core::watch::Stage;
use meso_core::{Model, spec};
use meso_effective::{EffectiveError, EffectiveOptions, Phases, Property, effective};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::Arc;

/// What is asked for, by the names in Python.
pub(super) struct Asked<'a> {
    pub(super) what: &'a str,
    pub(super) voxel_size: Option<f64>,
    pub(super) phases: Option<&'a Bound<'a, PyAny>>,
    pub(super) axes: &'a str,
}

impl Asked<'_> {
    fn options(&self, model: &Model) -> PyResult<EffectiveOptions> {
        let what = match self.what {
            "diffusivity" => Property::Diffusivity,
            "conductivity" => Property::Conductivity,
            other => {
                return Err(wrong_value(format!(
                    "what is {other:?}; it must be one of \"diffusivity\", \"conductivity\""
                )));
            }
        };
        let size = self.voxel_size.unwrap_or_else(|| EffectiveOptions::default_voxel_size(model.spec.grading.d_min_mm));
        let axes = ['x', 'y', 'z'].map(|axis| self.axes.contains(axis));
        let named = axes.iter().filter(|axis| **axis).count();
        if named == 0 || self.axes.chars().count() != named {
            return Err(wrong_value(format!(
                "axes is {:?}; it must be some of x, y, z, each once, as in \"xz\"",
                self.axes
            )));
        }
        Ok(EffectiveOptions { axes, ..EffectiveOptions::new(what, size) })
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
    guard(|| {
        let options = asked.options(model)?;
        let phases = asked.phases(options.what)?;
        accept_in_memory("it", options.bytes(&model.spec.specimen).map_err(|error| raised(&error))?)?;
        let (model, progress) = (Arc::clone(model), listener(py, progress)?);
        let plan = Plan::new(&[(Stage::Solve, 1.0)], Some(1.0));
        let found = in_stages(py, progress.as_ref(), plan, move |watch| {
            watch.stops_soon();
            effective(&*model, &phases, &options, watch)
        })?;
        plain(py, &found.map_err(|error| raised(&error))?.0)
    })
}

fn raised(error: &EffectiveError) -> PyErr {
    match error {
        EffectiveError::Diverged { .. } => PyRuntimeError::new_err(error.to_string()),
        _ => wrong_value(error.to_string().replace("effective.voxel_size_mm", "voxel_size")),
    }
}
