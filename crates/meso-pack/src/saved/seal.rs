//! The seal of a saved model: the CRC-32 of all bytes before it, as the last entry of the file.
//!
//! CRC-32 finds every flipped bit. A file without a seal is read as it is: other programs, and earlier versions, write
//! none. A seal counts only in the place and form in which [`write`](super::write) puts it, so that a file that another
//! program has read and written again is not held against its old seal.

use crc32fast::Hasher;
use std::io::{self, Write};

/// Characters before and after the eight digits.
const BEFORE: &[u8] = b",\n\"crc32\": \"";
const AFTER: &[u8] = b"\"}";
const DIGITS: usize = 8;

/// Counts the bytes that pass.
pub(super) struct Sealing<W> {
    out: W,
    crc: Hasher,
}

impl<W: Write> Sealing<W> {
    pub(super) fn new(out: W) -> Self {
        Self { out, crc: Hasher::new() }
    }

    /// The end of the file.
    pub(super) fn end(&self) -> Vec<u8> {
        [BEFORE, digits(&self.crc).as_bytes(), AFTER, b"\n"].concat()
    }
}

impl<W: Write> Write for Sealing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.crc.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

fn digits(crc: &Hasher) -> String {
    format!("{:08x}", crc.clone().finalize())
}

/// True where `text` has no seal, or the right one.
pub(super) fn is_whole(text: &[u8]) -> bool {
    let Some(rest) = text.trim_ascii_end().strip_suffix(AFTER) else { return true };
    let Some((rest, found)) = rest.len().checked_sub(DIGITS).map(|end| rest.split_at(end)) else { return true };
    let Some(sealed) = rest.strip_suffix(BEFORE) else { return true };
    let mut crc = Hasher::new();
    crc.update(sealed);
    found == digits(&crc).as_bytes()
}
