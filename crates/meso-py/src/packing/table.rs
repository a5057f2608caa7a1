//! The bodies of a packing as columns, and single columns of its aggregates.

use crate::boundary::guard;
use crate::run::beside_python;
use meso_core::Model;
use meso_core::aggregate::Aggregate;
use meso_core::math::{Vec3, longest_distance};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::sync::Arc;

/// Measures of a body.
struct Row {
    size: f64,
    sieve_size: f64,
    volume: f64,
    area: f64,
    sphericity: f64,
    centroid: Vec3,
}

impl Row {
    fn of(aggregate: &Aggregate) -> Self {
        let (body, mass) = (&aggregate.body, aggregate.body.mass_properties());
        let (size, sieve_size) = (longest_distance(body.vertices()), body.sieve_size());
        let (area, sphericity) = (body.area(), body.sphericity());
        Self { size, sieve_size, volume: mass.volume, area, sphericity, centroid: mass.centroid }
    }
}

/// All columns of all bodies.
///
/// # Errors
/// `KeyboardInterrupt` on Ctrl-C.
pub(crate) fn of<'py>(py: Python<'py>, model: &Arc<Model>) -> PyResult<Bound<'py, PyDict>> {
    guard(|| {
        let shared = Arc::clone(model);
        let rows: Vec<Row> = beside_python(py, None, move |_| shared.bodies().par_iter().map(Row::of).collect())?;
        let bodies = model.bodies();
        let integers = |value: &dyn Fn(&Aggregate) -> i64| PyArray1::from_iter(py, bodies.iter().map(value));
        let reals = |value: &dyn Fn(&Row) -> f64| PyArray1::from_iter(py, rows.iter().map(value));
        let table = PyDict::new(py);
        table.set_item("id", integers(&|body| i64::from(body.id)))?;
        table.set_item("class", integers(&|body| i64::from(body.class)))?;
        let names = model.spec.phases();
        let phases: Vec<&str> = bodies.iter().map(|body| names.name(body.phase())).collect();
        table.set_item("phase", py.import("numpy")?.call_method1("array", (phases,))?)?;
        table.set_item("size_mm", reals(&|row| row.size))?;
        table.set_item("sieve_size_mm", reals(&|row| row.sieve_size))?;
        table.set_item("volume_mm3", reals(&|row| row.volume))?;
        table.set_item("area_mm2", reals(&|row| row.area))?;
        table.set_item("sphericity", reals(&|row| row.sphericity))?;
        table.set_item("centroid_x_mm", reals(&|row| row.centroid.x))?;
        table.set_item("centroid_y_mm", reals(&|row| row.centroid.y))?;
        table.set_item("centroid_z_mm", reals(&|row| row.centroid.z))?;
        let thicknesses = PyArray1::from_iter(py, bodies.iter().map(|body| body.itz_thickness_mm));
        table.set_item("itz_thickness_mm", thicknesses)?;
        table.set_item("vertices", integers(&|body| body.body.vertices().len() as i64))?;
        table.set_item("faces", integers(&|body| body.body.faces().len() as i64))?;
        Ok(table)
    })
}
