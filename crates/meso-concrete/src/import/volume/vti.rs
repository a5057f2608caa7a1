//! VTK image data (`.vti`): the first scalar array of the cells, or else of the points.
//!
//! Values are text, base64 or appended as they come, and may be compressed by zlib in blocks.

use super::{Kind, LabelNumber, Number, Values, Volume, VolumeError};
use flate2::read::ZlibDecoder;
use std::io::Read;

const FIX: &str = "write it by ParaView's or PyVista's own writer";
const NO_IMAGE: VolumeError = VolumeError::Begin("VTK image data");

pub(super) fn read<N: LabelNumber>(bytes: &[u8]) -> Result<Volume<N>, VolumeError> {
    let end = find(bytes, b"<AppendedData").unwrap_or(bytes.len());
    let head = str::from_utf8(&bytes[..end]).map_err(|_| NO_IMAGE)?;
    let file = tag(head, "VTKFile").ok_or(NO_IMAGE)?;
    let image = tag(head, "ImageData").ok_or(NO_IMAGE)?;
    let extent: Vec<i64> = numbers(attribute(image, "WholeExtent").ok_or(VolumeError::Missing("WholeExtent"))?);
    let [x0, x1, y0, y1, z0, z1] = extent[..] else { return Err(VolumeError::Missing("WholeExtent")) };
    let spacing: Vec<f64> = attribute(image, "Spacing").map(numbers).unwrap_or_default();
    let file = File {
        is_big: attribute(file, "byte_order") == Some("BigEndian"),
        header: if attribute(file, "header_type") == Some("UInt64") { 8 } else { 4 },
        compressor: attribute(file, "compressor"),
        appended: &bytes[end..],
    };
    let counts = |points: i64| {
        [(x0, x1), (y0, y1), (z0, z1)]
            .map(|(from, to)| usize::try_from(i128::from(to) - i128::from(from) + i128::from(points)).unwrap_or(0))
    };
    let (array, counts) = match (array(head, "CellData"), array(head, "PointData")) {
        (Some(array), _) => (array, counts(0)),
        (None, Some(array)) => (array, counts(1)),
        (None, None) => return Err(VolumeError::Missing("scalar array")),
    };
    let mut values = Values::default();
    file.read(array, &mut values)?;
    values.volume(counts, <[f64; 3]>::try_from(spacing).ok())
}

/// An array's tag, and the text that follows.
type Array<'a> = (&'a str, &'a str);

/// The scalar array that a section names as its scalars, or else its first.
fn array<'a>(head: &'a str, section: &str) -> Option<Array<'a>> {
    let (_, rest) = head.split_once(&format!("<{section}"))?;
    let (body, _) = rest.split_once(&format!("</{section}>"))?;
    let scalars = body.split('>').next().and_then(|tag| attribute(tag, "Scalars"));
    let arrays = || body.split("<DataArray").skip(1).filter_map(|text| text.split_once('>'));
    let arrays = || arrays().filter(|(tag, _)| attribute(tag, "NumberOfComponents").is_none_or(|count| count == "1"));
    arrays().find(|(tag, _)| scalars.is_some() && attribute(tag, "Name") == scalars).or_else(|| arrays().next())
}

/// How a file stores its arrays.
struct File<'a> {
    is_big: bool,
    /// Bytes of a length.
    header: usize,
    compressor: Option<&'a str>,
    /// From the tag `AppendedData` on.
    appended: &'a [u8],
}

