//! Which devices there are, and which one a user means.

use crate::host::{Host, cuda, opencl};
use crate::name::{DeviceName, Driver, THREADS};
use std::fmt;
use std::fs::File;
use std::path::Path;
use std::str::FromStr;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Threads that a group may have; the results are the same bytes.
const SIZES: [usize; 4] = [32, 64, 128, 256];

/// What takes the steps of a test.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// This processor.
    #[default]
    Cpu,
    /// The device that keeps the promise and has the fewest tests of this process, a processor only where nothing else is
    /// there; of equals one that no other process has, CUDA's before OpenCL's.
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

/// Driver and number of a device, once for every test that has it.
static TAKEN: Mutex<Vec<(Driver, usize)>> = Mutex::new(Vec::new());

/// A device that a test has until this goes: workers of a study then have one each.
#[derive(Debug)]
pub struct Lease {
    /// The device.
    pub device: DeviceName,
    /// Tells other processes.
    _mark: Option<File>,
}

/// Locks the file in `folder` that stands for a device; `None` where another test has it.
fn mark(device: &DeviceName, folder: &Path) -> Option<File> {
    let path = folder.join(format!("mesocrete-{}-{}.lock", device.driver, device.number));
    let file = File::options().write(true).create(true).truncate(false).open(path).ok()?;
    file.try_lock().is_ok().then_some(file)
}

impl Lease {
    fn all() -> MutexGuard<'static, Vec<(Driver, usize)>> {
        TAKEN.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        let (own, mut taken) = ((self.device.driver, self.device.number), Self::all());
        let place = taken.iter().position(|other| *other == own);
        place.map(|place| taken.swap_remove(place));
    }
}

impl Choice {
    /// Takes the device that is meant; none for this processor.
    ///
    /// # Errors
    /// Where there is none, and where it takes no test, with a remedy.
    pub fn find(self) -> Result<Option<Lease>, String> {
        if self == Self::Cpu {
            return Ok(None);
        }
        let (all, mut taken, mut own) = (devices(), Lease::all(), None);
        let device = self.among(all, &taken, |device| {
            own = mark(device, &std::env::temp_dir());
            own.is_some()
        })?;
        taken.push((device.driver, device.number));
        Ok(Some(Lease { device, _mark: own }))
    }

    /// The device among `all` that is meant, if it takes tests; of equals the one that is least `taken`, and of these the first
    /// that `is_free`.
    fn among(
        self,
        all: Vec<DeviceName>,
        taken: &[(Driver, usize)],
        is_free: impl FnMut(&&&DeviceName) -> bool,
    ) -> Result<DeviceName, String> {
        let wanted = |device: &&DeviceName| match self {
            Self::Cpu => false,
            Self::Gpu => device.faults.is_empty() && device.refusal.is_none(),
            Self::Numbered(driver, number, _) => (device.driver, device.number) == (driver, number),
        };
        let threads = if let Self::Numbered(_, _, threads) = self { threads } else { THREADS };
        let tests =
            |device: &DeviceName| taken.iter().filter(|other| **other == (device.driver, device.number)).count();
        let key = |device: &&DeviceName| (device.is_processor, tests(device));
        let least = all.iter().filter(wanted).map(|device| key(&device)).min();
        let found: Vec<_> = all.iter().filter(|device| wanted(device) && Some(key(device)) == least).collect();
        match found.iter().find(is_free).or(found.first()).copied() {
            None => Err(self.missing(&all)),
            Some(DeviceName { refusal: Some(why), .. }) => Err(format!("{self}: {why}; {OTHER}")),
            Some(found) => Ok(DeviceName { threads, ..found.clone() }),
        }
    }

    fn missing(self, all: &[DeviceName]) -> String {
        let fault = |of: &DeviceName| of.refusal.or(of.faults.first().copied()).map(|why| (of.driver, of.number, why));
        match all.iter().find_map(fault) {
            Some((driver, number, why)) if self == Self::Gpu => {
                format!("no device takes the test with the processor's bytes ({driver}:{number}: {why}); {OTHER}")
            }
            _ => {
                let is_sibling = |of: &&DeviceName| matches!(self, Self::Numbered(own, ..) if own == of.driver);
                let sibling = all.iter().find(is_sibling).map(|of| format!("take {}:{}", of.driver, of.number));
                let fix = sibling.unwrap_or_else(|| "install its driver".to_owned());
                format!("there is no device {self}; {fix} (`mesocrete devices` lists all), or take the device cpu")
            }
        }
    }
}

