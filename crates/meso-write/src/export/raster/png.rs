//! Pictures of sections (`.png`), upright: the second axis points upwards. By the crate `png`.
//!
//! Phases are indexed colours, whose indices are the labels; shares are grey, black 0 and white 1.

use super::super::appearance::phase_colour;
use super::{Frame, Voxels};
use meso_concrete::{Phase, PhaseNames};
use png::{BitDepth, ColorType, Encoder, EncodingError};
use std::io::{self, Write};

/// Writes the one picture of a section to `out`.
///
/// # Errors
/// Fails with the errors of `out`; ids, and reals that are not shares, which no picture holds.
pub(crate) fn write(frame: &Frame, values: &Voxels, out: impl Write) -> io::Result<()> {
    let ([rows, columns], _) = frame.pictures();
    let mut encoder = Encoder::new(out, columns, rows);
    encoder.set_depth(BitDepth::Eight);
    let pixels: Vec<u8> = match values {
        Voxels::Label(labels) => {
            encoder.set_color(ColorType::Indexed);
            encoder.set_palette(palette(labels));
            encoder.set_trns([vec![255; 255], vec![0]].concat());
            labels.clone()
        }
        Voxels::Real(shares) => {
            encoder.set_color(ColorType::Grayscale);
            shares.iter().map(|share| (255.0 * share.clamp(0.0, 1.0)).round() as u8).collect()
        }
        Voxels::Id(_) => return Err(io::Error::other("a .png holds phases or shares; take .tif or .npy for ids")),
    };
    let upright: Vec<u8> = pixels.chunks_exact(columns as usize).rev().flatten().copied().collect();
    let plain = |error| match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    };
    encoder.write_header().and_then(|mut writer| writer.write_image_data(&upright)).map_err(plain)
}

/// All 256 colours: those of the phases, then black; 255 is transparent.
fn palette(labels: &[u8]) -> Vec<u8> {
    let phases = labels.iter().filter(|label| usize::from(**label) < PhaseNames::ROOM).map(|label| label + 1);
    let count = phases.fold(Phase::ALL.len() as u8, u8::max);
    let mut colours: Vec<u8> = (0..count).flat_map(phase_colour).collect();
    colours.resize(3 * 256, 0);
    colours
}
