//! Ctrl-C and termination. While a specimen is packed, the first signal keeps the best packing; the second one, and
//! any signal at another time, stops everything. A second signal within [`ONE_REQUEST`] counts as the first one: `timeout`
//! sends SIGTERM to the program and again to its group.
//!
//! Temporary files are removed and other programs ended either way; only a kill that cannot be caught leaves a file behind,
//! `.mesocrete-*.tmp`, or gmsh's folder. Hidden files come and go, and outputs get their names, only while
//! [`hold`] is held. The handler waits for it and never gives it back: it finds all that was made, and nothing is made after it.

use crate::failure::INTERRUPTED;
use meso_core::Watch;
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

/// Signals within this time of the first one are the same request. Two presses of Ctrl-C mostly lie further apart.
const ONE_REQUEST: Duration = Duration::from_millis(200);

static ASKED: OnceLock<Instant> = OnceLock::new();
/// Runs that read [`asked`]: a study has several at once.
static POLLED: AtomicUsize = AtomicUsize::new(0);
/// The process ends as soon as [`hold`] is free.
static ENDING: AtomicBool = AtomicBool::new(false);
static HIDDEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Handles the signals from now on.
pub(crate) fn install() {
    // This fails only if an earlier run in the same process has set it.
    let _ = ctrlc::set_handler(|| {
        let keeps = POLLED.load(Ordering::SeqCst) > 0 || ASKED.get().is_some();
        if !keeps || ASKED.get_or_init(Instant::now).elapsed() >= ONE_REQUEST {
            ENDING.store(true, Ordering::SeqCst);
            meso_gmsh::end_all();
            let hidden = lock();
            remove(&hidden);
            std::process::exit(INTERRUPTED.into());
        }
    });
    // A write beyond `ulimit -f` then fails like one on a full disk, and does not end the process.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

/// True once the user asked to stop.
pub(crate) fn asked() -> bool {
    ASKED.get().is_some()
}

/// While this lives, the first Ctrl-C only sets the flag that [`asked`] reads.
pub(crate) struct Polling;

impl Polling {
    pub(crate) fn begin() -> Self {
        POLLED.fetch_add(1, Ordering::SeqCst);
        Self
    }
}

impl Watch for Polling {
    fn stops(&self) -> bool {
        asked()
    }
}

impl Drop for Polling {
    fn drop(&mut self) {
        POLLED.fetch_sub(1, Ordering::SeqCst);
    }
}

/// The hidden files there are. While this is held no signal ends the process; once one ends it, this never returns.
pub(crate) fn hold() -> MutexGuard<'static, Vec<PathBuf>> {
    let held = lock();
    if ENDING.load(Ordering::SeqCst) {
        drop(held);
        end_if_told();
        unreachable!("the handler ends the process");
    }
    held
}

fn lock() -> MutexGuard<'static, Vec<PathBuf>> {
    HIDDEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for the end where a signal came while this thread held [`hold`]: the exit code tells of it.
pub(crate) fn end_if_told() {
    while ENDING.load(Ordering::SeqCst) {
        std::thread::park();
    }
}

/// Passes from one step of writing files to the next. Tests of debug builds let it fail, or let a signal come, at the step
/// whose number the environment names: between any two steps, without waiting for the right moment.
#[cfg(debug_assertions)]
pub(crate) fn step() -> io::Result<()> {
    static STEPS: AtomicUsize = AtomicUsize::new(0);
    let number = STEPS.fetch_add(1, Ordering::SeqCst).to_string();
    let is_now = |name: &str| std::env::var(name).is_ok_and(|at| at == number);
    if is_now("MESOCRETE_FAIL_AT") {
        return Err(io::Error::other("a test lets this step fail"));
    }
    if is_now("MESOCRETE_SIGNAL_AT") {
        std::process::Command::new("kill").args(["-INT", &std::process::id().to_string()]).status()?;
        while !ENDING.load(Ordering::SeqCst) {
            std::thread::yield_now();
        }
    }
    Ok(())
}

/// Does nothing in released builds.
#[cfg(not(debug_assertions))]
#[expect(clippy::unnecessary_wraps, reason = "steps fail in tests")]
pub(crate) fn step() -> io::Result<()> {
    Ok(())
}

fn remove(paths: &[PathBuf]) {
    for path in paths {
        let _ = std::fs::remove_file(path);
    }
}
