//! Files that appear whole or not at all, several of them as one unit.
//!
//! Every file is written beside its place under a temporary name, forced to disk, and renamed when all of them are
//! complete. Existing files are kept unless the user gives `--force`; standard output and devices are streamed.

use crate::failure::Failure;
use crate::interrupt;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// Destination of an output.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// Standard output, `-`.
    Stdout,
    /// A device or pipe that is there already.
    Stream(PathBuf),
    /// A file, written beside its name and renamed.
    File {
        /// As the user typed it.
        shown: PathBuf,
        /// Where it lies, links followed.
        path: PathBuf,
    },
}

impl Target {
    /// Inspects `path`, and refuses destinations that would be lost or cannot be created, before any work is done.
    pub(crate) fn new(path: &Path, force: bool) -> Result<Self, Failure> {
        if path == Path::new("-") {
            return Ok(Self::Stdout);
        }
        match std::fs::metadata(path) {
            Ok(kind) if kind.is_dir() => {
                Err(Failure::Run(format!("{} is a directory; name a file in it", path.display())))
            }
            Ok(kind) if !kind.is_file() => Ok(Self::Stream(path.to_owned())),
            Ok(_) if !force => Err(Failure::Run(format!("{} exists; --force replaces it", path.display()))),
            // A link is followed, so that it stays a link.
            Ok(_) => {
                let real = path.canonicalize().map_err(|error| Failure::file(path, &error))?;
                Ok(Self::File { shown: path.to_owned(), path: real })
            }
            Err(_) => probe(path).map(|()| Self::File { shown: path.to_owned(), path: path.to_owned() }),
        }
    }

    /// The name to print, where it is a file.
    pub(crate) fn file(&self) -> Option<&Path> {
        match self {
            Self::Stdout => None,
            Self::Stream(path) | Self::File { shown: path, .. } => Some(path),
        }
    }
}

/// Refuses a place no file can be made in, or a name no file can have.
fn probe(path: &Path) -> Result<(), Failure> {
    let Some(name) = path.file_name() else {
        return Err(Failure::Usage(format!("{} names no file", path.display())));
    };
    let folder = folder(path);
    if !folder.is_dir() {
        return Err(Failure::Run(format!(
            "{}: there is no folder {}; make it first",
            path.display(),
            folder.display()
        )));
    }
    if let Err(error) = std::fs::symlink_metadata(folder.join(name))
        && error.kind() != io::ErrorKind::NotFound
    {
        return Err(Failure::file(path, &error));
    }
    new_file(folder).map(drop).map_err(|error| Failure::file(path, &error))
}

fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Refuses targets that are the same file, or one of the `inputs`.
pub(crate) fn distinct(targets: &[&Target], inputs: &[&Path]) -> Result<(), Failure> {
    let real = |path: &Path| {
        let folder = folder(path).canonicalize().unwrap_or_else(|_| folder(path).to_owned());
        path.canonicalize().unwrap_or_else(|_| folder.join(path.file_name().unwrap_or_default()))
    };
    for (i, target) in targets.iter().enumerate() {
        let twice = match target {
            Target::Stdout => targets[..i].contains(&&Target::Stdout),
            Target::Stream(_) => false,
            Target::File { path, .. } => {
                targets[..i].iter().filter_map(|t| t.file()).any(|other| real(other) == real(path))
            }
        };
        let name = target.file().map_or("standard output".to_owned(), |path| path.display().to_string());
        if twice {
            return Err(Failure::Usage(format!("{name} is asked for twice; give every output its own name")));
        }
        if let Target::File { path, .. } = target
            && inputs.iter().any(|input| real(input) == real(path))
        {
            return Err(Failure::Usage(format!("{name} is the input; write to another file")));
        }
    }
    Ok(())
}

/// The files of one command while they are written.
#[derive(Default)]
pub(crate) struct Unit {
    complete: Vec<Complete>,
}

/// A file that waits for its name.
struct Complete {
    temporary: TempPath,
    path: PathBuf,
    force: bool,
}

impl Unit {
    /// Lets `write` fill one output. A failure discards every file of the unit.
    pub(crate) fn fill(
        &mut self,
        target: &Target,
        force: bool,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        match target {
            Target::Stdout => quiet_if_closed(stream(io::stdout().lock(), write))
                .map_err(|error| Failure::file(Path::new("standard output"), &error)),
            Target::Stream(path) => File::options()
                .write(true)
                .open(path)
                .and_then(|file| quiet_if_closed(stream(file, write)))
                .map_err(|error| Failure::file(path, &error)),
            Target::File { shown, path } => {
                let temporary = fill_beside(path, write).map_err(|error| Failure::file(shown, &error))?;
                self.complete.push(Complete { temporary, path: path.clone(), force });
                Ok(())
            }
        }
    }

    /// Gives every file its name. Where one fails, those before it that were not there are taken away again.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let mut made = Vec::new();
        for Complete { temporary, path, force } in self.complete {
            let hidden = temporary.to_path_buf();
            let renamed = if force { temporary.persist(&path) } else { temporary.persist_noclobber(&path) };
            interrupt::forget(&hidden);
            if let Err(failed) = renamed {
                made.iter().for_each(|path: &PathBuf| drop(std::fs::remove_file(path)));
                return Err(Failure::file(&path, &failed.error));
            }
            sync_folder(folder(&path));
            if !force {
                made.push(path);
            }
        }
        Ok(())
    }
}

fn stream(out: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    write(&mut out)?;
    out.flush()
}

/// A reader that closes early, like `head`, is no failure.
fn quiet_if_closed(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

fn fill_beside(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<TempPath> {
    let (file, temporary) = new_file(folder(path))?.into_parts();
    interrupt::remember(&temporary);
    let mut out = BufWriter::with_capacity(1 << 15, file);
    write(&mut out)?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
    Ok(temporary)
}

/// A temporary file that, unlike tempfile's default, gets the permissions any new file gets.
fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".mesocrete-").suffix(".tmp");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Makes the new name itself survive a power failure, where the system can.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
