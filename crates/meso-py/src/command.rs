//! The `mesocrete` command, as the wheel installs it.

use crate::boundary::guard;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::io::Write;

/// Runs the command line `args` (the program's name first) and returns its exit code.
#[pyfunction(name = "_run_command")]
pub(crate) fn run_command(py: Python<'_>, args: Vec<OsString>) -> PyResult<u8> {
    guard(|| {
        py.detach(|| {
            let code = meso_cli::run(args);
            // Python ends the process without Rust's own clean-up, which would flush this. A closed pipe is no error.
            let _ = std::io::stdout().flush();
            Ok(code)
        })
    })
}
