//! `--threads`: as many workers as asked; the result does not depend on it.

use crate::failure::Failure;
use crate::stderr::flag;

/// Runs `work` on `threads` threads, or on all cores.
pub(crate) fn with<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    // For rayon 0 means all cores.
    let threads = usize::from(threads.unwrap_or(0));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|error| Failure::Run(format!("{} {threads}: {error}; take fewer", flag("threads"))))?;
    Ok(pool.install(work))
}

/// Runs `work` on the calling thread alone: a thread beside the workers takes no other one's time.
pub(crate) fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    match rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build() {
        Ok(pool) => pool.install(work),
        Err(_) => work(),
    }
}
