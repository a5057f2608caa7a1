//! `Aggregate`: one body of a packing.

use crate::arrays;
use crate::boundary::{guard, wrong_value};
use crate::polyhedron::{PyPolyhedron, offset_error};
use meso_concrete::PhaseNames;
use meso_core::Model;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::geometry::Face;
use meso_core::math::longest_distance;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// One aggregate, or one void or fibre, at its position in the specimen.
#[pyclass(name = "Aggregate", module = "mesocrete", frozen, eq)]
#[derive(PartialEq)]
pub(crate) struct PyAggregate(pub(crate) Aggregate, String);

impl PyAggregate {
    /// A body with the name of its phase.
    pub(crate) fn new(body: Aggregate, phases: &PhaseNames) -> Self {
        let name = phases.name(body.phase()).to_owned();
        Self(body, name)
    }
}

#[pymethods]
impl PyAggregate {
    /// Position in the packing, from 0; voids and fibres count on from the last aggregate.
    #[getter]
    fn id(&self) -> u32 {
        self.0.id
    }

    /// Its phase: "aggregate", "void", "fibre", or the name of one of the packing's own.
    #[getter]
    fn phase(&self) -> &str {
        &self.1
    }

    /// Index of the size class, from the finest; those of voids and of fibres follow the grading's.
    #[getter]
    fn size_class(&self) -> u16 {
        self.0.class
    }

    /// Vertex positions: ndarray, shape (n, 3), float64, mm; a copy.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::from_points(py, self.0.body.vertices())
    }

    /// Vertex indices of every face, counter-clockwise from outside: list of lists of int.
    #[getter]
    fn faces(&self) -> Vec<Vec<u32>> {
        self.0.body.faces().map(Face::to_vec).collect()
    }

    /// Faces cut into triangles: ndarray, shape (m, 3), int64.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        arrays::from_indices(py, self.0.body.triangles().flatten(), 3)
    }

    /// Volume of the outer body, ITZ shell included, mm3.
    #[getter]
    fn volume(&self) -> f64 {
        self.0.body.volume()
    }

    /// Surface of the outer body, mm2.
    #[getter]
    fn area(&self) -> f64 {
        self.0.body.area()
    }

    /// Centre of volume: ndarray, shape (3,), float64, mm.
    #[getter]
    fn centroid<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.0.body.centroid().as_slice())
    }

    /// Longest distance of two vertices, mm: the longest axis 2a.
    #[getter]
    fn size(&self) -> f64 {
        longest_distance(self.0.body.vertices())
    }

    /// Side of the smallest square hole that it passes, mm.
    #[getter]
    fn sieve_size(&self) -> f64 {
        self.0.body.sieve_size()
    }

    /// Thickness of the ITZ shell, mm.
    #[getter]
    fn itz_thickness(&self) -> f64 {
        self.0.itz_thickness_mm
    }

    /// The outer body as a `Polyhedron`.
    #[getter]
    fn body(&self) -> PyPolyhedron {
        self.0.body.clone().into()
    }

    /// The body inside the ITZ shell, or `None` where the shell takes it all.
    fn core(&self, py: Python<'_>) -> PyResult<Option<PyPolyhedron>> {
        guard(|| {
            let inner = py.detach(|| self.0.core()).map_err(|error| offset_error(&error))?;
            Ok(inner.map(PyPolyhedron::from))
        })
    }

    fn __repr__(&self) -> String {
        let Aggregate { id, class, itz_thickness_mm, body, kind, .. } = &self.0;
        let volume = body.volume();
        if *kind != Kind::Aggregate {
            return format!("Aggregate(id={id}, phase={:?}, volume={volume:.4} mm3)", kind.name());
        }
        format!(
            "Aggregate(id={id}, size_class={class}, volume={volume:.2} mm3, itz_thickness={itz_thickness_mm:.3} mm)"
        )
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_aggregate")?;
        let Aggregate { id, own, class, itz_thickness_mm, .. } = self.0;
        (restore, (self.body(), id, class, itz_thickness_mm, self.phase(), own)).into_pyobject(py)
    }
}

/// Unpickles an `Aggregate`.
#[pyfunction(name = "_restore_aggregate", signature = (body, id, size_class, itz_thickness, phase="aggregate", own=None))]
pub(crate) fn restore_aggregate(
    body: &PyPolyhedron,
    id: u32,
    size_class: u16,
    itz_thickness: f64,
    phase: &str,
    own: Option<u8>,
) -> PyResult<PyAggregate> {
    let kind = [Kind::Aggregate, Kind::Void, Kind::Fibre].into_iter().find(|kind| kind.name() == phase);
    let kind = own.map_or(kind, |_| Some(Kind::Aggregate));
    let kind = kind.ok_or_else(|| wrong_value(format!("the pickle is damaged: there is no phase {phase:?}")))?;
    let body = body.0.as_ref().clone();
    let body =
        Aggregate { id, kind, own, class: size_class, itz_thickness_mm: itz_thickness, shells: Vec::new(), body };
    Ok(PyAggregate(body, phase.to_owned()))
}

/// The voids and fibres of a packing, as copies.
pub(crate) fn inclusions(model: &Model) -> Vec<PyAggregate> {
    model.inclusions.iter().cloned().map(|body| PyAggregate::new(body, PhaseNames::COMMON)).collect()
}
