//! TIFF (`.tif`): a grey or palette page for every layer, lowest z first, or one page. By the crate `tiff`.
//!
//! The head of the file is read first, so that sizes are known before memory is taken. The spacing is ImageJ's (pixels per
//! unit along x and y, distance of slices and unit in the description) or OME-XML's. The resolution of other programs is that
//! of a printer, so it is ignored. Smaller copies of pages are passed over.

mod about;
mod head;

use super::{LabelNumber, Values, Volume, VolumeError, Wanted};
use head::{FROM_THE_TOP_LEFT, HEIGHT, Head, Page, WHITE_IS_ZERO, WIDTH};
use std::borrow::Cow;
use std::io::Cursor;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::{ColorType, TiffError};

const FIX: &str = "save one grey page for every layer, as a .tif without compression";
/// Most bytes of a value of a pixel.
const VALUE: usize = 8;

pub(super) fn read<N: LabelNumber>(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Volume<N>, VolumeError> {
    let head = Head::new(bytes)?;
    let pages = head.pages()?;
    let counts = counts(&head, &pages)?;
    let first = pages.iter().find(|page| !page.is_reduced(&head)).ok_or(VolumeError::Empty)?;
    let about = about::Pages {
        counts,
        pixel: [282, 283].map(|tag| head.quotient(first, tag).map(|value| 1.0 / value).filter(|h| h.is_normal())),
        unit: head.of(first, 296).unwrap_or(2),
        descriptions: pages.iter().filter(|page| !page.is_reduced(&head) && !head.description(page).is_empty()).count(),
    };
    let about = about.described(&head.description(first))?;
    let mut values = Values::of(counts, (VALUE * counts[0]).saturating_mul(counts[1]), wanted)?;
    let bytes = without_palettes(&head, &pages, bytes)?;
    let mut decoder = Decoder::new(Cursor::new(&*bytes)).map_err(fault)?.with_limits(limits(counts, bytes.len()));
    for (number, page) in pages.iter().enumerate() {
        if number > 0 {
            decoder.next_image().map_err(fault)?;
        }
        if !page.is_reduced(&head) {
            read_page(&mut decoder, [counts[0], counts[1]], &mut values).map_err(|error| match error {
                // The decoder does not find the end of some tiles that are whole (image-rs/image-tiff, issue 395).
                VolumeError::Cut(_) if page.is_lzw(&head) => {
                    unread("its LZW compression, which ends too early,".to_owned())
                }
                other => other,
            })?;
        }
    }
    values
        .volume(counts, about.spacing_mm)
        .map(|volume| Volume { size_note: about.note.or(volume.size_note), ..volume })
}

/// Pixels along x and y, and pages.
fn counts(head: &Head<'_>, pages: &[Page]) -> Result<[usize; 3], VolumeError> {
    let size = |page: &Page| [WIDTH, HEIGHT].map(|tag| head.of(page, tag).unwrap_or(0) as usize);
    let whole = || pages.iter().filter(|page| !page.is_reduced(head)).enumerate();
    let Some((_, first)) = whole().next() else { return Err(VolumeError::Empty) };
    for (number, page) in whole() {
        if size(page) != size(first) {
            return Err(unread(format!("page {number}, counted from 0, of another size than the first")));
        }
        if page.slices(head) > 1 {
            return Err(unread(format!("a page that holds {} slices", page.slices(head))));
        }
        if page.orientation(head) != FROM_THE_TOP_LEFT {
            let fix = "save its rows from the top and its pixels from the left";
            return Err(VolumeError::Unread {
                found: format!("a page turned by the Orientation {}", page.orientation(head)),
                fix,
            });
        }
        if head.photometric(page) == Some(WHITE_IS_ZERO) {
            return Err(unread("a page whose zeros are white".to_owned()));
        }
    }
    let [width, height] = size(first);
    Ok([width, height, whole().count()])
}

/// The file, with its palettes marked as grey.
fn without_palettes<'a>(head: &Head<'_>, pages: &[Page], bytes: &'a [u8]) -> Result<Cow<'a, [u8]>, VolumeError> {
    if !pages.iter().any(|page| head.photometric(page) == Some(head::PALETTE)) {
        return Ok(Cow::Borrowed(bytes));
    }
    let mut copy = Vec::new();
    copy.try_reserve_exact(bytes.len()).map_err(|_| VolumeError::Memory)?;
    copy.extend_from_slice(bytes);
    pages.iter().for_each(|page| head.without_palette(page, &mut copy));
    Ok(Cow::Owned(copy))
}

/// A page may take what its size says; all else lies in the file.
fn limits([width, height, _]: [usize; 3], file: usize) -> Limits {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = (VALUE * width).saturating_mul(height);
    limits.intermediate_buffer_size = limits.decoding_buffer_size.saturating_add(file);
    limits.ifd_value_size = file;
    limits
}

fn read_page<N: LabelNumber>(
    decoder: &mut Decoder<Cursor<&[u8]>>,
    [width, height]: [usize; 2],
    values: &mut Values<N>,
) -> Result<(), VolumeError> {
    let (before, pixels) = (values.of.len(), width * height);
    let kind = decoder.colortype().map_err(fault)?;
    match decoder.read_image().map_err(fault)? {
        DecodingResult::U8(page) => match kind {
            ColorType::Gray(bits @ (1 | 2 | 4)) => {
                // Each row begins with a byte of its own, and its first pixel has the highest bits.
                let of_byte = 8 / usize::from(bits);
                let value = |row: &[u8], x: usize| {
                    let shift = 8 - usize::from(bits) * (x % of_byte + 1);
                    row[x / of_byte] >> shift & ((1 << bits) - 1)
                };
                let row = |row: &[u8]| (0..width).map(|x| value(row, x)).collect::<Vec<_>>();
                page.chunks_exact(width.div_ceil(of_byte)).flat_map(row).try_for_each(|value| values.add(value.into()))
            }
            _ => page.into_iter().try_for_each(|value| values.add(value.into())),
        },
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
    match values.of.len() - before {
        found if found == pixels => Ok(()),
        found if found > pixels && found % pixels == 0 => {
            let fix = "save the labels as grey values; colours are no labels";
            Err(VolumeError::Unread { found: format!("a page with {} values a pixel", found / pixels), fix })
        }
        found => Err(unread(format!("a page with {found} values for {pixels} pixels"))),
    }
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
