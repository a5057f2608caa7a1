//! Lines of decks through one buffer; each format adds its own kinds of them.

use std::io::{self, Write};

/// The buffer goes to `out` when it is this full.
const FLUSH_AT: usize = 1 << 16;

/// A buffered writer of decks.
pub(super) struct Lines<W> {
    out: W,
    pub(super) buffer: Vec<u8>,
}

impl<W: Write> Lines<W> {
    pub(super) fn new(out: W) -> Self {
        Self { out, buffer: Vec::with_capacity(FLUSH_AT + 1024) }
    }

    /// Writes the rest of the buffer.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.out.write_all(&self.buffer)?;
        self.out.flush()
    }

    /// A whole line, e.g. a keyword with its parameters.
    pub(super) fn line(&mut self, text: impl AsRef<str>) -> io::Result<()> {
        debug_assert!(!text.as_ref().starts_with('*') || text.as_ref().len() < 80, "{}", text.as_ref());
        self.buffer.extend_from_slice(text.as_ref().as_bytes());
        self.end()
    }

    /// Ends a line.
    pub(super) fn end(&mut self) -> io::Result<()> {
        self.buffer.push(b'\n');
        if self.buffer.len() >= FLUSH_AT {
            self.out.write_all(&self.buffer)?;
            self.buffer.clear();
        }
        Ok(())
    }
}
