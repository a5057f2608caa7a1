//! Specs and saved models from files or standard input.

use crate::failure::Failure;
use meso_core::spec::Files;
use meso_core::{Model, Spec, SpecError, saved};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Longest file a spec may name, bytes.
const LONGEST_INPUT: u64 = 256 << 20;
/// Longest spec that is read, bytes; a sieve table of a million rows is shorter.
const LONGEST_SPEC: u64 = 32 << 20;

/// Reads a SPEC.toml, `-` for standard input. Values that cannot be are named with their line.
pub(crate) fn spec(path: &Path) -> Result<Spec, Failure> {
    // Files that a spec names lie beside it.
    let folder = path.parent().unwrap_or(Path::new(""));
    toml(path, |text| Spec::from_toml_with(text, &mut Beside(folder)))
}

/// Reads a TOML file by `parse`, whose errors are wrong usage and named with the file.
pub(crate) fn toml<T>(path: &Path, parse: impl FnOnce(&str) -> Result<T, SpecError>) -> Result<T, Failure> {
    let bytes = read(path, LONGEST_SPEC)?;
    let name = name(path);
    let text = String::from_utf8(bytes).map_err(|error| {
        let position = error.utf8_error().valid_up_to();
        Failure::Usage(format!("{name}: byte {position} is not UTF-8; save it as plain text"))
    })?;
    parse(&text).map_err(|error| Failure::Usage(format!("{name}: {error}")))
}

/// The files in and below a folder, for a spec that lies in it.
#[derive(Clone, Copy, Debug)]
pub struct Beside<'a>(pub &'a Path);

impl Files for Beside<'_> {
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>> {
        read(&self.0.join(name), LONGEST_INPUT).map_err(|failure| io::Error::other(failure.message().to_owned()))
    }

    fn list(&mut self, folder: &str) -> io::Result<Vec<String>> {
        let path = self.0.join(folder);
        let fail = |error| io::Error::other(Failure::file(&path, &error).message().to_owned());
        let entries = std::fs::read_dir(&path).map_err(fail)?;
        entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned())).collect()
    }
}

/// Reads a saved model, `-` for standard input.
pub(crate) fn model(path: &Path) -> Result<Model, Failure> {
    let bytes = read(path, u64::MAX)?;
    saved::read(&bytes).map_err(|error| Failure::Run(format!("{}: {error}", name(path))))
}

fn name(path: &Path) -> String {
    if path == Path::new("-") { "standard input".to_owned() } else { path.display().to_string() }
}

fn read(path: &Path, limit: u64) -> Result<Vec<u8>, Failure> {
    let fail = |error: io::Error| Failure::file(path, &error);
    let source: Box<dyn Read> = if path == Path::new("-") { Box::new(io::stdin()) } else { Box::new(open(path)?) };
    let mut bytes = Vec::new();
    source.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > limit {
        return Err(Failure::Usage(format!("{} is longer than {} MB; that is no spec", name(path), limit >> 20)));
    }
    Ok(bytes)
}

/// Opens a regular file: a directory cannot be read, and a pipe without a writer would be waited for without end.
fn open(path: &Path) -> Result<File, Failure> {
    let kind = std::fs::metadata(path).map_err(|error| Failure::file(path, &error))?;
    if !kind.is_file() {
        let what = if kind.is_dir() { "a directory" } else { "no regular file" };
        return Err(Failure::Usage(format!("{} is {what}; name a file, or - for standard input", path.display())));
    }
    File::open(path).map_err(|error| Failure::file(path, &error))
}
