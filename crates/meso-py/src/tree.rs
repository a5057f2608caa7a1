//! Python's dicts, lists and scalars as a JSON tree, and back.

use crate::boundary::{keyword, wrong_type, wrong_value};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde::Serialize;
use serde_json::{Map, Number, Value};

/// Deeper than any spec; a dict that holds itself ends here.
const DEEPEST: usize = 16;

/// `object` (found at the dotted path `key`) as a tree; numpy scalars and arrays count as numbers and lists.
///
/// # Errors
/// Names the key: `TypeError` for objects that a spec cannot hold, `ValueError` for NaN and integers beyond 64 bits.
pub(crate) fn from_python(key: &str, object: &Bound<'_, PyAny>) -> PyResult<Value> {
    from_level(key, object, 0)
}

fn from_level(key: &str, object: &Bound<'_, PyAny>, level: usize) -> PyResult<Value> {
    if level > DEEPEST {
        return Err(wrong_value(format!("{key} is nested more than {DEEPEST} levels deep")));
    }
    if let Ok(dict) = object.cast::<PyDict>() {
        return from_dict(key, dict, level);
    }
    if object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>() {
        let items = object.try_iter()?.enumerate();
        let items = items.map(|(i, item)| from_level(&format!("{key}[{i}]"), &item?, level + 1));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    // numpy's scalars and arrays name their plain counterpart themselves.
    if object.hasattr("tolist")? && object.hasattr("dtype")? {
        return from_level(key, &object.call_method0("tolist")?, level + 1);
    }
    from_scalar(key, object)
}

fn from_dict(key: &str, dict: &Bound<'_, PyDict>, level: usize) -> PyResult<Value> {
    let mut map = Map::new();
    for (name, item) in dict {
        let name = name.cast::<PyString>().map_err(|_| {
            wrong_type(format!("{}: the names in a spec are str, not {}", place(key), type_name(&name)))
        })?;
        let name = name.to_str()?.to_owned();
        let path = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
        // None means: as if it were left out.
        if !item.is_none() {
            map.insert(name, from_level(&path, &item, level + 1)?);
        }
    }
    Ok(Value::Object(map))
}

fn from_scalar(key: &str, object: &Bound<'_, PyAny>) -> PyResult<Value> {
    if object.is_instance_of::<PyBool>() {
        return Ok(Value::Bool(object.extract()?));
    }
    if object.is_instance_of::<PyInt>() {
        let wide = || wrong_value(format!("{} is {object}; it does not fit 64 bits", keyword(key)));
        let number = object.extract::<u64>().map(Number::from).or_else(|_| object.extract::<i64>().map(Number::from));
        return number.map(Value::Number).map_err(|_| wide());
    }
    if object.is_instance_of::<PyFloat>() {
        let value: f64 = object.extract()?;
        let number = Number::from_f64(value);
        return number
            .map(Value::Number)
            .ok_or_else(|| wrong_value(format!("{} is {value}; it must be finite", keyword(key))));
    }
    if let Ok(text) = object.cast::<PyString>() {
        return Ok(Value::String(text.to_str()?.to_owned()));
    }
    Err(wrong_type(format!("{} is of type {}, which has no place in a spec", place(key), type_name(object))))
}

fn place(key: &str) -> &str {
    if key.is_empty() { "the spec" } else { key }
}

pub(crate) fn type_name(object: &Bound<'_, PyAny>) -> String {
    object.get_type().name().map_or_else(|_| "value".to_owned(), |name| name.to_string())
}

/// `value` as Python's own types.
pub(crate) fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Null => Ok(py.None().into_bound(py)),
        Value::Bool(flag) => flag.into_bound_py_any(py),
        Value::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(integer), _) => integer.into_bound_py_any(py),
            (_, Some(integer)) => integer.into_bound_py_any(py),
            _ => number.as_f64().into_bound_py_any(py),
        },
        Value::String(text) => text.into_bound_py_any(py),
        Value::Array(items) => {
            let items: Vec<_> = items.iter().map(|item| to_python(py, item)).collect::<PyResult<_>>()?;
            PyList::new(py, items).map(Bound::into_any)
        }
        Value::Object(map) => {
            let dict = PyDict::new(py);
            for (key, item) in map {
                dict.set_item(key, to_python(py, item)?)?;
            }
            Ok(dict.into_any())
        }
    }
}

/// A serialisable value as Python's own types.
pub(crate) fn plain<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let tree = serde_json::to_value(value).map_err(|error| wrong_value(error.to_string()))?;
    to_python(py, &tree)
}
