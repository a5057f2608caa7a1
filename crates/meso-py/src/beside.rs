//! Files that a spec names, for Python: workbooks are read by openpyxl, remarks go to the logger `mesocrete`.

use meso_core::spec::Files;
use meso_files::Beside;
use pyo3::prelude::*;
use std::collections::BTreeSet;
use std::io;
use std::path::Path;

/// The files in and below a folder.
pub(crate) struct Told<'a> {
    files: Beside<'a>,
    /// Remarks made so far: a study reads a table for every case.
    made: BTreeSet<String>,
}

impl<'a> Told<'a> {
    pub(crate) fn beside(folder: &'a Path) -> Self {
        Self { files: Beside(folder), made: BTreeSet::new() }
    }
}

impl Files for Told<'_> {
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>> {
        self.files.read(name)
    }

    fn list(&mut self, folder: &str) -> io::Result<Vec<String>> {
        self.files.list(folder)
    }

    fn read_table(&mut self, name: &str, sheet: Option<&str>) -> io::Result<Vec<u8>> {
        let is_workbook = [".xlsx", ".xlsm"].iter().any(|ending| name.to_lowercase().ends_with(ending));
        if !is_workbook {
            return match sheet {
                None => self.read(name),
                Some(_) => Err(io::Error::other("only an .xlsx has sheets; leave sheet out")),
            };
        }
        // Asked for here, so that a missing file is named in the same words as any other.
        drop(self.read(name)?);
        let path = self.files.0.join(name);
        Python::attach(|py| {
            let text = py.import("mesocrete._workbook")?.call_method1("text", (path, sheet))?;
            text.extract::<String>().map(String::into_bytes)
        })
        .map_err(|error: PyErr| io::Error::other(Python::attach(|py| error.value(py).to_string())))
    }

    fn remark(&mut self, name: &str, remark: &str) {
        let line = format!("{}: {remark}", name.escape_debug());
        if self.made.insert(line.clone()) {
            // A logger that fails must not fail a packing.
            drop(Python::attach(|py| {
                let logger = py.import("logging")?.call_method1("getLogger", ("mesocrete",))?;
                logger.call_method1("warning", ("%s", line)).map(drop)
            }));
        }
    }
}
