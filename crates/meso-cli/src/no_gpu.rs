//! A command without the feature `gpu` knows no device but this processor: the same names as in `gpu.rs`.

use crate::failure::Failure;
use meso_ask::{AskError, Giver};
use meso_solve::Run;
use meso_study::Attached;
use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

/// What takes the steps of a test.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum Choice {
    /// This processor.
    #[default]
    Cpu,
    /// A device, which is refused.
    Other(String),
}

impl FromStr for Choice {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(if text == "cpu" { Self::Cpu } else { Self::Other(text.to_owned()) })
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cpu => f.write_str("cpu"),
            Self::Other(name) => f.write_str(name),
        }
    }
}

/// There is none.
pub(crate) type Device = Infallible;

/// Printed where there is no device to list.
pub(crate) fn none() -> String {
    format!("no device: this mesocrete was built without them; {BUILD}, or take that of the Python package")
}

/// Remedy of a command without devices.
const BUILD: &str = "build it with --features gpu";

/// Begins the end of the line of a device that failed.
pub(crate) const FAILED: &str = "; failed: ";

/// No device for this processor; others are refused.
pub(crate) fn find(choice: &Choice) -> Result<Option<Device>, Failure> {
    match choice {
        Choice::Cpu => Ok(None),
        Choice::Other(name) => Err(Failure::Usage(format!(
            "{}: this mesocrete was built without devices; {BUILD}, take that of the Python package, or take the device cpu",
            Giver::Flags.choice("device", name)
        ))),
    }
}

/// No device; others than this processor are refused.
pub(crate) fn device(name: &str, _: Option<&mut Run<'_>>) -> Result<Attached, AskError> {
    let choice = name.parse().unwrap_or_else(|never| match never {});
    find(&choice)?;
    Ok(Attached::default())
}

/// Never called: there is no device to call it with.
pub(crate) fn attach(_: &mut Run, device: &Device, _: bool) -> Result<(), Failure> {
    match *device {}
}

/// No line.
pub(crate) fn lines(_: bool) -> Result<Vec<String>, Failure> {
    Ok(Vec::new())
}
