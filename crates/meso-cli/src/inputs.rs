//! Specs and saved models from files or standard input.

use crate::failure::Failure;
use crate::stderr::{self, flag};
use meso_ask::{AskError, Given, Over};
use meso_core::import::volume::{self, LabelNumber, Volume, Wanted};
use meso_core::spec::Files;
use meso_core::{Model, Spec, SpecError, Watch, saved};
use meso_files::{Beside, free, missing_recipe};
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Longest spec that is read, bytes; a sieve table of a million rows is shorter.
const LONGEST_SPEC: u64 = 32 << 20;
/// Longest saved model, bytes: ten million aggregates, the most that a spec may ask for, take 30 GB.
const LONGEST_MODEL: u64 = 32 << 30;
/// A model begins within so many bytes.
const HEAD: u64 = 4096;
/// A compressed one begins so.
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Reads a SPEC.toml, `-` for standard input, while `watch` waits for it; a time limit may take the place of the spec's.
/// Values of the spec that cannot be are named with their line, those `over` it before it is read.
pub(crate) fn spec(path: &Path, watch: &dyn Watch, over: &Given<Over>) -> Result<Spec, Failure> {
    over.options.accept(over.giver())?;
    let time_limit_s = over.options.time_limit_s;
    // Files that a spec names lie beside it.
    let folder = path.parent().unwrap_or(Path::new(""));
    if let Some(name) = missing_recipe(path) {
        return Err(Failure::Usage(format!("{name} is a recipe and no file; write it first: mesocrete init {name}")));
    }
    let named = |error: SpecError| error.of_limit(time_limit_s, &flag("time_limit_s"));
    let mut files = Told(Beside(folder));
    toml(path, |text| Spec::from_toml_while(text, &mut files, watch, time_limit_s).map_err(named))
}

/// Files beside a spec; remarks about them are lines on stderr.
struct Told<'a>(Beside<'a>);

impl Files for Told<'_> {
    fn read(&mut self, name: &str) -> io::Result<Vec<u8>> {
        self.0.read(name)
    }

    fn list(&mut self, folder: &str) -> io::Result<Vec<String>> {
        self.0.list(folder)
    }

    fn remark(&mut self, name: &str, remark: &str) {
        stderr::line(format!("note: {}: {remark}", name.escape_debug()));
    }
}

/// Reads a TOML file by `parse`, whose errors are wrong usage and named with the file.
pub(crate) fn toml<T>(path: &Path, parse: impl FnOnce(&str) -> Result<T, SpecError>) -> Result<T, Failure> {
    parse(&text(path)?).map_err(|error| {
        let message = format!("{}: {error}", name(path));
        if error.is_late { Failure::Late(message) } else { Failure::Usage(message) }
    })
}

/// Reads a file of text, as long as a spec may be.
pub(crate) fn text(path: &Path) -> Result<String, AskError> {
    let bytes = read(path, LONGEST_SPEC, "a spec").map_err(AskError::from)?;
    String::from_utf8(bytes).map_err(|error| {
        let position = error.utf8_error().valid_up_to();
        AskError::Usage(format!("{}: byte {position} is not UTF-8; save it as plain text", name(path)))
    })
}

/// Reads the bytes of a table, as long as a spec's may be.
pub(crate) fn table(path: &Path) -> Result<Vec<u8>, Failure> {
    read(path, LONGEST_SPEC, "a table")
}

/// Reads a saved model, `-` for standard input, and reports to `watch` how far the proof of its specimen's surface is. A file
/// that does not begin like a model is not read to its end.
pub(crate) fn model(path: &Path, watch: &dyn Watch) -> Result<Model, Failure> {
    let fail = |error: io::Error| Failure::file(path, &error);
    let mut source = source(path)?;
    let mut bytes = Vec::new();
    source.by_ref().take(HEAD).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.trim_ascii_start().starts_with(b"{") || bytes.starts_with(&GZIP) {
        read_rest(path, source, &mut bytes, LONGEST_MODEL, "a saved model")?;
    }
    saved::read_while(&bytes, watch).map_err(|error| Failure::Run(format!("{}: {error}", name(path))))
}

/// Longest label volume, bytes: a thousand million voxels of eight bytes.
const LONGEST_VOLUME: u64 = 8 << 30;

/// Reads a label volume, of a `.vti` the array of a name.
pub(crate) fn volume<N: LabelNumber>(path: &Path, array: Option<&str>) -> Result<Volume<N>, Failure> {
    let bytes = read(path, LONGEST_VOLUME, "a label volume")?;
    let wanted = Wanted { array, most_bytes: free::memory() };
    let volume = volume::read_wanted(&path.to_string_lossy(), &bytes, &wanted);
    volume.map_err(|error| Failure::Run(format!("{}: {error}", name(path))))
}

/// Warns of choices that a label volume's file left open.
pub(crate) fn warn_of_choices<N: LabelNumber>(volume: &Volume<N>, is_sized: bool) {
    let size = volume.size_remark(is_sized);
    let size = size.map(|remark| format!("warning: {remark}; {} sets another", flag("voxel_size_mm")));
    size.into_iter().chain(volume.array_note.as_ref().map(|note| format!("warning: {note}"))).for_each(stderr::line);
}

fn name(path: &Path) -> String {
    if path == Path::new("-") { "standard input".to_owned() } else { path.display().to_string() }
}

fn read(path: &Path, limit: u64, kind: &str) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    read_rest(path, source(path)?, &mut bytes, limit, kind)?;
    Ok(bytes)
}

/// Appends the rest of `source`, up to a limit of all bytes; a longer one is refused as too long for its `kind`.
fn read_rest(path: &Path, source: impl Read, bytes: &mut Vec<u8>, limit: u64, kind: &str) -> Result<(), Failure> {
    let left = limit.saturating_sub(bytes.len() as u64).saturating_add(1);
    source.take(left).read_to_end(bytes).map_err(|error| Failure::file(path, &error))?;
    if bytes.len() as u64 > limit {
        return Err(Failure::Usage(format!("{} is longer than {} MB, too long for {kind}", name(path), limit >> 20)));
    }
    Ok(())
}

/// A file, a pipe, or standard input.
fn source(path: &Path) -> Result<Box<dyn Read>, Failure> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdin()));
    }
    let fail = |error: io::Error| Failure::file(path, &error);
    if std::fs::metadata(path).map_err(fail)?.is_dir() {
        return Err(Failure::Usage(format!("{} is a directory; name a file, or - for standard input", path.display())));
    }
    Ok(Box::new(File::open(path).map_err(fail)?))
}
