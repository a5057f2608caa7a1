//! The files a spec names: the core opens none, its caller does.

use std::io;

/// Reads files beside a spec; names are as the spec gives them.
pub trait Files {
    /// The bytes of a file.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>>;

    /// The names of the files in a folder, in any order.
    ///
    /// # Errors
    /// Where it cannot be read, or is no folder.
    fn list(&mut self, folder: &str) -> io::Result<Vec<String>>;

    /// The bytes of a table as text; a caller that reads workbooks takes the `sheet` of one.
    ///
    /// # Errors
    /// Where it cannot be read.
    fn read_table(&mut self, name: &str, sheet: Option<&str>) -> io::Result<Vec<u8>> {
        match sheet {
            None => self.read(name),
            Some(_) => Err(io::Error::other(
                "only Python reads sheets of a workbook; save the sheet as CSV, and leave sheet out",
            )),
        }
    }

    /// Hears a remark about a file that was read: a fault that was mended, a move to the origin.
    fn remark(&mut self, name: &str, remark: &str) {
        let _ = (name, remark);
    }
}

/// No files: for a spec that must stand alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&mut self, _: &str) -> io::Result<Vec<u8>> {
        Err(io::Error::other("files cannot be read here"))
    }

    fn list(&mut self, _: &str) -> io::Result<Vec<String>> {
        self.read("").map(|_| Vec::new())
    }
}
