//! The package's Python part: calls into it, and the names that it and meshio have.

use meso_core::export::{CLASSES, PALETTE};
use meso_core::mesh::CellKind;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Calls `function` of the package's Python part with a packing or mesh as its first argument.
pub(crate) fn call_view<'py, T>(
    function: &str,
    subject: &Bound<'py, T>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    subject.py().import("mesocrete._views")?.getattr(function)?.call((subject.as_any(),), options)
}

/// Calls the plotting `function` with its options, so that it writes the picture to `path`.
pub(crate) fn screenshot_of<'py, T>(
    function: &str,
    subject: &Bound<'py, T>,
    path: Bound<'py, PyAny>,
    options: Option<&Bound<'py, PyDict>>,
) -> PyResult<Bound<'py, PyAny>> {
    let options = options.map_or_else(|| Ok(PyDict::new(subject.py())), |given| given.copy())?;
    options.set_item("screenshot", path)?;
    call_view(function, subject, Some(&options))
}

/// A function that makes a table of columns: a dict as it is, or a frame of the library that `frame` names, which is imported now.
pub(crate) fn framing<'py>(py: Python<'py>, frame: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
    py.import("mesocrete._frames")?.getattr("framing")?.call1((frame,))
}

/// The name that meshio has for a kind of cells.
pub(crate) fn cell_type(kind: CellKind) -> &'static str {
    match kind {
        CellKind::Tetrahedron => "tetra",
        CellKind::QuadraticTetrahedron => "tetra10",
        CellKind::Hexahedron => "hexahedron",
    }
}

/// The colours of the phases, by their labels, and of the size classes, in turn: `#rrggbb`.
#[pyfunction(name = "_colours")]
pub(crate) fn colours() -> (Vec<String>, Vec<String>) {
    let hex = |colours: &[[u8; 3]]| colours.iter().map(|[r, g, b]| format!("#{r:02x}{g:02x}{b:02x}")).collect();
    (hex(&PALETTE), hex(&CLASSES))
}
