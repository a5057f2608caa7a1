//! Pictures of at most 256 colours as PNG (ISO/IEC 15948), and bytes as text for a page.

use flate2::write::ZlibEncoder;
use flate2::{Compression, Crc};
use std::io::{self, Write};

/// A picture whose pixels are places in a palette.
pub(super) struct Picture {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Row by row from the top.
    pub(super) pixels: Vec<u8>,
    /// Red, green, blue; the first colour is transparent.
    pub(super) palette: Vec<[u8; 3]>,
}

impl Picture {
    /// The bytes of its file.
    pub(super) fn png(&self) -> io::Result<Vec<u8>> {
        let mut bytes = b"\x89PNG\r\n\x1a\n".to_vec();
        let size = [self.width, self.height].map(|n| (n as u32).to_be_bytes()).concat();
        // Eight bits a pixel, from a palette, with the usual compression and filters, not interlaced.
        chunk(b"IHDR", &[&size[..], &[8, 3, 0, 0, 0]].concat(), &mut bytes);
        chunk(b"PLTE", self.palette.as_flattened(), &mut bytes);
        chunk(b"tRNS", &[0], &mut bytes);
        let mut rows = ZlibEncoder::new(Vec::new(), Compression::best());
        for row in self.pixels.chunks_exact(self.width) {
            // Filter 0: the pixels as they are.
            rows.write_all(&[0])?;
            rows.write_all(row)?;
        }
        chunk(b"IDAT", &rows.finish()?, &mut bytes);
        chunk(b"IEND", &[], &mut bytes);
        Ok(bytes)
    }
}

fn chunk(name: &[u8; 4], content: &[u8], bytes: &mut Vec<u8>) {
    let mut sum = Crc::new();
    sum.update(name);
    sum.update(content);
    for part in [&(content.len() as u32).to_be_bytes()[..], name, content, &sum.sum().to_be_bytes()] {
        bytes.extend_from_slice(part);
    }
}

pub(super) use meso_view::embedded::base64;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_has_the_chunks_of_the_standard() {
        let picture = Picture { width: 2, height: 1, pixels: vec![0, 1], palette: vec![[0; 3], [255, 0, 0]] };
        let bytes = picture.png().unwrap();
        assert_eq!(&bytes[..29], b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x02\0\0\0\x01\x08\x03\0\0\0");
        // The end of every PNG, its sum included.
        assert_eq!(&bytes[bytes.len() - 12..], b"\0\0\0\0IEND\xaeB`\x82");
    }
}
