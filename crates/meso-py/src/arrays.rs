//! Points from Python and back: accepted (n, 3) arrays, and the errors for the rest.

use crate::boundary::{wrong_type, wrong_value};
use meso_core::math::Vec3;
use meso_core::mesh::Mesh;
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::type_object::PyTypeInfo;
use pyo3::types::PyDict;

/// Points by rows: shape (n, 3), float64.
pub(crate) type PointArray<'py> = Bound<'py, PyArray2<f64>>;
/// Indices by rows: shape (n, width), int64.
pub(crate) type IndexArray<'py> = Bound<'py, PyArray2<i64>>;

/// From 2^53 on, f64 cannot represent neighbouring integers apart.
const FIRST_DOUBTFUL_INTEGER: f64 = 9_007_199_254_740_992.0;

/// Copies `object` (the argument called `name`) into points, while the GIL keeps others from changing it.
///
/// Anything `numpy.asarray` makes an (n, 3) array of real numbers of, n >= 1, in whatever order, stride or byte order.
///
/// # Errors
/// `TypeError` where the entries are not numbers; `ValueError` for another shape, for masked entries, for integers
/// of 2^53 or more and for NaN or infinity, with the row.
pub(crate) fn points(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<Vec3>> {
    let points = match plain(object)? {
        Some(points) => points,
        None => converted(name, object)?,
    };
    if points.is_empty() {
        return Err(wrong_shape(name, "(0, 3)"));
    }
    match points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        Some(row) => {
            Err(wrong_value(format!("{name}[{row}] is {}; every coordinate must be finite", triple(&points[row]))))
        }
        None => Ok(points),
    }
}

/// Loads numpy's function tables before the first array. Loaded lazily, any error there, even Ctrl-C, would be a
/// panic. The package imports numpy before it hands out a name; functions that pickle calls without the package do it here.
///
/// # Errors
/// Where numpy cannot be imported.
pub(crate) fn load_numpy(py: Python<'_>) -> PyResult<()> {
    numpy::get_array_module(py)?;
    PyArray1::<u8>::from_slice(py, &[]).try_readonly().map(drop).map_err(|error| wrong_value(error.to_string()))
}

/// The fast path: a plain, aligned, C-ordered float64 array of three columns.
fn plain(object: &Bound<'_, PyAny>) -> PyResult<Option<Vec<Vec3>>> {
    // `cast` checks dtype, byte order and dimensions, and lets subclasses (masked arrays) pass; `cast_exact` does the
    // reverse.
    let Ok(array) = object.cast::<PyArray2<f64>>() else { return Ok(None) };
    if !object.get_type().is(PyArray2::<f64>::type_object(object.py())) {
        return Ok(None);
    }
    // numpy's slices check the order, but not the alignment, which reading them takes for granted.
    let aligned = array.getattr("flags")?.getattr("aligned")?.extract::<bool>()?;
    if !aligned || !array.is_c_contiguous() || array.shape()[1] != 3 {
        return Ok(None);
    }
    Ok(Some(rows(array.readonly().as_slice()?)))
}

/// The slow path: through numpy, with every refusal explained.
fn converted(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<Vec3>> {
    let numpy = object.py().import("numpy")?;
    let array = numpy.call_method1("asanyarray", (object,)).map_err(|error| not_an_array(name, object, error))?;
    if numpy.getattr("ma")?.call_method1("is_masked", (&array,))?.is_truthy()? {
        return Err(wrong_value(format!("{name} has masked entries; fill or drop them first")));
    }
    check_kind(name, &array)?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.len() != 2 || shape[1] != 3 || shape[0] == 0 {
        return Err(wrong_shape(name, &array.getattr("shape")?.to_string()));
    }
    let options = PyDict::new(object.py());
    options.set_item("dtype", numpy.getattr("float64")?)?;
    options.set_item("order", "C")?;
    let copy = numpy.call_method("array", (&array,), Some(&options))?;
    let points = rows(copy.cast::<PyArray2<f64>>()?.readonly().as_slice()?);
    check_integers(name, &array, &points)?;
    Ok(points)
}

fn rows(flat: &[f64]) -> Vec<Vec3> {
    flat.chunks_exact(3).map(Vec3::from_column_slice).collect()
}

/// Real numbers only: a bool, an object or a date is more likely a mistake than a coordinate.
fn check_kind(name: &str, array: &Bound<'_, PyAny>) -> PyResult<()> {
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if matches!(kind.as_str(), "f" | "i" | "u") {
        return Ok(());
    }
    // numpy types an empty list float64, so any other dtype here holds something that is no number.
    Err(wrong_type(format!("{name} has dtype {dtype}; it must hold real numbers (float or int)")))
}

/// Integers f64 cannot hold are refused, not rounded.
fn check_integers(name: &str, array: &Bound<'_, PyAny>, points: &[Vec3]) -> PyResult<()> {
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    let beyond = |p: &Vec3| p.iter().any(|x| x.abs() >= FIRST_DOUBTFUL_INTEGER);
    match points.iter().position(beyond) {
        Some(row) if kind != "f" => Err(wrong_value(format!(
            "{name}[{row}] holds an integer of 2^53 or more, which float64 cannot represent exactly"
        ))),
        _ => Ok(()),
    }
}

/// A ragged list is a wrong value; objects that numpy cannot convert keep numpy's own exception.
fn not_an_array(name: &str, object: &Bound<'_, PyAny>, error: PyErr) -> PyErr {
    if error.is_instance_of::<PyValueError>(object.py()) {
        return wrong_value(format!("{name} is not an (n, 3) array: {}", error.value(object.py())));
    }
    error
}

fn wrong_shape(name: &str, shape: &str) -> PyErr {
    wrong_value(format!("{name} has shape {shape}; it must be (n, 3) with n >= 1"))
}

fn triple(p: &Vec3) -> String {
    format!("({:?}, {:?}, {:?})", p.x, p.y, p.z)
}

/// `points` as a new (n, 3) float64 array that belongs to the caller.
pub(crate) fn from_points<'py>(py: Python<'py>, points: &[Vec3]) -> PyResult<PointArray<'py>> {
    let flat: Vec<f64> = points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    PyArray1::from_vec(py, flat).reshape([points.len(), 3])
}

/// The ids of the bodies that cells belong to as a new int64 array, -1 in the mortar.
pub(crate) fn from_ids<'py>(py: Python<'py>, ids: impl Iterator<Item = u32>) -> Bound<'py, PyArray1<i64>> {
    let id = |id: u32| if id == Mesh::NO_BODY { -1 } else { i64::from(id) };
    PyArray1::from_vec(py, ids.map(id).collect())
}

/// Rows of `width` indices as a new int64 array.
pub(crate) fn from_indices<'py>(
    py: Python<'py>,
    flat: impl IntoIterator<Item = u32>,
    width: usize,
) -> PyResult<IndexArray<'py>> {
    let flat: Vec<i64> = flat.into_iter().map(i64::from).collect();
    let rows = flat.len() / width;
    PyArray1::from_vec(py, flat).reshape([rows, width])
}
