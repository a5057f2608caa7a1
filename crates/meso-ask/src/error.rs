//! Refusals of a request, and faults of its work.

use std::fmt::{self, Display, Formatter};
use std::io::{self, ErrorKind};

/// A fault with its remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AskError {
    /// A wrong option, in its giver's spelling.
    Usage(String),
    /// Something that could not be done.
    Run(String),
    /// A disk without room for the results: the same work can be done once there is some.
    Full(String),
}

impl AskError {
    /// Files that could not be read or written, in words that name them and the system's reason.
    pub fn files(message: String, error: &io::Error) -> Self {
        match error.kind() {
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => Self::Full(message),
            _ => Self::Run(message),
        }
    }

    /// The fault and the remedy.
    pub fn message(&self) -> &str {
        let (Self::Usage(message) | Self::Run(message) | Self::Full(message)) = self;
        message
    }
}

impl Display for AskError {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        out.write_str(self.message())
    }
}

impl std::error::Error for AskError {}
