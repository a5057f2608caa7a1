//! Files that appear whole or not at all, several of them as one unit.
//!
//! Every file is written beside its place under a temporary name, as a rule forced to disk, and renamed when all of them
//! are complete. Where one cannot get its name, those before it get their old contents back.

use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use tempfile::{NamedTempFile, TempPath};

/// Names of files that are being written: a prefix and a suffix.
pub const UNFINISHED: (&str, &str) = (".mesocrete-", ".tmp");

/// Bytes that reach a file together.
const BLOCK: usize = 1 << 16;

/// Who may stop the writing, and who removes temporary files where the process ends in between.
pub trait Keeper {
    /// Asked between two steps of the writing.
    ///
    /// # Errors
    /// Any, to stop it.
    fn step(&self) -> io::Result<()> {
        Ok(())
    }

    /// Asked before each block of bytes.
    ///
    /// # Errors
    /// Any, to stop the writing.
    fn goes_on(&self) -> io::Result<()> {
        Ok(())
    }

    /// Runs `work`, which makes, renames and removes temporary files and keeps the list of them up to date. The process
    /// must not end meanwhile.
    fn hold<T>(&self, work: impl FnOnce(&mut Vec<PathBuf>) -> T) -> T {
        work(&mut Vec::new())
    }
}

/// Nobody stops the writing.
impl Keeper for () {}

/// The files of one task while they are written. One that is dropped leaves nothing behind.
#[derive(Default)]
pub struct Unit<K> {
    keeper: K,
    is_forced: bool,
    complete: Vec<Complete>,
    leftovers: Vec<PathBuf>,
}

/// A file that waits for its name.
struct Complete {
    temporary: TempPath,
    path: PathBuf,
    replace: bool,
}

impl<K: Keeper> Unit<K> {
    /// A unit without files.
    pub fn new(keeper: K) -> Self {
        Self { keeper, is_forced: true, complete: Vec::new(), leftovers: Vec::new() }
    }

    /// One whose files are not forced to disk: the system writes them within half a minute. For files that a power failure
    /// may take, since whoever looks for them knows their lengths and makes them again.
    pub fn unforced(keeper: K) -> Self {
        Self { is_forced: false, ..Self::new(keeper) }
    }

    /// Lets `write` fill the file that will be `path`; `replace` says whether one may be there when it gets its name.
    ///
    /// # Errors
    /// Fails with the errors of the file system, of `write` and of the keeper.
    pub fn fill(
        &mut self,
        path: &Path,
        replace: bool,
        write: impl FnOnce(&mut BufWriter<Output<'_, K>>) -> io::Result<()>,
    ) -> io::Result<()> {
        let temporary = fill_beside(path, &self.keeper, self.is_forced, Box::new(write))?;
        self.complete.push(Complete { temporary, path: path.to_owned(), replace });
        Ok(())
    }

    /// Removes a file beside the others when these have their names: one that belonged to what they replace.
    pub fn remove(&mut self, leftover: PathBuf) {
        self.leftovers.push(leftover);
    }

    /// Gives every file its name, in the order in which they were filled, and removes what is left of replaced ones.
    ///
    /// All slow work comes before the first renaming: a process that is killed between two names leaves new files
    /// beside old ones, and between them lies one call of the system.
    ///
    /// # Errors
    /// A file cannot be renamed; the files renamed before it are restored. The error names the file.
    pub fn commit(self) -> Result<(), (PathBuf, io::Error)> {
        let Self { keeper, is_forced, complete, leftovers } = self;
        keeper.hold(|temporary_files| {
            let mut ready = Vec::new();
            for file in complete {
                let path = file.path.clone();
                ready.push((path.clone(), file.ready(&keeper, temporary_files).map_err(|error| (path, error))?));
            }
            for path in leftovers {
                let before = second_name(&path).map_err(|error| (path.clone(), error))?;
                temporary_files.extend(before.as_deref().map(Path::to_owned));
                ready.push((path.clone(), Ready { file: None, renamed: Renamed { path, before } }));
            }
            let mut done = Vec::new();
            for (path, next) in ready {
                match keeper.step().and_then(|()| next.rename(temporary_files)) {
                    Ok(renamed) => done.push(renamed),
                    Err(error) => {
                        done.into_iter().rev().for_each(Renamed::undo);
                        return Err((path, error));
                    }
                }
            }
            done.iter().filter(|_| is_forced).for_each(|renamed| sync_folder(folder(&renamed.path)));
            Ok(())
        })
    }
}

/// A name that is ready to be given to a file, or to none: the file that has it now has a second name.
struct Ready {
    file: Option<Complete>,
    renamed: Renamed,
}

/// A file that has its name. The file that it replaced is deleted on drop, unless it is put back.
struct Renamed {
    path: PathBuf,
    before: Option<TempPath>,
}

impl Complete {
    fn ready(self, keeper: &impl Keeper, temporary_files: &mut Vec<PathBuf>) -> io::Result<Ready> {
        keeper.step()?;
        let before = if self.replace { second_name(&self.path)? } else { None };
        temporary_files.extend(before.as_deref().map(Path::to_owned));
        Ok(Ready { renamed: Renamed { path: self.path.clone(), before }, file: Some(self) })
    }
}

impl Ready {
    fn rename(self, temporary_files: &mut Vec<PathBuf>) -> io::Result<Renamed> {
        let Self { file, renamed } = self;
        let Some(Complete { temporary, path, replace }) = file else {
            std::fs::remove_file(&renamed.path)?;
            return Ok(renamed);
        };
        temporary_files.retain(|other| other != &*temporary);
        let done = if replace { temporary.persist(&path) } else { temporary.persist_noclobber(&path) };
        done.map_err(|failed| failed.error)?;
        Ok(renamed)
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
    if !path.is_file() {
        return Ok(None);
    }
    let name = new_file(folder(path))?.into_temp_path();
    std::fs::remove_file(&name)?;
    std::fs::hard_link(path, &name).or_else(|_| std::fs::copy(path, &name).map(drop))?;
    Ok(Some(name))
}

/// A temporary file that takes bytes as long as its keeper lets it.
pub struct Output<'a, K> {
    file: File,
    keeper: &'a K,
}

impl<K: Keeper> Write for Output<'_, K> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.keeper.goes_on()?;
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl<K> Seek for Output<'_, K> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// What fills a file, boxed: [`fill_beside`] is compiled once for each keeper.
type Fill<'a, K> = Box<dyn FnOnce(&mut BufWriter<Output<'_, K>>) -> io::Result<()> + 'a>;

