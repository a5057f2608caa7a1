//! Outputs of a command. Files appear whole or not at all, all of a command as one unit.
//!
//! Signals wait until all have their names. Existing files are kept unless the user gives `--force`; standard output and
//! devices are streamed.

use crate::failure::Failure;
use crate::{interrupt, stderr};
use meso_ask::Giver;
use meso_files::whole::{self, Keeper, Output, folder, new_file};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

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
            Ok(_) if !force => Err(Failure::Run(Giver::Flags.exists(path))),
            // A link is followed, so that it stays a link.
            Ok(_) => {
                let real = path.canonicalize().map_err(|error| Failure::file(path, &error))?;
                Ok(Self::File { shown: path.to_owned(), path: real })
            }
            Err(_) if path.is_symlink() => {
                let link = path.display();
                Err(Failure::Run(format!("{link} is a broken link; remove it, or name its target")))
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

/// Refuses standard output for what is more than one stream, for this reason.
pub(crate) fn refuse_stdout(output: &Path, why: &str) -> Result<(), Failure> {
    if output == Path::new("-") {
        return Err(Failure::Usage(format!("{} - is standard output, but {why}", Giver::Flags.option("output"))));
    }
    Ok(())
}

/// Names the files among `targets` as written.
pub(crate) fn wrote<'a>(targets: impl IntoIterator<Item = &'a Target>) {
    let files = targets.into_iter().filter_map(Target::file);
    files.for_each(|path| stderr::line(format!("wrote {}", path.display())));
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
pub(crate) struct Unit(whole::Unit<Signals>);

/// Signals wait while files get their names, and find all temporary ones.
#[derive(Clone, Copy, Default)]
pub(crate) struct Signals;

impl Keeper for Signals {
    fn step(&self) -> io::Result<()> {
        interrupt::step()
    }

    fn hold<T>(&self, work: impl FnOnce(&mut Vec<PathBuf>) -> T) -> T {
        work(&mut interrupt::hold())
    }
}

impl Unit {
    /// One whose files need not outlive a power failure: see [`whole::Unit::unforced`].
    pub(crate) fn unforced() -> Self {
        Self(whole::Unit::unforced(Signals))
    }

    /// Lets `write` fill one output. Where that fails, the unit's other files still wait for their names.
    pub(crate) fn fill(
        &mut self,
        target: &Target,
        force: bool,
        write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        match target {
            Target::Stdout => quiet_if_closed(whole::stream(io::stdout().lock(), write))
                .map_err(|error| Failure::file(Path::new("standard output"), &error)),
            Target::Stream(path) => File::options()
                .write(true)
                .open(path)
                .and_then(|file| quiet_if_closed(whole::stream(file, write)))
                .map_err(|error| Failure::file(path, &error)),
            Target::File { .. } => self.fill_file(target, force, |out| write(out)),
        }
    }

    /// Fills a file in a format that seeks; streams are refused. See [`Unit::fill`].
    pub(crate) fn fill_file(
        &mut self,
        target: &Target,
        force: bool,
        write: impl FnOnce(&mut BufWriter<Output<'_, Signals>>) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let Target::File { shown, path } = target else {
            return Err(Failure::Usage("this format cannot be streamed; name a file, or take .npy".to_owned()));
        };
        self.0.fill(path, force, write).map_err(|error| Failure::file(shown, &error))
    }

    /// Removes a file that belonged to a replaced one.
    pub(crate) fn remove(&mut self, leftover: PathBuf) {
        self.0.remove(leftover);
    }

    /// Gives every file its name. If one fails, those before it get their old contents back.
    pub(crate) fn commit(self) -> Result<(), Failure> {
        self.0.commit().map_err(|(path, error)| Failure::file(&path, &error))?;
        interrupt::end_if_told();
        Ok(())
    }
}

/// A reader that closes early, like `head`, is no failure.
fn quiet_if_closed(result: io::Result<()>) -> io::Result<()> {
    match result {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
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
