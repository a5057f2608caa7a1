//! A device by its driver, number and name.

use std::fmt;

/// Threads of a group of elements, unless asked otherwise.
pub const THREADS: usize = 128;
/// A driver's interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Driver {
    /// CUDA.
    Cuda,
    /// OpenCL.
    OpenCl,
}

/// A device that was found.
#[derive(Clone, Debug)]
pub struct DeviceName {
    /// Its driver.
    pub driver: Driver,
    /// Its number with this driver, from 0.
    pub number: usize,
    /// Its own name.
    pub name: String,
    /// Its memory, bytes.
    pub memory: u64,
    /// Threads of a group of elements.
    pub threads: usize,
    /// What it cannot keep of the promise of the same bytes, by its own account.
    pub faults: Vec<&'static str>,
}

impl fmt::Display for Driver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cuda => "cuda",
            Self::OpenCl => "opencl",
        })
    }
}

impl fmt::Display for DeviceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{} {}", self.driver, self.number, self.name)
    }
}
