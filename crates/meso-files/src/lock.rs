//! One process at a time in a folder of results, or several that share one work.
//!
//! The lock is the system's own, on a hidden file in the folder, so it ends with the process that took it, even where that
//! was killed. The file stays then, and the next process takes it over. It holds the number of the process, for whoever
//! has to wait.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Name of the hidden file.
pub const LOCK: &str = ".mesocrete-lock";
/// Names of the hidden files of shared works: a prefix and a suffix.
const SHARED: (&str, &str) = (".mesocrete-", ".lock");
/// Looks at a lock that another process has for a moment, and the time between two.
const TRIES: u32 = 200;
const MOMENT: Duration = Duration::from_millis(5);
/// The hidden files that this process has locked. A number names no process: others of a cluster or of a container have it, too.
static OWN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Why a folder cannot be held.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// Another process holds it.
    #[error("{} is in use by {}; wait until it ends, or name another folder", folder.display(), holder_text(*holder))]
    Busy {
        /// The folder.
        folder: PathBuf,
        /// Number of the process, where the system lets it be read.
        holder: Option<u32>,
        /// Whether this process itself holds it.
        is_own: bool,
    },
    /// The hidden file cannot be made or locked.
    #[error("{}: {}", path.display(), crate::reason(error))]
    File {
        /// The hidden file.
        path: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
}

fn holder_text(holder: Option<u32>) -> String {
    holder.map_or_else(|| "another process".to_owned(), |number| format!("process {number}"))
}

/// A folder that no other process holds. It is free again when this is dropped.
#[derive(Debug)]
pub struct Held {
    path: PathBuf,
    file: Option<File>,
    /// Whether other processes may have the same lock.
    is_shared: bool,
    is_exclusive: bool,
}

/// Takes `folder` for this process, without waiting.
///
/// # Errors
/// [`LockError::Busy`] where another process holds the folder, or another task of this one.
pub fn hold(folder: &Path) -> Result<Held, LockError> {
    hold_as(folder, LOCK)
}

/// Takes what the hidden file `name` of `folder` stands for, as [`hold`] does.
///
/// # Errors
/// See [`hold`].
pub fn hold_as(folder: &Path, name: &str) -> Result<Held, LockError> {
    take(folder, name, false)
}

/// Takes part in the work `name`, letters and digits, on `folder`, beside other processes that do the same.
///
/// # Errors
/// [`LockError::Busy`] where another process does other work there.
pub fn join(folder: &Path, name: &str) -> Result<Held, LockError> {
    join_after(folder, name, || Ok(()))
}

/// Takes part in a work as [`join`] does. A process that is the only one at it does `first` before others can take part.
///
/// # Errors
/// See [`join`], and errors of `first`.
pub fn join_after(folder: &Path, name: &str, first: impl FnOnce() -> io::Result<()>) -> Result<Held, LockError> {
    let (prefix, suffix) = SHARED;
    let own = format!("{prefix}{name}{suffix}");
    if let Ok(_alone) = take(folder, &own, false) {
        first().map_err(|error| LockError::File { path: folder.to_owned(), error })?;
    }
    // The last holder has the file alone for a moment, while it removes it, and so has whoever takes away a killed one's.
    let held = patiently(TRIES, || take(folder, &own, true))?;
    let fail = |error| LockError::File { path: folder.to_owned(), error };
    for entry in std::fs::read_dir(folder).map_err(fail)? {
        let other = entry.map_err(fail)?.file_name().to_string_lossy().into_owned();
        if other.starts_with(prefix) && other.ends_with(suffix) && other != own {
            // The file of a killed process goes.
            patiently(TRIES / 10, || take(folder, &other, false))?;
        }
    }
    Ok(held)
}

/// Takes what another process has for a moment: after so many looks, 5 ms apart, it is busy.
///
/// # Errors
/// Those of `take`.
pub fn patiently(tries: u32, take: impl Fn() -> Result<Held, LockError>) -> Result<Held, LockError> {
    let mut tries = 0..tries;
    loop {
        match take() {
            Err(LockError::Busy { .. }) if tries.next().is_some() => std::thread::sleep(MOMENT),
            taken => return taken,
        }
    }
}

fn take(folder: &Path, name: &str, is_shared: bool) -> Result<Held, LockError> {
    take_by(folder, name, is_shared, |file| if is_shared { file.try_lock_shared() } else { file.try_lock() })
}

