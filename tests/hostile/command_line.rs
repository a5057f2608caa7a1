//! What has to hold for any words after `mesocrete`: they are read and refused, or read and accepted, and nothing panics.

use std::ffi::OsString;

/// The words are the lines of `bytes`. An error has a message, which says what is wrong and not how it was found.
pub(crate) fn command_line(bytes: &[u8]) {
    let words = bytes.split(|byte| *byte == b'\n').map(word);
    let args: Vec<OsString> = std::iter::once("mesocrete".into()).chain(words).collect();
    if let Err(message) = meso_cli::validate(args) {
        assert!(!message.trim().is_empty());
        assert!(!message.contains("mistake in mesocrete"), "{message}");
    }
}

/// On Unix a word is any bytes.
#[cfg(unix)]
fn word(bytes: &[u8]) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes.to_vec())
}

#[cfg(not(unix))]
fn word(bytes: &[u8]) -> OsString {
    String::from_utf8_lossy(bytes).into_owned().into()
}
