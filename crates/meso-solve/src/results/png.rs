//! Pictures of at most 256 colours, as PNG by the crate `png`.

use png::{BitDepth, ColorType, Encoder, EncodingError};
use std::io;

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
        let mut bytes = Vec::new();
        let [width, height] = [self.width, self.height].map(|n| n as u32);
        let mut encoder = Encoder::new(&mut bytes, width, height);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_color(ColorType::Indexed);
        encoder.set_palette(self.palette.as_flattened());
        encoder.set_trns(&[0][..]);
        encoder.set_compression(png::Compression::High);
        let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&self.pixels));
        written.map_err(|error| match error {
            EncodingError::IoError(error) => error,
            other => io::Error::other(other),
        })?;
        Ok(bytes)
    }
}
