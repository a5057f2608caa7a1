//! Ctrl-C and termination. While a specimen is packed, the first signal keeps the best packing; the second one, and
//! any signal at another time, stops everything.
//!
//! Temporary files are removed and child programs ended in either case. Only a kill that cannot be caught leaves a
//! file behind, `.mesocrete-*.tmp`, or gmsh's folder.

use crate::failure::INTERRUPTED;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);
static POLLED: AtomicBool = AtomicBool::new(false);
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Handles the signals from now on.
pub(crate) fn install() {
    // This fails only if an earlier run in the same process has set it.
    let _ = ctrlc::set_handler(|| {
        let first = !ASKED.swap(true, Ordering::SeqCst);
        if !(first && POLLED.load(Ordering::SeqCst)) {
            meso_gmsh::end_all();
            remove_temporary_files();
            std::process::exit(INTERRUPTED.into());
        }
    });
}

/// True once the user asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.load(Ordering::SeqCst)
}

/// While this lives, the first Ctrl-C only sets the flag that [`asked`] reads.
pub(crate) struct Polling;

impl Polling {
    pub(crate) fn begin() -> Self {
        POLLED.store(true, Ordering::SeqCst);
        Self
    }
}

impl Drop for Polling {
    fn drop(&mut self) {
        POLLED.store(false, Ordering::SeqCst);
    }
}

/// Registers a temporary file for removal when the process is terminated.
pub(crate) fn remember(path: &Path) {
    if let Ok(mut paths) = TEMPORARY.lock() {
        paths.push(path.to_owned());
    }
}

/// It got its name, or is gone.
pub(crate) fn forget(path: &Path) {
    if let Ok(mut paths) = TEMPORARY.lock() {
        paths.retain(|other| other != path);
    }
}

fn remove_temporary_files() {
    if let Ok(paths) = TEMPORARY.lock() {
        for path in paths.iter() {
            let _ = std::fs::remove_file(path);
        }
    }
}