fn fill_beside<K: Keeper>(path: &Path, keeper: &K, is_forced: bool, write: Fill<'_, K>) -> io::Result<TempPath> {
    keeper.step()?;
    let made = keeper.hold(|temporary| {
        let made = new_file(folder(path))?;
        temporary.push(made.path().to_owned());
        io::Result::Ok(made)
    })?;
    let (file, temporary) = made.into_parts();
    keeper.step()?;
    // The new file keeps the permissions of the old one.
    if let Ok(replaced) = std::fs::metadata(path) {
        file.set_permissions(replaced.permissions())?;
    }
    let mut out = BufWriter::with_capacity(BLOCK, Output { file, keeper });
    write(&mut out)?;
    keeper.step()?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?.file;
    if is_forced {
        file.sync_all()?;
    }
    keeper.step()?;
    Ok(temporary)
}

/// Writes to a device or pipe, as it comes.
///
/// # Errors
/// Fails with the errors of `out` and `write`.
pub fn stream(out: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(BLOCK, out);
    write(&mut out)?;
    out.flush()
}

/// The folder that a file lies in.
pub fn folder(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The first megabyte of a file that is there, no link or device.
pub fn beginning(path: &Path) -> Option<Vec<u8>> {
    let is_file = std::fs::symlink_metadata(path).is_ok_and(|there| there.is_file());
    let mut bytes = Vec::new();
    let read = is_file.then(|| File::open(path).and_then(|file| file.take(1 << 20).read_to_end(&mut bytes)));
    read?.ok().map(|_| bytes)
}

/// A temporary file in `folder`, with the permissions that any new file gets. Errors keep the system's number.
///
/// # Errors
/// Fails with the errors of the file system.
pub fn new_file(folder: &Path) -> io::Result<NamedTempFile> {
    let new = |path: &Path| File::options().write(true).create_new(true).open(path);
    tempfile::Builder::new().prefix(UNFINISHED.0).suffix(UNFINISHED.1).make_in(folder, new)
}

/// Whether a name, without folders, is one of a temporary file.
pub fn is_unfinished(name: &str) -> bool {
    let (prefix, suffix) = UNFINISHED;
    name.starts_with(prefix) && name.ends_with(suffix) && !name.contains(['/', '\\'])
}

/// Makes the new name itself survive a power failure, where the system can.
fn sync_folder(folder: &Path) {
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
}
