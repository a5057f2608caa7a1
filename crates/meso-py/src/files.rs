//! Files for the core's readers and writers, which open none: by extension, and whole or not at all.

use crate::boundary::{file_error, mesh_error, wrong_value};
use crate::run::Watch;
use meso_ask::Giver;
use meso_ask::footing::Footing;
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::{Format, ImageFormat, MeshFormat, SurfaceOptions};
use meso_core::import::volume::{self, Volume, Wanted};
use meso_core::mesh::{CellKind, Mesh, MeshTable, Purpose, Tools};
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::{Model, page, saved};
use meso_files::free;
use meso_files::whole::{self, Keeper, Unit, beginning};
use meso_solve::results::{Moment, Outcome, ResultFile, Snapshot};
use pyo3::exceptions::PyFileExistsError;
use pyo3::prelude::*;
use std::cell::RefCell;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads a saved model.
///
/// # Errors
/// `OSError` where the file cannot be read, `ValueError` with its name where it is no model.
pub(crate) fn load(path: &Path, watch: &Watch) -> PyResult<Model> {
    let bytes = read(path, watch).map_err(|error| file_error(path, error))?;
    saved::read_while(&bytes, watch).map_err(|error| wrong_value(format!("{}: {error}", path.display())))
}

/// Reads a label volume, of a `.vti` the array of a name.
///
/// # Errors
/// `OSError` where the file cannot be read, `ValueError` with its name where it is no label volume.
pub(crate) fn volume(path: &Path, array: Option<&str>) -> PyResult<Volume<u16>> {
    let bytes = std::fs::read(path).map_err(|error| file_error(path, error))?;
    let wanted = Wanted { array, most_bytes: free::memory() };
    let volume = volume::read_wanted(&path.to_string_lossy(), &bytes, &wanted);
    volume.map_err(|error| wrong_value(format!("{}: {error}", path.display())))
}

/// Bytes that are read at a time: about a millisecond's worth.
const AT_ONCE: usize = 1 << 20;

/// The bytes of a file, or an error where the work is to stop.
fn read(path: &Path, watch: &Watch) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let mut bytes = Vec::with_capacity(file.metadata().map_or(0, |there| there.len() as usize));
    Watched { file, watch }.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A file that gives no more where the work is to stop.
struct Watched<'a> {
    file: File,
    watch: &'a Watch,
}

impl Read for Watched<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        Stop(self.watch).goes_on()?;
        let some = buffer.len().min(AT_ONCE);
        self.file.read(&mut buffer[..some])
    }
}

/// Writes a model in the format that the extension of `path` names; a deck gets the default mesh.
///
/// # Errors
/// `ValueError` for an extension that names none, `OSError` where the file cannot be written.
pub(crate) fn write_model(
    model: &Model,
    path: &Path,
    overwrite: bool,
    surfaces: SurfaceOptions,
    watch: &Watch,
) -> PyResult<()> {
    let format = Format::from_path(path);
    let is_deck = format.is_none() && MeshFormat::from_path(path) == Some(MeshFormat::Inp);
    if format.is_some() || is_deck || is_page(path) {
        let meshes: &[_] = if is_deck { &[MeshFormat::Inp] } else { &[] };
        let formats: Vec<Format> = format.into_iter().collect();
        let accepted = surfaces.accept(&formats, meshes).and_then(|()| surfaces.suits(&model.spec.specimen));
        accepted.map_err(|error| wrong_value(Giver::Keywords.refusal(&error)))?;
    }
    if let Some(format) = format {
        return write_together(&[path], &[], overwrite, watch, |_, out| format.write(model, surfaces, out));
    }
    if is_deck {
        let options = MeshTable::default().resolve(Purpose::Mesh, &model.spec.itz).map_err(mesh_error)?;
        let footing = Footing { purpose: Purpose::Mesh, options, accepts_phase_error: false };
        let (mesh, _) = footing.mesh(model, &Tools::default()).map_err(mesh_error)?;
        return write_mesh(&mesh, &DeckOptions::default(), path, overwrite, surfaces.compress, watch);
    }
    if is_page(path) {
        return write_page(model, path, overwrite, watch);
    }
    Err(unknown_format(path, &[Format::ALL.map(Format::extension).as_slice(), &["inp", "html"]].concat()))
}

