//! The runs of gmsh that are under way, so that a signal handler can end them.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Child, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

static ALL: Mutex<Vec<Arc<Run>>> = Mutex::new(Vec::new());

/// A run's folder, and its process once there is one.
struct Run {
    folder: PathBuf,
    child: Mutex<Option<Child>>,
}

impl Run {
    /// Ends the process, if it still runs.
    fn end(&self) {
        if let Some(child) = lock(&self.child).as_mut() {
            // A process that has already ended is no error.
            let _ = child.kill().and_then(|()| child.wait());
        }
    }
}

/// Ends every gmsh that this process runs, and removes its files: for whoever is about to exit at once.
pub fn end_all() {
    for run in lock(&ALL).iter() {
        run.end();
        let _ = std::fs::remove_dir_all(&run.folder);
    }
}

/// While this lives, [`end_all`] knows of the run.
pub(crate) struct Running(Arc<Run>);

impl Running {
    pub(crate) fn in_folder(folder: &Path) -> Self {
        let run = Arc::new(Run { folder: folder.to_owned(), child: Mutex::new(None) });
        lock(&ALL).push(Arc::clone(&run));
        Self(run)
    }

    pub(crate) fn begin(&self, child: Child) {
        *lock(&self.0.child) = Some(child);
    }

    /// How the process ended; `None` while it runs.
    pub(crate) fn status(&self) -> io::Result<Option<ExitStatus>> {
        lock(&self.0.child).as_mut().map_or(Ok(None), Child::try_wait)
    }

    pub(crate) fn end(&self) {
        self.0.end();
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        lock(&ALL).retain(|other| !Arc::ptr_eq(other, &self.0));
    }
}

/// A panic elsewhere must not keep a child alive.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
