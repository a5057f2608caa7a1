//! `mesocrete.gjk`: certified collision of convex hulls of points.

use crate::aggregate::PyAggregate;
use crate::arrays::points;
use crate::boundary::guard;
use crate::polyhedron::PyPolyhedron;
use crate::tree::type_name;
use meso_core::gjk::{self, GjkError, Method};
use meso_core::math::Vec3;
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;

/// Bodies read or answered between two looks for Ctrl-C: some milliseconds.
const CHUNK: usize = 4096;

/// The points of an array, or the vertices of a body of this package.
fn vertices(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<Vec3>> {
    if let Ok(body) = object.cast::<PyPolyhedron>() {
        return Ok(body.get().0.vertices().to_vec());
    }
    if let Ok(aggregate) = object.cast::<PyAggregate>() {
        return Ok(aggregate.get().0.body.vertices().to_vec());
    }
    points(name, object)
}

/// Whether the convex hulls of `a` and `b` share a point.
///
/// Parameters
/// ----------
/// a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron
///     Hulls of any dimension; closed sets, so touching counts. Magnitudes 1e-60 to 1e60, or 0.
/// method : str
///     The search that proposes the answer: "enhanced", "classical", "signed-volumes" or "exact". The answer is
///     certified and does not depend on it.
///
/// Raises
/// ------
/// ValueError, TypeError
///     For arrays that are no (n, 3) array of finite numbers, and for an unknown method.
#[pyfunction]
#[pyo3(signature = (a, b, method="enhanced"))]
pub(crate) fn intersects(py: Python<'_>, a: &Bound<'_, PyAny>, b: &Bound<'_, PyAny>, method: &str) -> PyResult<bool> {
    guard(|| {
        let (a, b, method) = (vertices("a", a)?, vertices("b", b)?, parse(method)?);
        py.detach(|| gjk::intersects_with(method, &a, &b)).map_err(|error| gjk_error(&error))
    })
}

/// Distance of the convex hulls of `a` and `b`, in the unit of the arrays; 0.0 exactly when they share a point.
///
/// Parameters
/// ----------
/// a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron
///
/// Raises
/// ------
/// ValueError, TypeError
///     For arrays that are no (n, 3) array of finite numbers.
#[pyfunction]
pub(crate) fn distance(py: Python<'_>, a: &Bound<'_, PyAny>, b: &Bound<'_, PyAny>) -> PyResult<f64> {
    guard(|| {
        let (a, b) = (vertices("a", a)?, vertices("b", b)?);
        py.detach(|| gjk::distance(&a, &b)).map_err(|error| gjk_error(&error))
    })
}

/// `intersects` of `a` with each of many bodies.
///
/// Parameters
/// ----------
/// a : array_like, shape (n, 3), or Aggregate, or Polyhedron
/// bodies : iterable of the same
/// method : str
///     As in `intersects`.
///
/// Returns
/// -------
/// ndarray, shape (len(bodies),), bool
#[pyfunction]
#[pyo3(signature = (a, bodies, method="enhanced"))]
pub(crate) fn intersects_many<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    bodies: &Bound<'py, PyAny>,
    method: &str,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    guard(|| {
        let (a, method) = (vertices("a", a)?, parse(method)?);
        let bodies = each(bodies)?;
        let mut answers = Vec::with_capacity(bodies.len());
        for chunk in bodies.chunks(CHUNK) {
            let chunk = || gjk::intersects_many(method, &a, chunk.iter().map(Vec::as_slice));
            answers.extend(py.detach(chunk).map_err(|error| gjk_error(&error))?);
            py.check_signals()?;
        }
        Ok(PyArray1::from_vec(py, answers))
    })
}

/// Every body as points, named by its place.
fn each(bodies: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<Vec3>>> {
    let given = type_name(bodies);
    let items = bodies.try_iter().map_err(|_| {
        PyTypeError::new_err(format!("bodies is of type {given}; it must be an iterable of (n, 3) arrays"))
    })?;
    let body = |(i, body): (usize, PyResult<Bound<'_, PyAny>>)| {
        if i % CHUNK == 0 {
            bodies.py().check_signals()?;
        }
        vertices(&format!("bodies[{i}]"), &body?)
    };
    items.enumerate().map(body).collect()
}

fn parse(method: &str) -> PyResult<Method> {
    method.parse().map_err(|error| gjk_error(&error))
}

fn gjk_error(error: &GjkError) -> PyErr {
    PyValueError::new_err(error.to_string())
}