fn is_page(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html"))
}

/// Writes the page that `mesocrete report` writes.
fn write_page(model: &Model, path: &Path, overwrite: bool, watch: &Watch) -> PyResult<()> {
    let figures =
        Statistics::of(model, &StatisticsOptions::default()).map_err(|error| wrong_value(error.to_string()))?;
    write_together(&[path], &[], overwrite, watch, |_, out| page::write(model, &figures, None, out))
}

/// Refuses keywords without effect: of a deck on this mesh, or in another format.
///
/// # Errors
/// `ValueError`.
pub(crate) fn check_deck(mesh: &Mesh, deck: &DeckOptions, path: &Path, is_given: bool, compress: bool) -> PyResult<()> {
    let surfaces = SurfaceOptions { compress, ..SurfaceOptions::default() };
    let compressed = MeshFormat::from_path(path).map_or(Ok(()), |format| surfaces.accept(&[], &[format]));
    compressed.map_err(|error| wrong_value(Giver::Keywords.refusal(&error)))?;
    match MeshFormat::from_path(path) {
        Some(format) if format.is_deck() => {
            let effects = format.check(deck).and_then(|()| deck.validate_effects(mesh.kind == CellKind::Hexahedron));
            effects.map_err(|error| wrong_value(Giver::Keywords.refusal(&error)))
        }
        Some(_) if is_given => {
            let path = path.display();
            Err(wrong_value(format!("{path}: only an .inp or a .k takes keywords of a deck; leave them out")))
        }
        _ => Ok(()),
    }
}

/// Writes a mesh in the format that the extension of `path` names; `deck` counts for decks.
///
/// # Errors
/// `ValueError` for an extension that names none and for options that a deck cannot have, `OSError` where the file cannot be
/// written.
pub(crate) fn write_mesh(
    mesh: &Mesh,
    deck: &DeckOptions,
    path: &Path,
    overwrite: bool,
    compress: bool,
    watch: &Watch,
) -> PyResult<()> {
    let format = MeshFormat::from_path(path);
    if let Some(format) = format.filter(|format| format.is_deck()) {
        let suits = deck.validate(mesh).and_then(|()| format.check(deck));
        suits.map_err(|error| wrong_value(Giver::Keywords.refusal(&error)))?;
    }
    let mut files = format.map(|format| format.files(path, mesh, deck));
    // Nothing lies beside a stream.
    if let (Some(files), true) = (&mut files, is_stream(path)) {
        files.retain(|file| file.path == path);
    }
    let (Some(format), Some(files)) = (format, files) else {
        return Err(unknown_format(path, &MeshFormat::ALL.map(MeshFormat::extension)));
    };
    let paths: Vec<&Path> = files.iter().map(|file| file.path.as_path()).collect();
    // A stream replaces nothing.
    let is_file = !is_stream(path);
    if is_file
        && format.has_script(deck)
        && let Some(why) = format.foreign_script(path, &beginning)
    {
        return Err(PyFileExistsError::new_err(why));
    }
    let left = if is_file { format.leftovers(path, &files, &beginning) } else { Vec::new() };
    write_together(&paths, &left, overwrite, watch, |i, out| files[i].write(mesh, deck, compress, out))
}

/// Whether a device or a pipe is there.
fn is_stream(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|there| !there.is_file())
}

fn unknown_format(path: &Path, known: &[&str]) -> PyErr {
    let known = known.iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(", ");
    let image = ImageFormat::from_path(path).map_or("", |_| " (an image: voxelize, section, or mesocrete image)");
    wrong_value(format!("{}: unknown format; the extension must be one of {known}{image}", path.display()))
}