impl File<'_> {
    fn read<N: LabelNumber>(&self, (tag, text): Array<'_>, values: &mut Values<N>) -> Result<(), VolumeError> {
        let name = attribute(tag, "type").ok_or(VolumeError::Missing("type of an array"))?;
        let unread = |found: String| VolumeError::Unread { found, fix: FIX };
        let kind = kind_of(name).ok_or_else(|| unread(format!("the type `{}`", name.escape_debug())))?;
        let inline = text.split('<').next().unwrap_or_default();
        match attribute(tag, "format") {
            None | Some("ascii") => {
                let mut all = inline.split_ascii_whitespace();
                all.try_for_each(|word| values.add_real(word.parse().unwrap_or(f64::NAN)))
            }
            Some("binary") => values.add_bytes(&self.unpacked(&decoded(inline.as_bytes()))?, kind, self.is_big),
            Some("appended") => {
                let offset = attribute(tag, "offset").and_then(|text| text.parse().ok()).unwrap_or(0);
                values.add_bytes(&self.read_appended(offset)?, kind, self.is_big)
            }
            Some(other) => Err(unread(format!("the format `{}`", other.escape_debug()))),
        }
    }

    fn read_appended(&self, offset: usize) -> Result<Vec<u8>, VolumeError> {
        let cut = || VolumeError::Cut("values");
        let start = find(self.appended, b"_").ok_or_else(cut)?;
        let tag = str::from_utf8(&self.appended[..start]).map_err(|_| cut())?;
        let data = self.appended.get((start + 1).saturating_add(offset)..).ok_or_else(cut)?;
        if attribute(tag, "encoding") == Some("base64") {
            let end = find(data, b"<").unwrap_or(data.len());
            return self.unpacked(&decoded(&data[..end]));
        }
        self.unpacked(data)
    }

    fn length(&self, data: &[u8], number: usize) -> Result<usize, VolumeError> {
        let bytes = data.get(number * self.header..).and_then(|rest| rest.get(..self.header));
        let bytes = bytes.ok_or(VolumeError::Cut("values"))?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        let length = if self.is_big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) };
        usize::try_from(length).map_err(|_| VolumeError::Cut("values"))
    }

    /// Values after their length, or blocks after their lengths.
    fn unpacked(&self, data: &[u8]) -> Result<Vec<u8>, VolumeError> {
        let cut = || VolumeError::Cut("values");
        match self.compressor {
            None => {
                let length = self.length(data, 0)?;
                data.get(self.header..).and_then(|rest| rest.get(..length)).map(<[u8]>::to_vec).ok_or_else(cut)
            }
            Some("vtkZLibDataCompressor") => {
                let [blocks, size] = [self.length(data, 0)?, self.length(data, 1)?];
                let mut rest = blocks.checked_add(3).and_then(|count| count.checked_mul(self.header));
                let mut rest = rest.take().and_then(|start| data.get(start..)).ok_or_else(cut)?;
                let mut all = Vec::new();
                for block in 0..blocks {
                    let (packed, after) = rest.split_at_checked(self.length(data, 3 + block)?).ok_or_else(cut)?;
                    ZlibDecoder::new(packed).take(size as u64).read_to_end(&mut all).map_err(|_| cut())?;
                    rest = after;
                }
                Ok(all)
            }
            Some(other) => {
                let found = format!("the compressor `{}`", other.escape_debug());
                Err(VolumeError::Unread { found, fix: "compress it by zlib, or not at all" })
            }
        }
    }
}

fn kind_of(name: &str) -> Option<Kind> {
    let digits = name.trim_start_matches(|letter: char| letter.is_ascii_alphabetic());
    let number = match &name[..name.len() - digits.len()] {
        "UInt" => Number::Unsigned,
        "Int" => Number::Signed,
        "Float" => Number::Real,
        _ => return None,
    };
    let size = match (number, digits) {
        (Number::Unsigned | Number::Signed, "8") => 1,
        (Number::Unsigned | Number::Signed, "16") => 2,
        (_, "32") => 4,
        (_, "64") => 8,
        _ => return None,
    };
    Some(Kind { number, size })
}

/// The text of the first tag of a name, up to its end.
fn tag<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    text.split_once(&format!("<{name}"))?.1.split('>').next()
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let rest = tag.split_once(&format!(" {name}=")).map(|(_, rest)| rest)?;
    let quote = rest.chars().next().filter(|first| ['"', '\''].contains(first))?;
    rest[1..].split(quote).next()
}

/// The numbers of a list; what is none ends it.
fn numbers<T: std::str::FromStr>(text: &str) -> Vec<T> {
    text.split_ascii_whitespace().map_while(|word| word.parse().ok()).collect()
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|window| window == wanted)
}

/// Bytes of base64; each group of four may end one of several texts in a row.
fn decoded(text: &[u8]) -> Vec<u8> {
    let value = |letter: &u8| match letter {
        b'A'..=b'Z' => Some(letter - b'A'),
        b'a'..=b'z' => Some(letter - b'a' + 26),
        b'0'..=b'9' => Some(letter - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let letters: Vec<u8> = text.iter().copied().filter(|letter| !letter.is_ascii_whitespace()).collect();
    let group = |group: &[u8]| {
        let bits = group.iter().fold(0_u32, |bits, letter| bits << 6 | u32::from(value(letter).unwrap_or(0)));
        let count = group.iter().filter(|letter| value(letter).is_some()).count() * 3 / 4;
        bits.to_be_bytes().into_iter().skip(1).take(count)
    };
    letters.chunks_exact(4).flat_map(group).collect()
}
