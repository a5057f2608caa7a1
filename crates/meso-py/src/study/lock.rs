//! Locks of `meso-files` for work that Python does.

use super::run_error;
use meso_files::lock::{Held, LOCK, LockError, hold, hold_as, join, patiently};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Looks at a lock that others hold for a moment: a minute in all.
const TRIES: u32 = 12_000;

/// A folder, or a part of the work in it, that no other process has.
#[pyclass(name = "_Lock", module = "mesocrete._mesocrete", frozen)]
pub(crate) struct PyLock(Mutex<Vec<Held>>);

impl PyLock {
    fn of(held: Result<Vec<Held>, LockError>) -> PyResult<Self> {
        held.map(|held| Self(Mutex::new(held))).map_err(|error| run_error(error.into()))
    }
}

#[pymethods]
impl PyLock {
    /// Takes a part of the work `work`, beside processes that have others; without `work` the part alone.
    #[new]
    fn new(folder: PathBuf, work: Option<&str>, part: &str) -> PyResult<Self> {
        let take = || -> Result<Vec<Held>, LockError> {
            let shared = work.map(|work| join(&folder, work)).transpose()?;
            let own = hold_as(&folder, &format!("{LOCK}-{part}"))?;
            Ok(shared.into_iter().chain([own]).collect())
        };
        Self::of(take())
    }

    /// Takes the folder for a moment, and waits for others that do so.
    #[staticmethod]
    fn briefly(folder: PathBuf) -> PyResult<Self> {
        Self::of(patiently(TRIES, || hold(&folder)).map(|held| vec![held]))
    }

    /// False on a file system without locks.
    #[getter]
    fn is_exclusive(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).iter().all(Held::is_exclusive)
    }

    /// Frees the folder.
    fn release(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }

    /// Closes the lock in a forked process, where it belongs to the parent.
    fn leave_lock_to_parent(&self) {
        // Another thread of the parent may have held the mutex while the process was forked.
        if let Ok(mut held) = self.0.try_lock() {
            held.drain(..).for_each(Held::leave);
        }
    }
}
