//! The compressed saved model: gzip in members of a fixed size, so that threads cannot change a byte.

use super::{in_chunks, threads};
use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use meso_concrete::stop;
use std::io::{self, Read, Write};

/// Bytes of text in a member.
const MEMBER: usize = 1 << 20;
/// Level of zlib: 4 gives 0.45 of the text, 2 gives 0.48 in half the time, 9 gives 0.44 in five times as much.
const LEVEL: u32 = 4;
/// How a gzip file begins.
pub(super) const MAGIC: [u8; 2] = [0x1f, 0x8b];
/// A model's text is 2 to 3 times as long as its members; zeros are 1,000 times as long, which would fill the memory.
const MOST_TIMES: u64 = 64;

/// Compresses all that is written to it, some members at a time.
pub(super) struct Members<W> {
    out: W,
    text: Vec<u8>,
}

impl<W: Write> Members<W> {
    pub(super) fn new(out: W) -> Self {
        Self { out, text: Vec::new() }
    }

    /// Writes the rest of the buffer, and flushes.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.compress()?;
        self.out.flush()
    }

    fn compress(&mut self) -> io::Result<()> {
        let members = in_chunks(&self.text, MEMBER, |text| {
            let mut encoder = GzEncoder::new(Vec::new(), Compression::new(LEVEL));
            encoder.write_all(text)?;
            encoder.finish()
        })?;
        self.text.clear();
        members.iter().try_for_each(|member| self.out.write_all(member))
    }
}

impl<W: Write> Write for Members<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let whole = MEMBER * threads();
        let taken = bytes.len().min(whole - self.text.len());
        self.text.extend_from_slice(&bytes[..taken]);
        if self.text.len() == whole {
            self.compress()?;
        }
        Ok(taken)
    }

    /// Members end where they are full, not where someone flushes.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The text of a compressed model.
pub(super) fn expand(bytes: &[u8]) -> Result<Vec<u8>, String> {
    let most = MOST_TIMES * bytes.len() as u64;
    let mut text = Vec::new();
    let mut expanded = Stopping(MultiGzDecoder::new(bytes)).take(most + 1);
    expanded.read_to_end(&mut text).map_err(|error| error.to_string())?;
    if text.len() as u64 > most {
        return Err(format!("it expands to more than {MOST_TIMES} times its size"));
    }
    Ok(text)
}

/// A reader that passes a stop point at every read.
struct Stopping<R>(R);

impl<R: Read> Read for Stopping<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        stop::point();
        self.0.read(buffer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compressed(text: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut members = Members::new(&mut bytes);
        text.chunks(77_777).for_each(|part| members.write_all(part).unwrap());
        members.finish().unwrap();
        bytes
    }

    #[test]
    fn one_thread_and_three_compress_to_the_same_bytes_that_expand_to_the_text() {
        let text: Vec<u8> = (0..5_000_000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        let alone = compressed(&text);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| compressed(&text)), alone);
        assert_eq!(expand(&alone).unwrap(), text);
        assert!(expand(&alone[..alone.len() - 9]).is_err(), "a torn file");
    }

    #[test]
    fn a_bomb_is_refused() {
        assert!(expand(&compressed(&vec![b' '; 10_000_000])).unwrap_err().contains("64 times"));
    }
}
