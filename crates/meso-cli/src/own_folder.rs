//! A folder of results while a command works in it: no other process does, and one that stays empty goes again.

use crate::failure::Failure;
use crate::interrupt;
use meso_files::lock::{self, Held};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// A folder that belongs to this process.
pub(crate) struct OwnFolder {
    /// Dropped before the folder is taken away.
    _lock: Lock,
    _made: Option<Made>,
}

impl OwnFolder {
    /// Makes the folder if it is not there, and keeps other processes out of it.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let made = make(path)?;
        Ok(Self { _lock: Lock::on(path)?, _made: made })
    }
}

/// The lock on a folder; a signal that ends the process removes its hidden file.
struct Lock(Held);

impl Lock {
    fn on(folder: &Path) -> Result<Self, Failure> {
        let mut hidden = interrupt::hold();
        let held = lock::hold(folder).map_err(|error| Failure::Run(error.to_string()))?;
        hidden.push(held.path().to_owned());
        Ok(Self(held))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        interrupt::hold().retain(|path| path != self.0.path());
    }
}

/// A folder that was made here. One that stays empty goes again.
pub(crate) struct Made(PathBuf);

impl Drop for Made {
    fn drop(&mut self) {
        // One that holds something stays.
        let _ = std::fs::remove_dir(&self.0);
    }
}

/// Makes the folder, if it is not there; it must have a place.
pub(crate) fn make(path: &Path) -> Result<Option<Made>, Failure> {
    match std::fs::metadata(path) {
        Ok(kind) if kind.is_dir() => Ok(None),
        Ok(_) => Err(Failure::Run(format!("{} is not a folder; name a folder for the results", path.display()))),
        Err(_) => match std::fs::create_dir(path) {
            // Another process has made it in between.
            Err(error) if error.kind() == ErrorKind::AlreadyExists && path.is_dir() => Ok(None),
            made => made.map(|()| Some(Made(path.to_owned()))).map_err(|error| Failure::file(path, &error)),
        },
    }
}
