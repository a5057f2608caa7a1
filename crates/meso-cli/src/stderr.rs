//! Messages on stderr. It may be closed: a message that nobody reads is no failure.

use std::fmt::Display;
use std::io::Write;

/// A line on stderr.
pub(crate) fn line(message: impl Display) {
    let _ = writeln!(std::io::stderr(), "{message}");
}
