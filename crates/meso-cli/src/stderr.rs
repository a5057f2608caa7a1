//! Messages on stderr. It may be closed: a message that nobody reads is no failure.

use meso_ask::Giver;
use meso_concrete::printable;
use std::fmt::Display;
use std::io::Write;

/// The flag of an option's key, for messages: `--gap-mm`.
pub(crate) fn flag(key: &str) -> String {
    Giver::Flags.option(key)
}

/// Writes a line to stderr, with the control characters of names, keys and paths escaped.
pub(crate) fn line(message: impl Display) {
    let _ = writeln!(std::io::stderr(), "{}", printable(&message.to_string()));
}
