//! The runs of gmsh that are under way, so that a signal handler can end them.

use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tempfile::TempDir;

static ALL: Mutex<Vec<Arc<GmshRun>>> = Mutex::new(Vec::new());

/// A run's folder, and its process once there is one. Whoever starts the process or makes a file in the folder holds
/// the lock of `child`: [`end_all`] finds nothing half done, and nothing new comes after it.
struct GmshRun {
    folder: TempDir,
    child: Mutex<Option<Child>>,
}

/// Ends every gmsh that this process runs, and removes its files: for whoever is about to exit at once.
///
/// It keeps its locks until the process exits, so that other threads make no new file and no new process.
pub fn end_all() {
    let all = lock(&ALL);
    for run in all.iter() {
        let mut child = lock(&run.child);
        end(&mut child);
        let _ = std::fs::remove_dir_all(run.folder.path());
        std::mem::forget(child);
    }
    std::mem::forget(all);
}

/// While this lives, [`end_all`] knows of the run; its folder goes with it.
pub(crate) struct Running(Option<Arc<GmshRun>>);

impl Running {
    /// A new run in a folder of its own.
    pub(crate) fn in_new_folder() -> io::Result<Self> {
        let mut all = lock(&ALL);
        let folder = tempfile::Builder::new().prefix("mesocrete-").tempdir()?;
        let run = Arc::new(GmshRun { folder, child: Mutex::new(None) });
        all.push(Arc::clone(&run));
        Ok(Self(Some(run)))
    }

    fn run(&self) -> &GmshRun {
        self.0.as_ref().expect("it is taken by `drop` alone")
    }

    pub(crate) fn folder(&self) -> &Path {
        self.run().folder.path()
    }

    /// Does `work` that makes a file in the folder; short work, since [`end_all`] waits for it.
    pub(crate) fn in_folder<T>(&self, work: impl FnOnce(&Path) -> T) -> T {
        let _child = lock(&self.run().child);
        work(self.folder())
    }

    /// Starts the process.
    pub(crate) fn start(&self, command: &mut Command) -> io::Result<()> {
        let mut child = lock(&self.run().child);
        *child = Some(command.spawn()?);
        Ok(())
    }

    /// How the process ended; `None` while it runs.
    pub(crate) fn status(&self) -> io::Result<Option<ExitStatus>> {
        lock(&self.run().child).as_mut().map_or(Ok(None), Child::try_wait)
    }

    /// Ends the process, if it still runs.
    pub(crate) fn end(&self) {
        end(&mut lock(&self.run().child));
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let run = self.0.take();
        let mut all = lock(&ALL);
        all.retain(|other| run.as_ref().is_none_or(|run| !Arc::ptr_eq(other, run)));
        // The folder is removed under the lock, so that `end_all` knows which folders are left.
        drop(run);
    }
}

fn end(child: &mut Option<Child>) {
    if let Some(child) = child.as_mut() {
        // A process that has already ended is no error.
        let _ = child.kill().and_then(|()| child.wait());
    }
}

/// A panic elsewhere must not keep a child alive.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
