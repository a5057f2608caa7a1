//! Refusal of work that memory or disk cannot hold, before any of it is taken.

use crate::failure::Failure;
use meso_files::{free, whole};
use std::path::Path;

/// Refuses a mesh that takes more memory than is free. `size_mm` is its element size.
pub(crate) fn accept_in_memory(work: &str, bytes: f64, (flag, size_mm): (&str, f64)) -> Result<(), Failure> {
    // Memory grows with the number of elements; some of it is kept for the rest.
    let fits = |free: f64| rounded_up(size_mm * (bytes / (0.8 * free)).cbrt());
    in_memory(work, bytes, |free| format!("take {flag} {} or more", fits(free)))
}

/// Refuses an image that takes more memory than is free.
pub(crate) fn accept_image(work: &str, bytes: f64) -> Result<(), Failure> {
    in_memory(work, bytes, |_| "cut a part out of the image".to_owned())
}

fn in_memory(work: &str, bytes: f64, fix: impl Fn(f64) -> String) -> Result<(), Failure> {
    let Some(free) = free::memory().map(|free| free as f64).filter(|free| bytes > *free) else { return Ok(()) };
    let (needed, free_gb, fix) = (bytes / 1e9, free / 1e9, fix(free));
    Err(Failure::Run(format!("{work} takes about {needed:.1} GB of memory, and {free_gb:.1} GB are free; {fix}")))
}

/// Refuses a file of so many bytes that its disk has no space for.
pub(crate) fn accept_on_disk(shown: &Path, path: &Path, bytes: u64) -> Result<(), Failure> {
    let Some(free) = free::disk(whole::folder(path)).filter(|free| *free < bytes) else { return Ok(()) };
    let (needed, free) = (bytes as f64 / 1e9, free as f64 / 1e9);
    let shown = shown.display();
    Err(Failure::Run(format!(
        "{shown} takes {needed:.1} GB, and {free:.1} GB are free on its disk; take larger voxels, a --box, or another disk"
    )))
}

/// Two digits that are no less.
fn rounded_up(size: f64) -> f64 {
    let unit = 10f64.powf(size.log10().floor() - 1.0);
    let digits = (size / unit).ceil();
    // Division by a whole power of ten gives the shortest number.
    if unit < 1.0 { digits / (1.0 / unit).round() } else { digits * unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_beyond_the_memory_is_refused_with_a_size_that_fits() {
        assert!(accept_in_memory("the mesh", 1e6, ("--element-size-mm", 2.0)).is_ok());
        let Err(Failure::Run(said)) = accept_in_memory("the mesh", 1e18, ("--element-size-mm", 0.1)) else {
            // The system does not say how much is free.
            return assert_eq!(free::memory(), None);
        };
        assert!(said.starts_with("the mesh takes about 1000000000.0 GB of memory, and "), "{said}");
    }

    #[test]
    fn sizes_are_rounded_up_to_two_digits() {
        assert_eq!([0.1234, 0.12, 1.01, 9.99, 23.4].map(rounded_up), [0.13, 0.12, 1.1, 10.0, 24.0]);
    }
}
