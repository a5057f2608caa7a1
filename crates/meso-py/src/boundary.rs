//! The boundary of Rust and Python: only exceptions that `except Exception` catches cross it.

use meso_ask::{AskError, Giver};
use meso_concrete::printable;
use meso_core::mesh::MeshError;
use pyo3::exceptions::{PyMemoryError, PyOSError, PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Number of a full disk, on every system.
const ENOSPC: i32 = 28;

/// Runs `work`; a panic becomes `RuntimeError("bug: ...")`.
///
/// pyo3 would raise its `PanicException`, which derives from `BaseException` and so passes every `except Exception`.
pub(crate) fn guard<T>(work: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|payload| Err(bug(&*payload)))
}

/// The exception for a panic's payload.
pub(crate) fn bug(payload: &(dyn Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panic".to_owned());
    PyRuntimeError::new_err(format!("bug: {text} (please report it with the input that led here)"))
}

/// The exception of a wrong value, with the control characters of names, keys and paths escaped.
pub(crate) fn wrong_value(message: impl AsRef<str>) -> PyErr {
    PyValueError::new_err(printable(message.as_ref()).into_owned())
}

/// The exception of a wrong type; see [`wrong_value`].
pub(crate) fn wrong_type(message: impl AsRef<str>) -> PyErr {
    PyTypeError::new_err(printable(message.as_ref()).into_owned())
}

/// A fault of a request: a wrong value, or something that could not be done.
pub(crate) fn raised(fault: &AskError) -> PyErr {
    match fault {
        AskError::Usage(message) => wrong_value(message),
        AskError::Run(message) => PyRuntimeError::new_err(printable(message).into_owned()),
        AskError::Full(message) => PyOSError::new_err((ENOSPC, printable(message).into_owned())),
    }
}

/// Refuses work that takes more memory than is free, before any of it is taken.
///
/// # Errors
/// `MemoryError`.
pub(crate) fn accept_in_memory(work: &str, bytes: f64, keyword: &str) -> PyResult<()> {
    match meso_files::free::memory() {
        Some(free) if bytes > free as f64 => {
            let (needed, free) = (bytes / 1e9, free as f64 / 1e9);
            let text = format!("{work} takes about {needed:.1} GB, and {free:.1} GB are free; take a larger {keyword}");
            Err(PyMemoryError::new_err(text))
        }
        _ => Ok(()),
    }
}

/// `error` as the `OSError` subclass of its kind, with the file's name in front.
pub(crate) fn file_error(path: &std::path::Path, error: io::Error) -> PyErr {
    match error.raw_os_error() {
        // With (errno, text, filename) Python picks FileNotFoundError, PermissionError, ... by itself.
        Some(errno) => PyOSError::new_err((errno, reason(&error), path.as_os_str().to_owned())),
        None => PyOSError::new_err(printable(&format!("{}: {error}", path.display())).into_owned()),
    }
}

/// The system's message without Rust's "(os error 2)".
fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    text.split(" (os error").next().unwrap_or(&text).to_owned()
}

/// Python's name of an option: two of them are shorter than in a spec.
pub(crate) fn keyword(key: &str) -> String {
    match key {
        "element_size_mm" => "element_size".to_owned(),
        "voxel_size_mm" => "voxel_size".to_owned(),
        key => key.to_owned(),
    }
}

/// The exception for a mesh that cannot be: the files' fault, gmsh's, or the values'.
pub(crate) fn mesh_error(error: MeshError) -> PyErr {
    let text = error.message(|key| Giver::Keywords.option(key));
    match error {
        MeshError::Files { folder, error } => file_error(&folder, error),
        MeshError::Option(wrong) => wrong_value(Giver::Keywords.refusal(&wrong)),
        MeshError::MissingGmsh { .. } => {
            PyRuntimeError::new_err(format!("{text} for this Python or on the PATH, or mesh with method=\"lattice\""))
        }
        MeshError::PhaseError { .. } => wrong_value(format!("{text}; accept_phase_error=True accepts it")),
        MeshError::Gmsh(_) | MeshError::Seam { .. } | MeshError::Stopped | MeshError::Flat { .. } => {
            PyRuntimeError::new_err(printable(&text).into_owned())
        }
        _ => wrong_value(text),
    }
}