fn take_by(
    folder: &Path,
    name: &str,
    is_shared: bool,
    lock: impl Fn(&File) -> Result<(), TryLockError>,
) -> Result<Held, LockError> {
    let path = folder.join(name);
    let fail = |error| LockError::File { path: path.clone(), error };
    loop {
        let mut file = open(&path).map_err(fail)?;
        let is_exclusive = match lock(&file) {
            Ok(()) => true,
            Err(TryLockError::WouldBlock) => {
                let is_own = own().contains(&path);
                return Err(LockError::Busy { folder: folder.to_owned(), holder: number_in(&mut file), is_own });
            }
            Err(TryLockError::Error(error)) if has_no_locks(&error) => false,
            Err(TryLockError::Error(error)) => return Err(fail(error)),
        };
        // The holder before may have removed the file between our two calls.
        if is_at(&file, &path) {
            // On Windows nobody writes into a file with a shared lock.
            if !is_shared || cfg!(unix) {
                sign(&mut file).map_err(fail)?;
            }
            own().push(path.clone());
            return Ok(Held { path, file: Some(file), is_shared, is_exclusive });
        }
    }
}

/// Whether a network file system has no locks, like Lustre without the option flock, or no server for them, like some NFS.
fn has_no_locks(error: &io::Error) -> bool {
    #[cfg(unix)]
    let has_no_server = error.raw_os_error() == Some(rustix::io::Errno::NOLCK.raw_os_error());
    #[cfg(not(unix))]
    let has_no_server = false;
    has_no_server || error.kind() == ErrorKind::Unsupported
}

fn own() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    OWN.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Held {
    /// The hidden file: a program that ends without dropping this may remove it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Closes the file and leaves the folder locked: for a forked process, whose parent holds the folder.
    pub fn leave(mut self) {
        drop(self.file.take());
    }

    /// False on a file system without locks, where others cannot be kept out.
    pub fn is_exclusive(&self) -> bool {
        self.is_exclusive
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        {
            let mut own = own();
            let place = own.iter().position(|path| *path == self.path);
            place.map(|place| own.swap_remove(place));
        }
        let Some(file) = self.file.take() else { return };
        if self.is_shared {
            let _ = file.unlock();
            // The last one removes the file, and on a disk without locks each does.
            if (self.is_exclusive && file.try_lock().is_err()) || !is_at(&file, &self.path) {
                return;
            }
        }
        // On Unix the name goes while the lock is held, so that nobody else's file is removed. Windows removes no open file.
        if cfg!(unix) {
            let _ = std::fs::remove_file(&self.path);
        }
        // A process that was forked from this one has the file open, too.
        let _ = file.unlock();
        drop(file);
        if cfg!(windows) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

fn open(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.read(true).write(true).create(true).truncate(false);
    // FILE_SHARE_READ and FILE_SHARE_WRITE: nobody removes the file while another process has it open.
    #[cfg(windows)]
    std::os::windows::fs::OpenOptionsExt::share_mode(&mut options, 3);
    options.open(path)
}

/// Whether `path` still names `file`.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let place = |data: std::fs::Metadata| (data.dev(), data.ino());
    let (own, there) = (file.metadata().map(place), std::fs::metadata(path).map(place));
    matches!((own, there), (Ok(own), Ok(there)) if own == there)
}

/// An open file keeps its name here.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// Writes the number of this process into `file`.
fn sign(file: &mut File) -> io::Result<()> {
    file.set_len(0)?;
    file.rewind()?;
    writeln!(file, "{}", std::process::id())
}

/// Number of the process that holds `file`.
fn number_in(file: &mut File) -> Option<u32> {
    let mut text = String::new();
    file.take(16).read_to_string(&mut text).ok()?;
    text.trim().parse().ok()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use rustix::io::Errno;

    /// No test machine has such a disk: its answers stand in.
    #[test]
    fn a_disk_without_locks_is_known_and_any_other_fault_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let take = |fault: Errno| {
            take_by(folder.path(), LOCK, false, |_| {
                Err(TryLockError::Error(io::Error::from_raw_os_error(fault.raw_os_error())))
            })
        };
        for fault in [Errno::NOLCK, Errno::NOSYS, Errno::OPNOTSUPP] {
            let held = take(fault).unwrap();
            assert!(!held.is_exclusive() && take(fault).is_ok(), "{fault}");
        }
        assert!(matches!(take(Errno::IO), Err(LockError::File { .. })));
        assert!(take_by(folder.path(), LOCK, false, |_| Ok(())).unwrap().is_exclusive());
    }
}
