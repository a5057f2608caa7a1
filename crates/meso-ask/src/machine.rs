//! The means that a front lends to the work of a request: free memory, the program that some meshes need, and its ear.

use crate::AskError;
use meso_core::mesh::Tools;
use std::cell::Cell;

/// What a front lends to the work of a request.
#[derive(Clone, Copy, Default)]
pub struct Machine<'a> {
    /// Free memory, bytes; `None` if the system does not say.
    pub memory: Option<u64>,
    /// gmsh, and who hears how far the work is.
    pub tools: Tools<'a>,
    /// Receives the largest memory that was asked for, bytes.
    pub asked: Option<&'a Cell<f64>>,
}

impl Machine<'_> {
    /// Refuses work that takes more memory than is free. `option` sets the size of an element or a voxel, mm, and memory grows
    /// with their number.
    ///
    /// # Errors
    /// The bytes that it takes and those that are free, with a size that fits.
    pub fn accept_in_memory(&self, work: &str, bytes: f64, (option, size_mm): (&str, f64)) -> Result<(), AskError> {
        // Some memory is kept for the rest.
        let fits = |free: f64| rounded_up(size_mm * libm::cbrt(bytes / (0.8 * free)));
        self.accept_bytes(work, bytes, |free| format!("take {option} {} or more", fits(free)))
    }

    /// Refuses work that takes more memory than is free, with the remedy that `fix` gives for the free bytes.
    ///
    /// # Errors
    /// The bytes that it takes and those that are free.
    pub fn accept_bytes(&self, work: &str, bytes: f64, fix: impl Fn(f64) -> String) -> Result<(), AskError> {
        self.asked.iter().for_each(|asked| asked.set(asked.get().max(bytes)));
        let Some(free) = self.memory.map(|free| free as f64).filter(|free| bytes > *free) else { return Ok(()) };
        let ([needed, left], fix) = (sizes([bytes, free]), fix(free));
        Err(AskError::Run(format!("{work} takes about {needed} of memory, and {left} are free; {fix}")))
    }
}

/// Two numbers of bytes in the largest unit that shows their difference.
pub fn sizes(bytes: [f64; 2]) -> [String; 2] {
    let in_unit = |(unit, size): (&str, f64)| bytes.map(|bytes| format!("{:.1} {unit}", bytes / size));
    let units = [("GB", 1e9), ("MB", 1e6), ("kB", 1e3)].map(in_unit);
    units.into_iter().find(|[a, b]| a != b).unwrap_or_else(|| bytes.map(|bytes| format!("{bytes} bytes")))
}

/// Two digits that are no less.
fn rounded_up(size: f64) -> f64 {
    let unit = libm::pow(10.0, libm::log10(size).floor() - 1.0);
    let digits = (size / unit).ceil();
    // Division by a whole power of ten gives the shortest number.
    if unit < 1.0 { digits / (1.0 / unit).round() } else { digits * unit }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mesh_beyond_the_memory_is_refused_with_a_size_that_fits() {
        let machine = Machine { memory: Some(2_000_000_000), ..Machine::default() };
        let accept = |bytes| machine.accept_in_memory("the mesh", bytes, ("--element-size-mm", 2.0));
        assert_eq!(accept(1e6), Ok(()));
        let said = "the mesh takes about 16.0 GB of memory, and 2.0 GB are free; take --element-size-mm 4.4 or more";
        assert_eq!(accept(1.6e10), Err(AskError::Run(said.to_owned())));
        assert_eq!(Machine { memory: None, ..machine }.accept_bytes("it", 1e18, |_| String::new()), Ok(()));
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
