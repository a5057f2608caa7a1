//! Files for the core's readers and writers, which open none: by extension, and whole or not at all.

use crate::boundary::{file_error, mesh_error};
use crate::run::Watch;
use meso_core::export::abaqus::DeckOptions;
use meso_core::export::vtk::Encoding;
use meso_core::formats::{Format, MeshFormat, Surfaces};
use meso_core::mesh::{self, Mesh, MeshOptions, MeshTable};
use meso_core::{Model, saved};
use meso_solve::results::{Outcome, ResultFile, Snapshot};
use pyo3::exceptions::{PyFileExistsError, PyValueError};
use pyo3::prelude::*;
use std::fs::File;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads a saved model.
///
/// # Errors
/// `OSError` where the file cannot be read, `ValueError` with its name where it is no model.
pub(crate) fn load(path: &Path, watch: &Watch) -> PyResult<Model> {
    let bytes = read(path, watch).map_err(|error| file_error(path, error))?;
    saved::read(&bytes).map_err(|error| PyValueError::new_err(format!("{}: {error}", path.display())))
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

/// Writes a model in the format that the extension of `path` names; a deck gets the default mesh.
///
/// # Errors
/// `ValueError` for an extension that names none, `OSError` where the file cannot be written.
pub(crate) fn write_model(
    model: &Model,
    path: &Path,
    overwrite: bool,
    surfaces: Surfaces,
    watch: &Watch,
) -> PyResult<()> {
    if let Some(format) = Format::from_path(path) {
        return write_whole(path, overwrite, watch, |out| format.write(model, surfaces, out));
    }
    if MeshFormat::from_path(path) == Some(MeshFormat::Inp) {
        let options = MeshOptions::try_from(MeshTable::default().with_itz_for(&model.spec.itz)).map_err(mesh_error)?;
        let mesh = mesh::build(model, &options).map_err(mesh_error)?;
        mesh::phases_kept(&mesh, &model.bodies(), &model.spec.specimen, &options).map_err(mesh_error)?;
        return write_mesh(&mesh, &DeckOptions::default(), path, overwrite, surfaces.encoding, watch);
    }
    Err(unknown_format(path, &[Format::ALL.map(Format::extension).as_slice(), &["inp"]].concat()))
}

/// Writes a mesh in the format that the extension of `path` names; `deck` counts for decks.
///
/// # Errors
/// `ValueError` for an extension that names none and for what a deck cannot hold, `OSError` where the file cannot be
/// written.
pub(crate) fn write_mesh(
    mesh: &Mesh,
    deck: &DeckOptions,
    path: &Path,
    overwrite: bool,
    encoding: Encoding,
    watch: &Watch,
) -> PyResult<()> {
    let format = MeshFormat::from_path(path);
    if format == Some(MeshFormat::Inp) {
        deck.validate(mesh).map_err(|error| PyValueError::new_err(error.to_string()))?;
    }
    let mut files = format.map(|format| format.files(path, mesh, deck));
    // Nothing lies beside a stream.
    if let (Some(files), true) = (&mut files, std::fs::metadata(path).is_ok_and(|there| !there.is_file())) {
        files.retain(|file| file.path == path);
    }
    match files.as_deref() {
        Some([file]) => write_whole(path, overwrite, watch, |out| file.write(mesh, deck, encoding, out)),
        Some(files) => {
            let paths: Vec<&Path> = files.iter().map(|file| file.path.as_path()).collect();
            write_together(&paths, overwrite, watch, |i, out| files[i].write(mesh, deck, encoding, out))
        }
        None => Err(unknown_format(path, &MeshFormat::ALL.map(MeshFormat::extension))),
    }
}

fn unknown_format(path: &Path, known: &[&str]) -> PyErr {
    let known = known.iter().map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(", ");
    PyValueError::new_err(format!("{}: the extension names no format; it must be one of {known}", path.display()))
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
    let paths: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
    write_together(&paths, overwrite, watch, |i, out| match frames.get(i) {
        Some(frame) => frame.write(outcome.mesh, out),
        None => ResultFile::ALL[i - frames.len()].write(outcome, out),
    })
}

/// Lets `write` fill all files, by their places, beside where they go, and moves them there, the last one last, when all
/// are complete.
fn write_together(
    paths: &[&Path],
    overwrite: bool,
    watch: &Watch,
    write: impl Fn(usize, &mut dyn Write) -> io::Result<()>,
) -> PyResult<()> {
    if let Some(there) = paths.iter().find(|path| !overwrite && path.exists()) {
        let message = format!("{} exists; overwrite=True replaces it", there.display());
        return Err(PyFileExistsError::new_err(message));
    }
    let complete = |(i, path): (usize, &&Path)| {
        fill_beside(path, watch, |out| write(i, out)).map_err(|error| file_error(path, error))
    };
    let made = paths.iter().enumerate().map(complete).collect::<PyResult<Vec<_>>>()?;
    for (made, path) in made.into_iter().zip(paths) {
        made.persist(path).map_err(|failed| file_error(path, failed.error))?;
    }
    Ok(())
}

/// Lets `write` fill a file beside `path` and moves it there when it is complete; devices and pipes are streamed to.
fn write_whole(
    path: &Path,
    overwrite: bool,
    watch: &Watch,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> PyResult<()> {
    if !overwrite && path.exists() {
        return Err(PyFileExistsError::new_err(format!("{} exists; overwrite=True replaces it", path.display())));
    }
    let written = match std::fs::metadata(path) {
        Ok(there) if !there.is_file() => {
            File::options().write(true).open(path).and_then(|file| stream(Watched { file, watch }, write))
        }
        // A link is followed, so that it stays a link.
        Ok(_) => path.canonicalize().and_then(|real| fill_and_move(&real, watch, write)),
        Err(_) => fill_and_move(path, watch, write),
    };
    written.map_err(|error| file_error(path, error))
}

fn stream(out: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    write(&mut out)?;
    out.flush()
}

fn fill_and_move(path: &Path, watch: &Watch, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    fill_beside(path, watch, write)?.persist(path).map(drop).map_err(|failed| failed.error)
}

/// A complete file beside `path`, which waits for its name.
fn fill_beside(
    path: &Path,
    watch: &Watch,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<tempfile::NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    watch.has_files();
    let mut out = BufWriter::with_capacity(1 << 20, Watched { file: new_file(folder)?, watch });
    write(&mut out)?;
    let Watched { file, .. } = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.as_file().sync_all()?;
    go_on(watch)?;
    Ok(file)
}

/// A file that takes and gives no more where the work is to stop, so that a temporary one is given up.
struct Watched<'a, F> {
    file: F,
    watch: &'a Watch,
}

impl<F: Read> Read for Watched<'_, F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        go_on(self.watch)?;
        let some = buffer.len().min(AT_ONCE);
        self.file.read(&mut buffer[..some])
    }
}

impl<F: Write> Write for Watched<'_, F> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        go_on(self.watch)?;
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// An error where the work is to stop. It is not called interrupted, since that means to try again.
fn go_on(watch: &Watch) -> io::Result<()> {
    if watch.goes_on() { Ok(()) } else { Err(io::Error::other("stopped")) }
}

/// A temporary file; unlike tempfile's own it gets the permissions any new file gets, and errors keep their number.
fn new_file(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let new = |path: &Path| File::options().write(true).create_new(true).open(path);
    tempfile::Builder::new().prefix(".mesocrete-").suffix(".tmp").make_in(folder, new)
}
