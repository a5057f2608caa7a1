//! A folder in memory, for specs that name files.

use meso_core::spec::Files;
use std::io;

/// Names with their folder, and bytes.
pub(crate) struct Folder<'a>(pub(crate) &'a [(&'a str, &'a [u8])]);

impl Files for Folder<'_> {
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>> {
        let file = self.0.iter().find(|file| file.0 == name);
        file.map(|file| file.1.to_vec()).ok_or_else(|| io::Error::other("there is no such file"))
    }

    fn list(&mut self, folder: &str) -> io::Result<Vec<String>> {
        let inside = format!("{}/", folder.trim_end_matches('/'));
        Ok(self.0.iter().filter_map(|file| Some(file.0.strip_prefix(&inside)?.to_owned())).collect())
    }
}

/// A folder that keeps the remarks about its file.
pub(crate) struct Heard<'a>(pub(crate) Folder<'a>, pub(crate) Vec<String>);

impl Files for Heard<'_> {
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>> {
        self.0.read(name)
    }

    fn list(&mut self, folder: &str) -> io::Result<Vec<String>> {
        self.0.list(folder)
    }

    fn remark(&mut self, name: &str, remark: &str) {
        self.1.push(format!("{name}: {remark}"));
    }
}
