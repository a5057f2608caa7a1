//! Why a request is refused, or cannot be done.

use std::fmt::{self, Display, Formatter};
use std::io;
use std::path::Path;

/// A fault with its remedy.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AskError {
    /// A wrong option, in its giver's spelling.
    Usage(String),
    /// Something that could not be done.
    Run(String),
}

impl AskError {
    /// A file that could not be read or written, with the system's reason.
    pub fn file(path: &Path, error: &io::Error) -> Self {
        let text = error.to_string();
        Self::Run(format!("{}: {}", path.display(), text.split(" (os error").next().unwrap_or(&text)))
    }

    /// The fault and the remedy.
    pub fn message(&self) -> &str {
        let (Self::Usage(message) | Self::Run(message)) = self;
        message
    }
}

impl Display for AskError {
    fn fmt(&self, out: &mut Formatter<'_>) -> fmt::Result {
        out.write_str(self.message())
    }
}

impl std::error::Error for AskError {}
