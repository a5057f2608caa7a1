//! `mesocrete.gjk`: certified collision of convex hulls of points.

mod bodies;

pub(crate) use bodies::PyBodies;

use crate::aggregate::PyAggregate;
use crate::arrays::{PointArray, from_points, points};
use crate::boundary::{guard, wrong_type, wrong_value};
use crate::polyhedron::PyPolyhedron;
use crate::tree::type_name;
use meso_core::gjk::{self, Algorithm, GjkError, Impact, Penetration};
use meso_core::math::Vec3;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyList;

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
///     Hulls of any dimension; closed sets, so touching counts. Any finite numbers.
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
        py.detach(|| method.intersects(&a, &b)).map_err(|error| gjk_error(&error))
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

/// A point of each convex hull: the two that are nearest each other, or one that both share, twice.
///
/// Parameters
/// ----------
/// a, b : array_like, shape (n, 3), or Aggregate, or Polyhedron
///
/// Returns
/// -------
/// ndarray, shape (2, 3), float64
///     Row 0 lies in `a`, row 1 in `b`. Each coordinate is the exact one, rounded once.
///
/// Raises
/// ------
/// ValueError, TypeError
///     For arrays that are no (n, 3) array of finite numbers.
#[pyfunction]
pub(crate) fn closest_points<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
) -> PyResult<PointArray<'py>> {
    guard(|| {
        let (a, b) = (vertices("a", a)?, vertices("b", b)?);
        let found = py.detach(|| gjk::closest_points(&a, &b)).map_err(|error| gjk_error(&error))?;
        from_points(py, &found)
    })
}

/// A unit vector, shape (3,).
type Direction<'py> = Bound<'py, PyArray1<f64>>;

/// The fields of `mesocrete.gjk.penetration`: depth, at_least, direction.
#[pyfunction]
pub(crate) fn penetration<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
) -> PyResult<Option<(f64, f64, Direction<'py>)>> {
    guard(|| {
        let (a, b) = (vertices("a", a)?, vertices("b", b)?);
        let found = py.detach(|| Penetration::of(&a, &b)).map_err(|error| gjk_error(&error))?;
        Ok(found.map(|Penetration { depth, at_least, direction }| (depth, at_least, vector(py, &direction))))
    })
}

/// The fields of `mesocrete.gjk.time_of_impact`: not_before, by, direction.
#[pyfunction]
pub(crate) fn time_of_impact<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
    motion: &Bound<'py, PyAny>,
) -> PyResult<Option<(f64, Option<f64>, Direction<'py>)>> {
    guard(|| {
        let (a, b, motion) = (vertices("a", a)?, vertices("b", b)?, one_vector("motion", motion)?);
        let found = py.detach(|| Impact::of(&a, &b, &motion)).map_err(|error| gjk_error(&error))?;
        Ok(found.map(|Impact { not_before, by, direction }| (not_before, by, vector(py, &direction))))
    })
}

fn vector<'py>(py: Python<'py>, v: &Vec3) -> Direction<'py> {
    PyArray1::from_slice(py, v.as_slice())
}

/// An array of shape (3,).
fn one_vector(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec3> {
    let row = PyList::new(object.py(), [object])?;
    match points(name, &row) {
        Ok(rows) => Ok(rows[0]),
        Err(error) => Err(wrong_value(format!("{name} must be three finite numbers ({})", error.value(object.py())))),
    }
}

/// `intersects` of `a` with each of many bodies.
///
/// Boxes separate most bodies. To ask about the same bodies again, make `Bodies` of them.
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
            let chunk = || method.intersects_many(&a, chunk.iter().map(Vec::as_slice));
            answers.extend(py.detach(chunk).map_err(|error| gjk_error(&error))?);
            py.check_signals()?;
        }
        Ok(PyArray1::from_vec(py, answers))
    })
}

/// Every body as points, named by its place.
fn each(bodies: &Bound<'_, PyAny>) -> PyResult<Vec<Vec<Vec3>>> {
    let given = type_name(bodies);
    let items = bodies
        .try_iter()
        .map_err(|_| wrong_type(format!("bodies is of type {given}; it must be an iterable of (n, 3) arrays")))?;
    let body = |(i, body): (usize, PyResult<Bound<'_, PyAny>>)| {
        if i % CHUNK == 0 {
            bodies.py().check_signals()?;
        }
        vertices(&format!("bodies[{i}]"), &body?)
    };
    items.enumerate().map(body).collect()
}

fn parse(method: &str) -> PyResult<Algorithm> {
    method.parse().map_err(|error| gjk_error(&error))
}

fn gjk_error(error: &GjkError) -> PyErr {
    wrong_value(error.to_string())
}
