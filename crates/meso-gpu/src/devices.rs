//! Which devices there are, and which one a user means.

use crate::host::{Host, cuda, opencl};
use crate::name::{DeviceName, Driver, THREADS};
use std::fmt;
use std::str::FromStr;

/// Threads that a group may have; the results are the same bytes.
const SIZES: [usize; 4] = [32, 64, 128, 256];

/// What takes the steps of a test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// This processor.
    #[default]
    Cpu,
    /// The first device that keeps the promise: CUDA's before OpenCL's.
    Gpu,
    /// A device by its driver and number, and the threads of a group of elements.
    Numbered(Driver, usize, usize),
}

impl FromStr for Choice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbered = |driver, text: &str| {
            let (number, threads) =
                text.split_once(':').map_or((text, Some(THREADS)), |(number, threads)| (number, threads.parse().ok()));
            let threads = threads.filter(|threads| SIZES.contains(threads))?;
            number.parse().ok().map(|number| Self::Numbered(driver, number, threads))
        };
        let choice = match text.split_once(':') {
            None if text == "cpu" => Some(Self::Cpu),
            None if text == "gpu" => Some(Self::Gpu),
            None if text == "cuda" => Some(Self::Numbered(Driver::Cuda, 0, THREADS)),
            None if text == "opencl" => Some(Self::Numbered(Driver::OpenCl, 0, THREADS)),
            Some(("cuda", rest)) => numbered(Driver::Cuda, rest),
            Some(("opencl", rest)) => numbered(Driver::OpenCl, rest),
            _ => None,
        };
        choice.ok_or_else(|| {
            format!("{text:?} is no device; take cpu, gpu, cuda:N or opencl:N (see `mesocrete devices`)")
        })
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cpu => f.write_str("cpu"),
            Self::Gpu => f.write_str("gpu"),
            Self::Numbered(driver, number, THREADS) => write!(f, "{driver}:{number}"),
            Self::Numbered(driver, number, threads) => write!(f, "{driver}:{number}:{threads}"),
        }
    }
}

/// All devices: CUDA's, then OpenCL's.
pub fn devices() -> Vec<DeviceName> {
    let mut all = cuda::devices();
    all.extend(opencl::devices());
    all
}

impl Choice {
    /// The device that is meant; none for this processor.
    ///
    /// # Errors
    /// Where there is none, with the way on.
    pub fn find(self) -> Result<Option<DeviceName>, String> {
        let wanted = |device: &DeviceName| match self {
            Self::Cpu => false,
            Self::Gpu => device.faults.is_empty(),
            Self::Numbered(driver, number, _) => (device.driver, device.number) == (driver, number),
        };
        if self == Self::Cpu {
            return Ok(None);
        }
        let found = devices().into_iter().find(wanted);
        let threads = if let Self::Numbered(_, _, threads) = self { threads } else { THREADS };
        found.map(|found| Some(DeviceName { threads, ..found })).ok_or_else(|| {
            format!(
                "there is no device {self}; install its driver (`mesocrete devices` lists all), or take the device cpu"
            )
        })
    }
}

/// Opens a device.
pub(crate) fn open(device: &DeviceName) -> Result<Box<dyn Host>, String> {
    Ok(match device.driver {
        Driver::Cuda => Box::new(cuda::Cuda::open(device.number)?),
        Driver::OpenCl => Box::new(opencl::OpenCl::open(device.number)?),
    })
}