/// Writes the files of a test's results into `folder`, which is made where it is not there.
///
/// # Errors
/// `OSError` where they cannot be written, or are there already.
pub(crate) fn write_results(
    outcome: &Outcome,
    frames: &[Arc<Snapshot>],
    folder: &Path,
    overwrite: bool,
    watch: &Watch,
) -> PyResult<()> {
    if !folder.is_dir() {
        std::fs::create_dir(folder).map_err(|error| file_error(folder, error))?;
    }
    let names = frames.iter().map(|frame| frame.moment.file());
    let names = names.chain(ResultFile::ALL.map(|file| file.name().to_owned()));
    let paths: Vec<PathBuf> = names.map(|name| folder.join(name)).collect();
    let there = std::fs::read_dir(folder).map_err(|error| file_error(folder, error))?;
    let there =
        there.filter_map(Result::ok).filter(|entry| Moment::number_of(&entry.file_name().to_string_lossy()).is_some());
    // Frames of a longer list than this one.
    let left: Vec<PathBuf> =
        there.map(|entry| folder.join(entry.file_name())).filter(|path| !paths.contains(path)).collect();
    let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    let still = RefCell::default();
    write_together(&paths, &left, overwrite, watch, |i, out| match frames.get(i) {
        Some(frame) => frame.write(outcome.mesh, &mut still.borrow_mut(), out),
        None => ResultFile::ALL[i - frames.len()].write(outcome, out),
    })
}

/// Refuses files that are there, unless they are to be replaced.
pub(crate) fn accept_free(paths: &[&Path], overwrite: bool) -> PyResult<()> {
    match paths.iter().find(|path| !overwrite && path.exists()) {
        Some(there) => Err(PyFileExistsError::new_err(Giver::Keywords.exists(there))),
        None => Ok(()),
    }
}

/// Lets `write` fill all files, by their numbers, beside where they go, and gives them their names when all are complete.
/// What replaced files have `left` beside them goes.
fn write_together(
    paths: &[&Path],
    left: &[PathBuf],
    overwrite: bool,
    watch: &Watch,
    write: impl Fn(usize, &mut dyn Write) -> io::Result<()>,
) -> PyResult<()> {
    accept_free(paths, overwrite)?;
    if let (Some(left), false) = (left.first(), overwrite) {
        return Err(PyFileExistsError::new_err(Giver::Keywords.is_left(left, "file")));
    }
    let mut unit = Unit::new(Stop(watch));
    for (i, path) in paths.iter().enumerate() {
        fill(&mut unit, path, overwrite, |out| write(i, out)).map_err(|error| file_error(path, error))?;
    }
    left.iter().for_each(|left| unit.remove(left.clone()));
    unit.commit().map_err(|(path, error)| file_error(&path, error))
}

/// Fills one file; devices and pipes are streamed to.
fn fill(
    unit: &mut Unit<Stop>,
    path: &Path,
    overwrite: bool,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    match std::fs::metadata(path) {
        Ok(there) if !there.is_file() => whole::stream(File::options().write(true).open(path)?, write),
        // A link is followed, so that it stays a link.
        Ok(_) => unit.fill(&path.canonicalize()?, overwrite, |out| write(out)),
        Err(_) => unit.fill(path, overwrite, |out| write(out)),
    }
}

/// The wish to stop: files take no more bytes then, and the temporary ones are given up.
#[derive(Clone, Copy)]
pub(crate) struct Stop<'a>(pub(crate) &'a Watch);

impl Keeper for Stop<'_> {
    fn step(&self) -> io::Result<()> {
        self.0.has_files();
        self.goes_on()
    }

    /// The error is not called interrupted, since that means to try again.
    fn goes_on(&self) -> io::Result<()> {
        if self.0.goes_on() { Ok(()) } else { Err(io::Error::other("stopped")) }
    }
}
