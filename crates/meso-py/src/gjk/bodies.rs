//! `Bodies`: many hulls, prepared once and asked often.

use super::{CHUNK, each, gjk_error, one_vector, vertices};
use crate::arrays::{IndexArray, PointArray, from_indices, from_points, points};
use crate::boundary::{guard, wrong_type, wrong_value};
use meso_concrete::thousands;
use meso_core::gjk::Bodies;
use meso_core::math::{Rotation, Vec3};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Arc;

/// Convex bodies that are laid out once and asked often.
///
/// Parameters
/// ----------
/// bodies : iterable of array_like, shape (n, 3), or Aggregate, or Polyhedron
///     Hulls of any dimension, closed, in one frame and any unit. Any finite numbers.
///
/// All answers are exact for the points and shifts as given, as those of `intersects` are. A solid keeps the corners of its
/// hull; points inside are dropped.
///
/// Raises
/// ------
/// ValueError, TypeError
///     For a body that is not an (n, 3) array of finite numbers; the message says which.
#[pyclass(name = "Bodies", module = "mesocrete.gjk", frozen)]
pub(crate) struct PyBodies(Arc<Bodies>);

#[pymethods]
impl PyBodies {
    #[new]
    fn new(py: Python<'_>, bodies: &Bound<'_, PyAny>) -> PyResult<Self> {
        guard(|| Self::of(py, &each(bodies)?))
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    /// The points of body `index`, in their order; of a solid the corners of its hull: ndarray, shape (n, 3), float64.
    fn points<'py>(&self, py: Python<'py>, index: usize) -> PyResult<PointArray<'py>> {
        if index >= self.0.len() {
            return Err(PyIndexError::new_err(format!("there is no body {index}; there are {}", self.0.len())));
        }
        from_points(py, self.0.points(index))
    }

    /// Whether each body shares a point with `a`.
    ///
    /// Parameters
    /// ----------
    /// a : array_like, shape (n, 3), or Aggregate, or Polyhedron
    /// shift : array_like, shape (3,), optional
    ///     Added to the points of `a`, exactly.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (len(self),), bool
    #[pyo3(signature = (a, shift=None))]
    fn intersects<'py>(
        &self,
        py: Python<'py>,
        a: &Bound<'py, PyAny>,
        shift: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        guard(|| {
            let a = one_body("a", a)?;
            let shift = shift.map_or(Ok(Vec3::zeros()), |shift| one_vector("shift", shift))?;
            let pairs: Vec<_> = (0..self.0.len() as u32).map(|i| (i, 0, shift)).collect();
            self.answer(py, &a, &pairs)
        })
    }

    /// Whether the bodies of each pair share a point.
    ///
    /// Parameters
    /// ----------
    /// pairs : array_like, shape (m, 2), int
    ///     (i, j): our body i and body j of `other`.
    /// other : Bodies, optional
    ///     These bodies themselves by default.
    /// shifts : array_like, shape (m, 3), optional
    ///     Added to the points of each second body, exactly.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m,), bool
    ///
    /// Raises
    /// ------
    /// ValueError, TypeError
    ///     For a pair of bodies that are not there, and for arrays of another shape.
    #[pyo3(signature = (pairs, other=None, shifts=None))]
    fn intersects_pairs<'py>(
        &self,
        py: Python<'py>,
        pairs: &Bound<'py, PyAny>,
        other: Option<&Bound<'py, Self>>,
        shifts: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        guard(|| {
            let others = other.map_or(&self.0, |other| &other.get().0);
            let numbers = index_pairs(pairs, self.0.len(), others.len())?;
            let shifts = match shifts {
                Some(shifts) if !numbers.is_empty() => points("shifts", shifts)?,
                _ => vec![Vec3::zeros(); numbers.len()],
            };
            if shifts.len() != numbers.len() {
                let (rows, pairs) = (shifts.len(), numbers.len());
                return Err(wrong_value(format!(
                    "shifts has {rows} rows; there must be one for each of {pairs} pairs"
                )));
            }
            let pairs: Vec<_> = numbers.into_iter().zip(shifts).map(|([i, j], shift)| (i, j, shift)).collect();
            self.answer(py, others, &pairs)
        })
    }

    /// All pairs of these bodies that share a point: ndarray, shape (k, 2), int64, in ascending order.
    fn overlapping_pairs<'py>(&self, py: Python<'py>) -> PyResult<IndexArray<'py>> {
        guard(|| {
            let pairs = py.detach(|| self.0.overlapping());
            from_indices(py, pairs.into_iter().flatten(), 2)
        })
    }

    /// At which shifts `a` keeps clear of all bodies: placement attempts.
    ///
    /// Parameters
    /// ----------
    /// a : array_like, shape (n, 3), or Aggregate, or Polyhedron
    /// shifts : array_like, shape (m, 3)
    ///     Added to the points of `a`, exactly.
    /// gap : float
    ///     The distance to exceed, at least 0, in the unit of the points.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (m,), bool
    #[pyo3(signature = (a, shifts, gap=0.0))]
    fn clear<'py>(
        &self,
        py: Python<'py>,
        a: &Bound<'py, PyAny>,
        shifts: &Bound<'py, PyAny>,
        gap: f64,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        guard(|| {
            if !(gap >= 0.0 && gap.is_finite()) {
                return Err(wrong_value(format!("gap is {gap}; it must be finite and at least 0")));
            }
            let (a, shifts) = (one_body("a", a)?, points("shifts", shifts)?);
            let mut answers = Vec::with_capacity(shifts.len());
            for chunk in shifts.chunks(ATTEMPTS) {
                let chunk = || self.0.clear(&a, 0, chunk, gap);
                answers.extend(py.detach(chunk).map_err(|error| gjk_error(&error))?);
                py.check_signals()?;
            }
            Ok(PyArray1::from_vec(py, answers))
        })
    }

    /// The bodies turned about the origin, if at all, and then displaced.
    ///
    /// Each coordinate is rounded, so that answers are exact for the points that `points` then returns.
    ///
    /// Parameters
    /// ----------
    /// positions : array_like, shape (len(self), 3)
    ///     Added to the points of each body.
    /// rotations : array_like, shape (len(self), 4), optional
    ///     Quaternions x, y, z, w, as scipy's `Rotation.as_quat` gives them; they need not be of unit length.
    ///
    /// Returns
    /// -------
    /// Bodies
    #[pyo3(signature = (positions, rotations=None))]
    fn placed(
        &self,
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        rotations: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        guard(|| {
            let n = self.0.len();
            let positions = if n == 0 { Vec::new() } else { points("positions", positions)? };
            let rotations = rotations.map_or(Ok(vec![Rotation::identity(); n]), |given| quaternions(given, n))?;
            if positions.len() != n {
                let rows = positions.len();
                return Err(wrong_value(format!(
                    "positions has {rows} rows; there must be one for each of {n} bodies"
                )));
            }
            let place = |i: usize| {
                let turn = rotations[i].to_rotation_matrix();
                self.0.points(i).iter().map(|p| turn * p + positions[i]).collect()
            };
            Self::of(py, &(0..n).map(place).collect::<Vec<Vec<Vec3>>>())
        })
    }

    fn __repr__(&self) -> String {
        format!("Bodies({} bodies)", thousands(self.0.len()))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        let py = slf.py();
        let bodies = &slf.get().0;
        let points: Vec<_> = (0..bodies.len()).map(|i| from_points(py, bodies.points(i))).collect::<PyResult<_>>()?;
        (slf.get_type(), (points,)).into_pyobject(py)
    }
}

