//! `--threads`: as many workers as asked; the result does not depend on it.

use crate::failure::Failure;

/// Runs `work` on `threads` threads, or on all cores.
pub(crate) fn with<T: Send>(threads: Option<u16>, work: impl FnOnce() -> T + Send) -> Result<T, Failure> {
    let Some(threads) = threads else { return Ok(work()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build();
    let pool = pool.map_err(|error| Failure::Run(format!("--threads {threads}: {error}; take fewer")))?;
    Ok(pool.install(work))
}
