//! `Polyhedron` and `convex_hull`.

use crate::arrays;
use crate::boundary::{guard, wrong_value};
use meso_concrete::thousands;
use meso_core::geometry::{BodyForm, Face, HullError, OffsetError, Polyhedron, convex_hull as hull};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyArithmeticError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Arc;

/// A closed convex polyhedron, mm.
#[pyclass(name = "Polyhedron", module = "mesocrete", frozen, eq)]
#[derive(Clone, PartialEq)]
pub(crate) struct PyPolyhedron(pub(crate) Arc<Polyhedron>);

impl From<Polyhedron> for PyPolyhedron {
    fn from(body: Polyhedron) -> Self {
        Self(Arc::new(body))
    }
}

/// The convex hull of `points`.
///
/// Parameters
/// ----------
/// points : array_like, shape (n, 3), mm
///
/// Returns
/// -------
/// Polyhedron
///     The exact extreme set, outward faces, coplanar triangles merged into polygons.
///
/// Raises
/// ------
/// ValueError
///     Where the points span fewer than three dimensions (the message says how many), or are no (n, 3) array.
#[pyfunction]
pub(crate) fn convex_hull(py: Python<'_>, points: &Bound<'_, PyAny>) -> PyResult<PyPolyhedron> {
    guard(|| {
        let points = arrays::points("points", points)?;
        py.detach(|| hull(&points)).map(PyPolyhedron::from).map_err(|error| hull_error(&error))
    })
}

fn hull_error(error: &HullError) -> PyErr {
    wrong_value(error.to_string())
}

/// A thickness out of range is a wrong value; an answer that cannot be trusted is an arithmetic failure.
pub(crate) fn offset_error(error: &OffsetError) -> PyErr {
    match error {
        OffsetError::Thickness { .. } | OffsetError::NotConvex => wrong_value(error.to_string()),
        OffsetError::IllConditioned { .. } => PyArithmeticError::new_err(error.to_string()),
    }
}

#[pymethods]
impl PyPolyhedron {
    /// Vertex positions: ndarray, shape (n, 3), float64, mm; a copy.
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        arrays::from_points(py, self.0.vertices())
    }

    /// Vertex indices of every face, counter-clockwise from outside: list of lists of int.
    #[getter]
    fn faces(&self) -> Vec<Vec<u32>> {
        self.0.faces().map(Face::to_vec).collect()
    }

    /// Faces cut into triangles: ndarray, shape (m, 3), int64.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        arrays::from_indices(py, self.0.triangles().flatten(), 3)
    }

    /// Volume, mm3.
    #[getter]
    fn volume(&self) -> f64 {
        self.0.volume()
    }

    /// Surface area, mm2.
    #[getter]
    fn area(&self) -> f64 {
        self.0.area()
    }

    /// Centre of volume: ndarray, shape (3,), float64, mm.
    #[getter]
    fn centroid<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.0.centroid().as_slice())
    }

    /// The body with every face moved inwards by `thickness` (mm), or `None` where it vanishes.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     For a thickness that is negative or not finite.
    /// ArithmeticError
    ///     Where the rest is too thin, or too small, for float64 vertices to show its shape.
    fn offset(&self, py: Python<'_>, thickness: f64) -> PyResult<Option<Self>> {
        guard(|| {
            let inner = py.detach(|| self.0.inward_offset(thickness)).map_err(|error| offset_error(&error))?;
            Ok(inner.map(Self::from))
        })
    }

    fn __repr__(&self) -> String {
        let (vertices, faces) = (thousands(self.0.vertices().len()), thousands(self.0.faces().len()));
        // Six digits, without zeros at their end.
        let volume = format!("{:.5e}", self.0.volume()).parse().unwrap_or(self.0.volume());
        format!("Polyhedron({vertices} vertices, {faces} faces, volume={volume} mm3)")
    }

    /// A frozen object is its own copy.
    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_polyhedron")?;
        let (dents, is_round) = match self.0.form() {
            BodyForm::Hull => (None, false),
            BodyForm::Round(_) => (None, true),
            BodyForm::Surface => (Some(self.0.caps()), false),
        };
        (restore, (self.vertices(py)?, self.faces(), dents, is_round)).into_pyobject(py)
    }
}

/// Unpickles a `Polyhedron`; one with `dents` has its caps there, a bit for each side of its box.
#[pyfunction(name = "_restore_polyhedron", signature = (vertices, faces, dents=None, is_round=false))]
pub(crate) fn restore_polyhedron(
    vertices: &Bound<'_, PyAny>,
    faces: Vec<Vec<u32>>,
    dents: Option<u8>,
    is_round: bool,
) -> PyResult<PyPolyhedron> {
    arrays::load_numpy(vertices.py())?;
    let vertices = arrays::points("vertices", vertices)?;
    // A pickle is a stranger's data: indices that lead nowhere must not reach the geometry.
    if faces.iter().any(|face| face.len() < 3 || face.iter().any(|&i| i as usize >= vertices.len())) {
        return Err(wrong_value("the pickle is damaged: a face names a vertex that is not there"));
    }
    if dents.is_some() && faces.iter().any(|face| face.len() > 3) {
        return Err(wrong_value("the pickle is damaged: a body with dents has a face that is no triangle"));
    }
    let given = Polyhedron::from_parts(vertices, faces);
    let body = match dents {
        Some(caps) => {
            let (sides, mut body) = (given.aabb().bounded_at(caps), given.with_dents());
            body.mark_caps(&sides);
            body
        }
        None if is_round => rounded(&given)?,
        None => given,
    };
    Ok(body.into())
}

/// The ball or ellipsoid that is drawn as `given`.
fn rounded(given: &Polyhedron) -> PyResult<Polyhedron> {
    let ends = given.vertices().get(..6).map(Polyhedron::of_ends);
    let is_drawn = |body: &Polyhedron| body.vertices() == given.vertices();
    ends.filter(is_drawn)
        .ok_or_else(|| wrong_value("the pickle is damaged: its vertices are not those of an ellipsoid"))
}
