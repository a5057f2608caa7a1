//! Files that appear whole or not at all, several of them as one unit.
//!
//! Every file is written beside its place under a temporary name, forced to disk, and renamed when all of them are
//! complete. Signals wait until all have their names; where one fails, those before it get their old contents back. Existing
//! files are kept unless the user gives `--force`; standard output and devices are streamed.

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
            return if stdout_is_closed() { Err(Failure::Run(CLOSED.to_owned())) } else { Ok(Self::Stdout) };
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
            Err(_) if path.is_symlink() => {
                let link = path.display();
                Err(Failure::Run(format!("{link} is a link to nothing; remove it, or name the file that it is to be")))
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

const CLOSED: &str = "standard output is closed; name a file";

/// True where the process was started with its standard output closed: the runtime puts the null device there, open for
/// reading, too, which no redirection of a shell is.
fn stdout_is_closed() -> bool {
    let is_null = std::fs::read_link("/proc/self/fd/1").is_ok_and(|file| file == Path::new("/dev/null"));
    let flags = std::fs::read_to_string("/proc/self/fdinfo/1").unwrap_or_default();
    let mode = flags.lines().find_map(|line| line.strip_prefix("flags:")).and_then(|flags| flags.trim().chars().last());
    is_null && mode == Some('2')
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
    // It is gone before a signal is heard.
    let _held = interrupt::hold();
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

    /// Gives every file its name. Where one fails, those before it become what they were.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        let mut hidden = interrupt::hold();
        let mut done = Vec::new();
        for complete in self.complete {
            let path = complete.path.clone();
            match complete.rename(&mut hidden) {
                Ok(renamed) => done.push(renamed),
                Err(error) => {
                    done.into_iter().rev().for_each(Renamed::undo);
                    return Err(Failure::file(&path, &error));
                }
            }
        }
        done.iter().for_each(|renamed| sync_folder(folder(&renamed.path)));
        drop((done, hidden));
        interrupt::end_if_told();
        Ok(())
    }
}

/// A file that has its name; what had it before goes with this, unless it is put back.
struct Renamed {
    path: PathBuf,
    before: Option<TempPath>,
}

impl Complete {
    fn rename(self, hidden: &mut Vec<PathBuf>) -> io::Result<Renamed> {
        let Self { temporary, path, force } = self;
        interrupt::step()?;
        hidden.retain(|other| other != &*temporary);
        let before = if force { second_name(&path)? } else { None };
        hidden.extend(before.as_deref().map(Path::to_owned));
        let renamed = if force { temporary.persist(&path) } else { temporary.persist_noclobber(&path) };
        renamed.map_err(|failed| failed.error)?;
        Ok(Renamed { path, before })
    }
}

impl Renamed {
    fn undo(self) {
        let _ = match self.before {
            Some(before) => before.persist(&self.path).map_err(|failed| failed.error),
            None => std::fs::remove_file(&self.path),
        };
    }
}

/// A hidden second name for a file that is there, or a copy where the file system knows no second names.
fn second_name(path: &Path) -> io::Result<Option<TempPath>> {
    if !path.exists() {
        return Ok(None);
    }
    let name = new_file(folder(path))?.into_temp_path();
    std::fs::remove_file(&name)?;
    std::fs::hard_link(path, &name).or_else(|_| std::fs::copy(path, &name).map(drop))?;
    Ok(Some(name))
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
    interrupt::step()?;
    let made = interrupt::hidden(|| new_file(folder(path)), |made| made.path())?;
    let (file, temporary) = made.into_parts();
    interrupt::step()?;
    // Who could not read what is replaced cannot read what replaces it.
    if let Ok(replaced) = std::fs::metadata(path) {
        file.set_permissions(replaced.permissions())?;
    }
    let mut out = BufWriter::with_capacity(1 << 15, file);
    write(&mut out)?;
    interrupt::step()?;
    out.into_inner().map_err(io::IntoInnerError::into_error)?.sync_all()?;
    interrupt::step()?;
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of ten writes, the `fails`-th of which fails.
    fn ten_writes(out: &mut dyn Write, fails: usize) -> io::Result<()> {
        (0..10).try_for_each(|k| {
            // Longer than any buffer on the way.
            let text = vec![b'a' + k as u8; 1 << 16];
            if k == fails { Err(io::Error::other("no more")) } else { out.write_all(&text) }
        })
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = std::fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn whichever_write_fails_of_several_files_the_old_ones_stay() {
        for force in [false, true] {
            for fails in 0..30_usize {
                let folder = tempfile::tempdir().unwrap();
                let paths = ["a", "b", "c"].map(|name| folder.path().join(name));
                if force {
                    paths.iter().for_each(|path| std::fs::write(path, "old").unwrap());
                }
                let before = names(folder.path());
                let mut unit = Unit::default();
                let fill = |unit: &mut Unit| {
                    paths.iter().enumerate().try_for_each(|(i, path)| {
                        let target = Target::new(path, force)?;
                        unit.fill(&target, force, |out| ten_writes(out, fails.wrapping_sub(10 * i)))
                    })
                };
                assert!(fill(&mut unit).is_err());
                drop(unit);
                assert_eq!(names(folder.path()), before, "write {fails} fails");
                assert!(paths.iter().all(|path| !force || std::fs::read(path).unwrap() == b"old"));
            }
        }
    }

    #[test]
    fn a_name_that_cannot_be_given_gives_the_others_back() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a", "b", "c"].map(|name| folder.path().join(name));
        paths[..2].iter().for_each(|path| std::fs::write(path, "old").unwrap());
        let mut unit = Unit::default();
        for path in &paths {
            let target = Target::new(path, true).unwrap();
            unit.fill(&target, true, |out| out.write_all(b"new")).unwrap();
        }
        // A folder of that name takes no file's place.
        std::fs::create_dir(&paths[2]).unwrap();
        assert!(unit.commit().is_err());
        assert_eq!(names(folder.path()), ["a", "b", "c"]);
        assert!(paths[..2].iter().all(|path| std::fs::read(path).unwrap() == b"old"));
    }
}
