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
    /// Whether it is a processor with a driver of OpenCL, as pocl's are: `gpu` takes others first.
    pub is_processor: bool,
    /// Faults by its own account that cost the promise of the same bytes.
    pub faults: Vec<&'static str>,
    /// Reason for which it takes no test.
    pub refusal: Option<&'static str>,
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

impl DeviceName {
    /// The warning of a device that cannot keep the promise of the same bytes.
    pub fn warning(&self) -> Option<String> {
        let faults = self.faults.join("; ");
        (!faults.is_empty())
            .then(|| format!("{}:{}: {faults}; results are not the processor's to the bit", self.driver, self.number))
    }
}