/// Attempts between two looks for Ctrl-C: each may ask about all bodies.
const ATTEMPTS: usize = 64;

impl PyBodies {
    fn of(py: Python<'_>, bodies: &[Vec<Vec3>]) -> PyResult<Self> {
        let made = py.detach(|| Bodies::new(bodies.iter().map(Vec::as_slice)));
        Ok(Self(Arc::new(made.map_err(|error| gjk_error(&error))?)))
    }

    fn answer<'py>(
        &self,
        py: Python<'py>,
        others: &Bodies,
        pairs: &[(u32, u32, Vec3)],
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let mut answers = Vec::with_capacity(pairs.len());
        for chunk in pairs.chunks(CHUNK) {
            answers.extend(py.detach(|| self.0.overlap(others, chunk)).map_err(|error| gjk_error(&error))?);
            py.check_signals()?;
        }
        Ok(PyArray1::from_vec(py, answers))
    }
}

fn one_body(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Bodies> {
    let points = vertices(name, object)?;
    Bodies::new([points.as_slice()]).map_err(|error| gjk_error(&error))
}

/// Pairs of indices, each below its length.
fn index_pairs(object: &Bound<'_, PyAny>, own: usize, others: usize) -> PyResult<Vec<[u32; 2]>> {
    let array = object.py().import("numpy")?.call_method1("asarray", (object,))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.contains(&0) {
        return Ok(Vec::new());
    }
    if shape.len() != 2 || shape[1] != 2 {
        let shape = array.getattr("shape")?;
        return Err(wrong_value(format!("pairs has shape {shape}; it must be (m, 2)")));
    }
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !matches!(kind.as_str(), "i" | "u") {
        let dtype = array.getattr("dtype")?;
        return Err(wrong_type(format!("pairs has dtype {dtype}; it must hold integers")));
    }
    let array = array.call_method1("astype", ("int64",))?;
    let array = object.py().import("numpy")?.call_method1("ascontiguousarray", (array,))?;
    let numbers = array.cast::<PyArray2<i64>>()?.readonly();
    let pair = |(row, pair): (usize, &[i64])| {
        let known = (0..own as i64).contains(&pair[0]) && (0..others as i64).contains(&pair[1]);
        let [i, j] = [pair[0], pair[1]];
        if known {
            Ok([i as u32, j as u32])
        } else {
            Err(wrong_value(format!("pairs[{row}] is ({i}, {j}); there are {own} and {others} bodies, from 0 on")))
        }
    };
    numbers.as_slice()?.chunks_exact(2).enumerate().map(pair).collect()
}

/// Quaternions x, y, z, w, of any length but 0.
fn quaternions(object: &Bound<'_, PyAny>, n: usize) -> PyResult<Vec<Rotation>> {
    let numpy = object.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (object, "float64"))?;
    let array = array.cast::<PyArray2<f64>>().map_err(|_| wrong_rotations(&array, n))?;
    if array.shape() != [n, 4] {
        return Err(wrong_rotations(array.as_any(), n));
    }
    let rotation = |(row, q): (usize, &[f64])| {
        let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        if length.is_normal() {
            return Ok(Rotation::new_normalize([q[0], q[1], q[2], q[3]].into()));
        }
        Err(wrong_value(format!("rotations[{row}] is {q:?}; it must be finite and not 0")))
    };
    array.readonly().as_slice()?.chunks_exact(4).enumerate().map(rotation).collect()
}

fn wrong_rotations(array: &Bound<'_, PyAny>, n: usize) -> PyErr {
    let shape = array.getattr("shape").map_or_else(|_| "another".to_owned(), |shape| shape.to_string());
    wrong_value(format!("rotations has shape {shape}; it must be ({n}, 4): x, y, z, w of each body"))
}
