//! The `mesocrete` command, as the wheel installs it.

use crate::boundary::guard;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::io::Write;

/// Does the work that the command leaves to Python, and returns the exit code.
fn python(work: &str, request: &str) -> Result<u8, String> {
    Python::attach(|py| {
        let module = py.import(format!("mesocrete._{work}"));
        let done = module.and_then(|module| module.call_method1("of_command", (request,))?.extract());
        done.map_err(|error| error.value(py).to_string())
    })
}

/// Runs the command line `args` (the program's name first) and returns its exit code.
#[pyfunction(name = "_run_command")]
pub(crate) fn run_command(py: Python<'_>, args: Vec<OsString>) -> PyResult<u8> {
    guard(|| {
        py.detach(|| {
            let code = meso_cli::run_in(args, Some(&python));
            // Python ends the process without Rust's own clean-up, which would flush this. A closed pipe is no error.
            let _ = std::io::stdout().flush();
            Ok(code)
        })
    })
}
