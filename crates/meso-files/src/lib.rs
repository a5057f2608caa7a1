//! Files for a core that opens none: those that a spec names, read from its folder, and outputs, [`whole`] or not at all.
//! [`lock`] keeps a second process out of a folder.
#![forbid(unsafe_code)]

pub mod free;
pub mod lock;
pub mod whole;

use meso_concrete::import::bytes_of_surface;
use meso_pack::recipes::Recipe;
use meso_pack::spec::Files;
use sha2::{Digest, Sha256};
use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Longest file a spec may name, bytes.
const LONGEST_INPUT: u64 = 256 << 20;

/// The recipe that `path` names, where no such file exists: the user meant the recipe.
pub fn missing_recipe(path: &Path) -> Option<&'static str> {
    let recipe = path.to_str().and_then(Recipe::find)?;
    (!path.exists()).then_some(recipe.name)
}

/// The files in and below a folder, for a spec that lies in it.
#[derive(Clone, Copy, Debug)]
pub struct Beside<'a>(pub &'a Path);

impl Files for Beside<'_> {
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>> {
        let path = self.0.join(name);
        let fail = |error: io::Error| named(&path, &reason(&error));
        let kind = fs::metadata(&path).map_err(fail)?;
        // A pipe that a spec names and nobody fills would be waited for without end.
        if !kind.is_file() {
            let what = if kind.is_dir() { "a directory" } else { "not a regular file" };
            return Err(io::Error::other(format!("{} is {what}; name a file", path.display())));
        }
        let mut bytes = Vec::new();
        File::open(&path).map_err(fail)?.take(LONGEST_INPUT + 1).read_to_end(&mut bytes).map_err(fail)?;
        if bytes.len() as u64 > LONGEST_INPUT {
            let limit = LONGEST_INPUT >> 20;
            return Err(io::Error::other(format!("{} is longer than {limit} MB, too long for a spec", path.display())));
        }
        let needed = bytes_of_surface(name, &bytes);
        if let Some(free) = free::memory().filter(|free| *free < needed) {
            let [needed, free] = [needed, free].map(|bytes| bytes >> 20);
            let why = format!("takes about {needed} MB of memory, and {free} MB are free; save it with fewer corners");
            return Err(io::Error::other(format!("{} {why}", path.display())));
        }
        Ok(bytes)
    }

    fn list(&mut self, folder: &str) -> io::Result<Vec<String>> {
        let path = self.0.join(folder);
        let entries = fs::read_dir(&path).map_err(|error| named(&path, &reason(&error)))?;
        entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
    }
}

impl Beside<'_> {
    /// The text of a file.
    ///
    /// # Errors
    /// A file that cannot be read, or that is not UTF-8.
    pub fn text(&mut self, name: &str) -> Result<String, String> {
        let bytes = self.read(name).map_err(|error| error.to_string())?;
        String::from_utf8(bytes).map_err(|_| "it is not UTF-8; save it as plain text".to_owned())
    }
}

fn named(path: &Path, why: &str) -> io::Error {
    io::Error::other(format!("{}: {why}", path.display()))
}

/// SHA-256 of a file, as 64 hexadecimal digits.
///
/// # Errors
/// Fails with the errors of the file system.
pub fn sha256(path: &Path) -> io::Result<String> {
    let (mut file, mut hash, mut block) = (File::open(path)?, Sha256::new(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut block) {
            Ok(0) => return Ok(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()),
            Ok(count) => hash.update(&block[..count]),
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// The operating system's reason without its number, and the way out.
pub fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    let text = text.split(" (os error").next().unwrap_or(&text);
    match error.kind() {
        ErrorKind::StorageFull => format!("{text}; free some space or write elsewhere"),
        ErrorKind::PermissionDenied => format!("{text}; choose a place that you may write to"),
        ErrorKind::NotFound => format!("{text}; check the name and the folder"),
        _ => text.to_owned(),
    }
}
