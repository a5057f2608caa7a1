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

    /// Hears a remark about a file that was read: a fault that was mended, a move to the origin.
    fn remark(&mut self, name: &str, remark: &str) {
        let _ = (name, remark);
    }
}

/// No files: for a spec that must stand alone.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct NoFiles;

impl Files for NoFiles {
    fn read(&mut self, _: &str) -> io::Result<Vec<u8>> {
        Err(io::Error::other("files cannot be read here"))
    }

    fn list(&mut self, _: &str) -> io::Result<Vec<String>> {
        self.read("").map(|_| Vec::new())
    }
}

/// The bytes of a text file as text.
pub(super) fn read_text(files: &mut dyn Files, name: &str) -> io::Result<String> {
    String::from_utf8(files.read(name)?).map_err(|_| io::Error::other("it is not UTF-8; save it as plain text"))
}
