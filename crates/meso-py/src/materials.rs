//! Material values of a concrete or a mortar.

use crate::boundary::{guard, wrong_value};
use crate::spec::options;
use crate::tree;
use meso_core::materials::{Mix, Rock};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Deserialize;

/// Keywords of [`concrete_materials`].
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    fcm: Option<f64>,
    mortar: Option<f64>,
    rock: Option<Rock>,
    fraction: f64,
}

/// The `[materials]` of a concrete by its mean strength or by its mortar's, MPa, with a rock and a share of aggregates.
#[pyfunction(name = "_concrete_materials")]
#[pyo3(signature = (**options))]
pub(crate) fn concrete_materials<'py>(
    py: Python<'py>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    guard(|| {
        let Asked { fcm, mortar, rock, fraction } = self::options(options)?;
        let mix = match (fcm, mortar) {
            (Some(fcm_mpa), None) => Mix { fcm_mpa, rock, fraction },
            (None, Some(mpa)) => Mix::of_mortar(mpa, rock, fraction),
            _ => return Err(wrong_value("give the concrete's mean strength or the mortar's, not both")),
        };
        let sourced = mix.materials().map_err(|error| wrong_value(format!("{} {}", error.key, error.fault())))?;
        tree::plain(py, &sourced.materials)
    })
}
