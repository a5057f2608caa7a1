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
    let ([needed, left], fix) = (sizes([bytes, free]), fix(free));
    Err(Failure::Run(format!("{work} takes about {needed} of memory, and {left} are free; {fix}")))
}

/// Refuses a file of so many bytes that its disk has no space for.
pub(crate) fn accept_on_disk(shown: &Path, path: &Path, bytes: u64) -> Result<(), Failure> {
    let Some(free) = free::disk(whole::folder(path)).filter(|free| *free < bytes) else { return Ok(()) };
    let [needed, free] = sizes([bytes as f64, free as f64]);
    let shown = shown.display();
    Err(Failure::Run(format!(
        "{shown} takes {needed}, and {free} are free on its disk; take larger voxels, a --box, or another disk"
    )))
}

/// Two numbers of bytes in the largest unit that shows their difference.
fn sizes(bytes: [f64; 2]) -> [String; 2] {
    let in_unit = |(unit, size): (&str, f64)| bytes.map(|bytes| format!("{:.1} {unit}", bytes / size));
    let units = [("GB", 1e9), ("MB", 1e6), ("kB", 1e3)].map(in_unit);
    units.into_iter().find(|[a, b]| a != b).unwrap_or_else(|| bytes.map(|bytes| format!("{bytes} bytes")))
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
    fn bytes_are_named_in_a_unit_that_shows_their_difference() {
        let text = |needed: f64, free: f64| sizes([needed, free]).join(", ");
        assert_eq!(text(4.24e9, 1.0e9), "4.2 GB, 1.0 GB");
        assert_eq!(text(0.04e9, 0.02e9), "40.0 MB, 20.0 MB");
        assert_eq!(text(3.001e9, 3.0e9), "3001.0 MB, 3000.0 MB");
        assert_eq!(text(1500.0, 0.0), "1.5 kB, 0.0 kB");
        assert_eq!(text(1030.0, 1029.0), "1030 bytes, 1029 bytes");
    }

    #[test]
    fn sizes_are_rounded_up_to_two_digits() {
        assert_eq!([0.1234, 0.12, 1.01, 9.99, 23.4].map(rounded_up), [0.13, 0.12, 1.1, 10.0, 24.0]);
    }
}
