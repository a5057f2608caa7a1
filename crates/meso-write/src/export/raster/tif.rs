//! TIFF (`.tif`): a page for every layer, lowest z first, or one page of a section. By the crate `tiff`.
//!
//! The resolution is the voxels' own, in pixels per centimetre. The first page has ImageJ's description of a volume: the
//! number of slices and their distance in cm, the unit of the resolution, and thereby the axes z, y and x. Images near 4 GB and beyond are BigTIFF.

use super::{Frame, Voxels};
use std::io::{self, Seek, Write};
use tiff::TiffError;
use tiff::encoder::colortype::{ColorType, Gray8, Gray32Float, GrayI32};
use tiff::encoder::{Rational, TiffEncoder, TiffKind, TiffValue};
use tiff::tags::{ResolutionUnit, Tag};

/// Bytes of values from which offsets need 64 bits: directories and padding come on top.
const LARGE: usize = 3_900_000_000;

/// Writes an image to `out`, slab by slab.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(frame: &Frame, slabs: impl Iterator<Item = Voxels>, out: impl Write + Seek) -> io::Result<()> {
    let is_large = frame.counts.iter().product::<usize>() * frame.kind.bytes() > LARGE;
    let written = if is_large {
        TiffEncoder::new_big(out).and_then(|encoder| pages(frame, slabs, encoder))
    } else {
        TiffEncoder::new(out).and_then(|encoder| pages(frame, slabs, encoder))
    };
    written.map_err(|error| match error {
        TiffError::IoError(error) => error,
        other => io::Error::other(other),
    })
}

fn pages<W: Write + Seek, K: TiffKind>(
    frame: &Frame,
    slabs: impl Iterator<Item = Voxels>,
    mut encoder: TiffEncoder<W, K>,
) -> Result<(), TiffError> {
    let ([rows, columns], _) = frame.pictures();
    let of_page = rows as usize * columns as usize;
    let mut first = true;
    let mut about = || std::mem::take(&mut first).then(|| description(frame)).flatten();
    for slab in slabs {
        match &slab {
            Voxels::Label(values) => {
                values
                    .chunks_exact(of_page)
                    .try_for_each(|page| add::<Gray8, _, _>(frame, page, about(), &mut encoder))?;
            }
            Voxels::Id(values) => {
                values
                    .chunks_exact(of_page)
                    .try_for_each(|page| add::<GrayI32, _, _>(frame, page, about(), &mut encoder))?;
            }
            Voxels::Real(values) => {
                values
                    .chunks_exact(of_page)
                    .try_for_each(|page| add::<Gray32Float, _, _>(frame, page, about(), &mut encoder))?;
            }
        }
    }
    Ok(())
}

fn add<C: ColorType, W: Write + Seek, K: TiffKind>(
    frame: &Frame,
    page: &[C::Inner],
    about: Option<String>,
    encoder: &mut TiffEncoder<W, K>,
) -> Result<(), TiffError>
where
    [C::Inner]: TiffValue,
{
    let ([rows, columns], _) = frame.pictures();
    let mut image = encoder.new_image::<C>(columns, rows)?;
    image.resolution(ResolutionUnit::Centimeter, per_cm(frame.voxel_size_mm));
    if let Some(about) = about {
        image.encoder().write_tag(Tag::ImageDescription, about.as_str())?;
    }
    image.write_data(page)
}

/// The description by which ImageJ knows a volume; `None` of a section.
fn description(frame: &Frame) -> Option<String> {
    let (_, slices) = frame.pictures();
    frame.section.is_none().then(|| {
        let lines = [
            "ImageJ=1.54f".to_owned(),
            format!("images={slices}"),
            format!("slices={slices}"),
            "unit=cm".to_owned(),
            format!("spacing={}", frame.voxel_size_mm / 10.0),
            "loop=false".to_owned(),
        ];
        lines.join("\n") + "\n"
    })
}

/// Pixels per centimetre, to a millionth.
fn per_cm(voxel_size_mm: f64) -> Rational {
    let mut d = 1_000_000_u32;
    while d > 1 && 10.0 / voxel_size_mm * f64::from(d) > f64::from(u32::MAX) {
        d /= 10;
    }
    Rational { n: (10.0 / voxel_size_mm * f64::from(d)).round() as u32, d }
}
