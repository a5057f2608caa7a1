//! The end of a command that failed: one line on stderr and an exit code.

use crate::stderr;
use meso_ask::AskError;
use meso_files::reason;
use std::path::Path;

/// Exit code of a run-time or input/output failure.
pub(crate) const RUN: u8 = 1;
/// Exit code of wrong usage or a wrong spec.
pub(crate) const USAGE: u8 = 2;
/// Exit code of `--strict` where the target was not reached.
pub(crate) const SHORT: u8 = 3;
/// Exit code after Ctrl-C.
pub(crate) const INTERRUPTED: u8 = 130;

/// Why a command failed; each message names the fault and the remedy.
#[derive(Debug)]
pub(crate) enum Failure {
    /// Wrong usage or a wrong spec.
    Usage(String),
    /// Something that could not be done.
    Run(String),
    /// The time limit came before there was anything to keep.
    Late(String),
    /// A panic: our mistake.
    Bug,
}

impl Failure {
    /// A file that could not be read or written, with the operating system's reason.
    pub(crate) fn file(path: &Path, error: &std::io::Error) -> Self {
        Self::Run(format!("{}: {}", path.display(), reason(error)))
    }

    /// The fault and the remedy.
    pub(crate) fn message(&self) -> &str {
        match self {
            Self::Usage(message) | Self::Run(message) | Self::Late(message) => message,
            Self::Bug => "this is a mistake in mesocrete; please report it with the command and the spec",
        }
    }

    /// Says it on stderr; the exit code.
    pub(crate) fn print(&self) -> u8 {
        stderr::line(format!("error: {}", self.message()));
        if matches!(self, Self::Usage(_)) { USAGE } else { RUN }
    }
}

impl From<AskError> for Failure {
    fn from(fault: AskError) -> Self {
        match fault {
            AskError::Usage(message) => Self::Usage(message),
            AskError::Run(message) | AskError::Full(message) => Self::Run(message),
        }
    }
}

impl From<Failure> for AskError {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Usage(message) => Self::Usage(message),
            other => Self::Run(other.message().to_owned()),
        }
    }
}

/// A panic prints one line; [`Failure::Bug`] adds the remedy.
pub(crate) fn hush_panics() {
    std::panic::set_hook(Box::new(|panic| stderr::line(format!("internal error: {panic}").replace('\n', " "))));
}
