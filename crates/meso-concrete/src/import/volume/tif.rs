//! TIFF (`.tif`): a grey page for every layer, lowest z first, or one page. By the crate `tiff`.
//!
//! The spacing is ImageJ's: pixels per unit along x and y, and the distance of slices and the unit in the description. The
//! resolution of other programs is that of a printer, so it is ignored.

use super::{LabelNumber, Values, Volume, VolumeError};
use std::io::Cursor;
use tiff::ColorType;
use tiff::TiffError;
use tiff::decoder::ifd::Value;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

const FIX: &str = "save one grey page for every layer, without compression";

/// Photometric interpretation where 0 is white: programs differ in whether they turn such values round.
const WHITE_IS_ZERO: u32 = 0;

pub(super) fn read<N: LabelNumber>(bytes: &[u8]) -> Result<Volume<N>, VolumeError> {
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(fault)?;
    let (width, height) = decoder.dimensions().map_err(fault)?;
    let about = decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default();
    let spacing_mm = spacing(&mut decoder, &about);
    let (mut values, mut pages) = (Values::default(), 0);
    loop {
        if decoder.dimensions().map_err(fault)? != (width, height) {
            return Err(unread(format!("page {pages}, counted from 0, of another size than the first")));
        }
        page(&mut decoder, [width as usize, height as usize], &mut values)?;
        pages += 1;
        if !decoder.more_images() {
            break;
        }
        decoder.next_image().map_err(fault)?;
    }
    let stated = number(&about, "images").unwrap_or(1.0) as usize;
    if pages == 1 && stated > 1 {
        return Err(unread(format!("a page that holds {stated} images")));
    }
    values.volume([width as usize, height as usize, pages], spacing_mm)
}

fn page<N: LabelNumber>(
    decoder: &mut Decoder<Cursor<&[u8]>>,
    [width, height]: [usize; 2],
    values: &mut Values<N>,
) -> Result<(), VolumeError> {
    let (before, pixels) = (values.of.len(), width * height);
    let kind = decoder.colortype().map_err(fault)?;
    if decoder.get_tag_u32(Tag::PhotometricInterpretation).map_err(fault)? == WHITE_IS_ZERO {
        return Err(unread("a page whose zeros are white".to_owned()));
    }
    match decoder.read_image().map_err(fault)? {
        DecodingResult::U8(page) if kind == ColorType::Gray(1) => {
            // Each row begins with a byte of its own, and its first pixel is the highest bit.
            let bits = |row: &[u8]| (0..width).map(|x| row[x / 8] >> (7 - x % 8) & 1).collect::<Vec<_>>();
            page.chunks_exact(width.div_ceil(8)).flat_map(bits).try_for_each(|bit| values.add(bit.into()))
        }
        DecodingResult::U8(page) => page.into_iter().try_for_each(|value| values.add(value.into())),
        DecodingResult::U16(page) => page.into_iter().try_for_each(|value| values.add(value.into())),
        DecodingResult::U32(page) => page.into_iter().try_for_each(|value| values.add(value.into())),
        DecodingResult::U64(page) => page.into_iter().try_for_each(|value| values.add_unsigned(value)),
        DecodingResult::I8(page) => page.into_iter().try_for_each(|value| values.add(value.into())),
        DecodingResult::I16(page) => page.into_iter().try_for_each(|value| values.add(value.into())),
        DecodingResult::I32(page) => page.into_iter().try_for_each(|value| values.add(value.into())),
        DecodingResult::I64(page) => page.into_iter().try_for_each(|value| values.add(value)),
        DecodingResult::F32(page) => page.into_iter().try_for_each(|value| values.add_real(value.into())),
        DecodingResult::F64(page) => page.into_iter().try_for_each(|value| values.add_real(value)),
        DecodingResult::F16(_) => return Err(unread("a page of half precision".to_owned())),
    }?;
    let found = values.of.len() - before;
    if found == pixels { Ok(()) } else { Err(unread(format!("a page with {found} values for {pixels} pixels"))) }
}

/// Edges of a voxel that ImageJ describes, mm.
fn spacing(decoder: &mut Decoder<Cursor<&[u8]>>, about: &str) -> Option<[f64; 3]> {
    let unit = about.lines().find_map(|line| line.strip_prefix("unit="))?;
    let mm = match unit.trim() {
        "m" => 1e3,
        "cm" => 10.0,
        "mm" => 1.0,
        "um" | "µm" | "micron" | "microns" | "\\u00B5m" => 1e-3,
        "nm" => 1e-6,
        "inch" | "in" => 25.4,
        _ => return None,
    };
    let mut along = |tag: Tag| match decoder.get_tag(tag).ok()? {
        Value::List(parts) => match parts[..] {
            [Value::Rational(n, d)] => Some(f64::from(d) / f64::from(n)),
            _ => None,
        },
        Value::Rational(n, d) => Some(f64::from(d) / f64::from(n)),
        _ => None,
    };
    let (x, y) = (along(Tag::XResolution)?, along(Tag::YResolution)?);
    Some([x, y, number(about, "spacing").unwrap_or(x)].map(|h| h * mm))
}

/// The number after a key of ImageJ's description.
fn number(about: &str, key: &str) -> Option<f64> {
    let value = about.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='))?;
    value.trim().parse().ok()
}

fn unread(found: String) -> VolumeError {
    VolumeError::Unread { found, fix: FIX }
}

fn fault(error: TiffError) -> VolumeError {
    match error {
        TiffError::FormatError(
            tiff::TiffFormatError::TiffSignatureNotFound | tiff::TiffFormatError::TiffSignatureInvalid,
        ) => VolumeError::Begin("a TIFF file"),
        TiffError::IoError(_) => VolumeError::Cut("pages"),
        other => unread(format!("this file ({other})")),
    }
}