/// Remedy for a device that takes no test.
pub(crate) const OTHER: &str = "take another device (`mesocrete devices` lists all), or the device cpu";

/// Opens a device.
pub(crate) fn open(device: &DeviceName) -> Result<Box<dyn Host>, String> {
    Ok(match device.driver {
        Driver::Cuda => Box::new(cuda::Cuda::open(device.number)?),
        Driver::OpenCl => Box::new(opencl::OpenCl::open(device.number)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn device(number: usize, faults: &[&'static str], refusal: Option<&'static str>) -> DeviceName {
        let (name, faults, threads) = ("a card".to_owned(), faults.to_vec(), THREADS);
        let (driver, is_processor) = (Driver::OpenCl, false);
        DeviceName { driver, number, name, memory: 1, threads, is_processor, faults, refusal }
    }

    #[test]
    fn a_device_is_chosen_by_its_number_or_as_the_first_that_keeps_the_promise() {
        let all = || vec![device(0, &["it rounds"], None), device(1, &[], Some("it is old")), device(2, &[], None)];
        let chosen = |text: &str| text.parse::<Choice>().unwrap().among(all(), &[], |_| true);
        assert_eq!(chosen("gpu").unwrap().number, 2);
        assert_eq!(chosen("opencl").unwrap().number, 0);
        assert_eq!(chosen("opencl:2:64").unwrap().threads, 64);
        assert!(chosen("opencl:1").unwrap_err().starts_with("opencl:1: it is old; take another device"));
        assert!(chosen("opencl:3").unwrap_err().starts_with("there is no device opencl:3; take opencl:0 ("));
        assert!(chosen("cuda:0").unwrap_err().starts_with("there is no device cuda:0; install its driver"));
        for text in ["", "gpu:0", "opencl:", "opencl:-1", "opencl:0:48", "OpenCL:0", "cpu:0"] {
            assert!(text.parse::<Choice>().unwrap_err().contains("is no device"), "{text}");
        }
    }

    #[test]
    fn workers_of_a_study_have_a_device_each_before_two_share_one() {
        let processor = DeviceName { is_processor: true, ..device(0, &[], None) };
        let cards = [device(1, &["it rounds"], None), device(2, &[], None), device(3, &[], None)];
        let all = || [&[processor.clone()][..], &cards].concat();
        let mut taken = Vec::new();
        for expected in [2, 3, 2, 3] {
            let found = Choice::Gpu.among(all(), &taken, |_| true).unwrap();
            assert_eq!(found.number, expected, "{taken:?}");
            taken.push((found.driver, found.number));
        }
        assert_eq!(Choice::Numbered(Driver::OpenCl, 0, THREADS).among(all(), &taken, |_| false).unwrap().number, 0);
    }

    /// Processes that know nothing of each other: two cards, then three tests. Locks of one process stand for those of several,
    /// since each opens its file anew.
    #[test]
    fn processes_take_different_cards_before_two_share_one() {
        let folder = tempfile::tempdir().unwrap();
        let process = || {
            let mut own = None;
            let cards = vec![device(0, &[], None), device(1, &[], None)];
            let found = Choice::Gpu.among(cards, &[], |device| {
                own = mark(device, folder.path());
                own.is_some()
            });
            (found.unwrap().number, own)
        };
        let (first, second, third) = (process(), process(), process());
        assert_eq!([first.0, second.0, third.0], [0, 1, 0]);
        drop(second);
        assert_eq!(process().0, 1);
    }

    #[test]
    fn a_gpu_is_refused_with_the_fault_of_the_only_device() {
        for (faults, refusal) in [(&["it rounds"][..], None), (&[], Some("it is old"))] {
            let why = Choice::Gpu.among(vec![device(0, faults, refusal)], &[], |_| true).unwrap_err();
            assert!(why.contains("(opencl:0: it ") && why.contains("or the device cpu"), "{why}");
        }
        assert!(
            Choice::Gpu
                .among(Vec::new(), &[], |_| true)
                .unwrap_err()
                .starts_with("there is no device gpu; install its driver")
        );
    }
}
