//! VTK image data (`.vti`): the scalars of the cells, or else of the points, or the array of a name. Arrays that VTK reserves
//! for itself are passed over.
//!
//! Values are text, base64 or appended as they come, and may be compressed by zlib in blocks.

use super::xml::{attribute, tag, tags};
use super::{Kind, LabelNumber, Number, Values, Volume, VolumeError, Wanted, voxels};
use crate::short::short;
use flate2::read::ZlibDecoder;
use std::io::Read;

const FIX: &str = "write it by ParaView's or PyVista's own writer";
const NO_IMAGE: VolumeError = VolumeError::Begin("VTK image data");
/// Arrays that VTK adds for itself: vtkGhostType, and numbers of cells and points.
const RESERVED: [&str; 3] = ["vtk", "Global", "Pedigree"];

pub(super) fn read<N: LabelNumber>(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Volume<N>, VolumeError> {
    let end = find(bytes, b"<AppendedData").unwrap_or(bytes.len());
    let head = str::from_utf8(&bytes[..end]).map_err(|_| NO_IMAGE)?;
    let file = tag(head, "VTKFile").ok_or(NO_IMAGE)?;
    let image = tag(head, "ImageData").ok_or(NO_IMAGE)?;
    let extent: Vec<i64> = numbers(attribute(image, "WholeExtent").ok_or(VolumeError::Missing("WholeExtent"))?);
    let [x0, x1, y0, y1, z0, z1] = extent[..] else { return Err(VolumeError::Missing("WholeExtent")) };
    is_whole(head, &extent)?;
    let spacing = placed(image)?;
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
    let sections = [("CellData", 0), ("PointData", 1)].map(|(name, points)| (Section::of(head, name), counts(points)));
    let (array, counts, note) = chosen(&sections, wanted.array)?;
    let volume: Volume<N> = file.read(array, counts, wanted)?.volume(counts, spacing)?;
    let size_note = volume.spacing_mm.and_then(|spacing| unit_note(spacing, volume.counts));
    Ok(Volume { array_note: note, size_note: size_note.or(volume.size_note), ..volume })
}

/// Doubt about a length in mm that no specimen has: files of VTK have no unit.
fn unit_note(spacing: [f64; 3], counts: [usize; 3]) -> Option<String> {
    // Concrete is scanned and made between a core of a few millimetres and a wall. In metres the wall is below the first.
    const SPECIMENS_MM: [f64; 2] = [0.5, 5000.0];
    let longest = spacing.iter().zip(counts).map(|(h, count)| h * count as f64).fold(0.0, f64::max);
    let (unit, mm) = match longest {
        longest if longest < SPECIMENS_MM[0] => ("metres", 1e3),
        longest if longest > SPECIMENS_MM[1] => ("micrometres", 1e-3),
        _ => return None,
    };
    let edges = spacing.map(|h| short(h * mm).to_string()).join(",");
    let longest = short(longest);
    Some(format!(
        "the file has no unit, and in mm its volume is {longest} mm long; if it is in {unit}, a voxel has {edges} mm"
    ))
}

/// Refuses a file of several pieces.
fn is_whole(head: &str, extent: &[i64]) -> Result<(), VolumeError> {
    let mut pieces = tags(head, "Piece").filter_map(|piece| attribute(piece, "Extent"));
    if pieces.all(|piece| numbers::<i64>(piece) == extent) {
        return Ok(());
    }
    let fix = "write it as one piece, by PyVista's or ParaView's own writer";
    Err(VolumeError::Unread { found: "a piece of another extent than the whole".to_owned(), fix })
}

/// Edges of a voxel of an image whose axes are x, y, z.
fn placed(image: &str) -> Result<Option<[f64; 3]>, VolumeError> {
    const TURN: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    // Rounding of a direction that was written as text.
    const NEAR: f64 = 1e-6;
    if let Some(text) = attribute(image, "Direction") {
        let direction: Vec<f64> = numbers(text);
        if direction.len() != 9 || !direction.iter().zip(TURN).all(|(a, b)| (a - b).abs() <= NEAR) {
            let fix = "resample it along x, y, z, or set its direction to the unit matrix if only the shape counts";
            return Err(VolumeError::Unread { found: format!("an image turned by the Direction `{text}`"), fix });
        }
    }
    let Some(text) = attribute(image, "Spacing") else { return Ok(None) };
    match numbers::<f64>(text)[..] {
        [x, y, z] if [x, y, z].iter().all(|h| h.is_finite() && *h > 0.0) => Ok(Some([x, y, z])),
        _ => {
            let fix = "write three positive lengths";
            Err(VolumeError::Unread { found: format!("the Spacing `{}`", text.escape_debug()), fix })
        }
    }
}

/// An array's tag, and the text that follows.
type Array<'a> = (&'a str, &'a str);

/// The arrays of cells, or of points, with one value each.
struct Section<'a> {
    /// The array that the section names as its scalars.
    scalars: Option<&'a str>,
    arrays: Vec<Array<'a>>,
}

impl<'a> Section<'a> {
    fn of(head: &'a str, name: &str) -> Self {
        let body = head.split_once(&format!("<{name}")).and_then(|(_, rest)| rest.split_once(&format!("</{name}>")));
        let Some((body, _)) = body else { return Self { scalars: None, arrays: Vec::new() } };
        let scalars = body.split('>').next().and_then(|tag| attribute(tag, "Scalars"));
        let arrays = body.split("<DataArray").skip(1).filter_map(|text| text.split_once('>'));
        let is_scalar = |tag: &str| attribute(tag, "NumberOfComponents").is_none_or(|count| count.trim() == "1");
        let arrays = arrays.filter(|(tag, _)| is_scalar(tag) && !is_reserved(name_of(tag)));
        Self { scalars, arrays: arrays.collect() }
    }
}

fn is_reserved(name: &str) -> bool {
    let is_number = ["Ids", "Id"].iter().any(|end| name.ends_with(end));
    name.starts_with(RESERVED[0]) || is_number && RESERVED[1..].iter().any(|begin| name.starts_with(begin))
}

fn name_of(tag: &str) -> &str {
    attribute(tag, "Name").unwrap_or_default()
}

/// The array of a name; without a name the scalars of the cells, or else of the points, and a remark if there are others.
fn chosen<'a>(
    sections: &[(Section<'a>, [usize; 3]); 2],
    name: Option<&str>,
) -> Result<(Array<'a>, [usize; 3], Option<String>), VolumeError> {
    let all =
        || sections.iter().flat_map(|(section, counts)| section.arrays.iter().map(move |array| (*array, *counts)));
    let names = || all().map(|((tag, _), _)| name_of(tag).to_owned()).collect::<Vec<_>>();
    if let Some(name) = name {
        let found = all().find(|((tag, _), _)| name_of(tag) == name);
        let missing = || VolumeError::Array { array: name.to_owned(), found: names() };
        return found.map(|(array, counts)| (array, counts, None)).ok_or_else(missing);
    }
    let active = sections.iter().find(|(section, _)| !section.arrays.is_empty());
    let Some((section, counts)) = active else { return Err(VolumeError::Missing("scalar array")) };
    let is_active = |(tag, _): &&Array<'_>| section.scalars == Some(name_of(tag));
    let array = *section.arrays.iter().find(is_active).unwrap_or(&section.arrays[0]);
    let names = names();
    let note = (names.len() > 1).then(|| {
        let own = name_of(array.0).escape_debug();
        format!("the file has {} arrays, and `{own}` was read; for array {}", names.len(), super::arrays(&names))
    });
    Ok((array, *counts, note))
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
    fn read<N: LabelNumber>(
        &self,
        (tag, text): Array<'_>,
        counts: [usize; 3],
        wanted: &Wanted<'_>,
    ) -> Result<Values<N>, VolumeError> {
        let name = attribute(tag, "type").ok_or(VolumeError::Missing("type of an array"))?;
        let unread = |found: String| VolumeError::Unread { found, fix: FIX };
        let kind = kind_of(name).ok_or_else(|| unread(format!("the type `{}`", name.escape_debug())))?;
        let inline = text.split('<').next().unwrap_or_default();
        let size = voxels(counts).and_then(|count| count.checked_mul(kind.size)).ok_or(VolumeError::Cut("values"))?;
        let mut values = Values::of(counts, size, wanted)?;
        match attribute(tag, "format") {
            None | Some("ascii") => {
                let mut all = inline.split_ascii_whitespace();
                all.try_for_each(|word| match (kind.number, word.parse()) {
                    (Number::Unsigned, Ok(label)) => values.add_unsigned(label),
                    (Number::Signed, _) if word.parse::<i64>().is_ok() => values.add(word.parse().unwrap_or_default()),
                    _ => values.add_real(word.parse().unwrap_or(f64::NAN)),
                })?;
            }
            Some("binary") => {
                values.add_bytes(&self.unpacked(&decoded(inline.as_bytes())?, size)?, kind, self.is_big)?;
            }
            Some("appended") => {
                let offset = attribute(tag, "offset").and_then(|text| text.parse().ok()).unwrap_or(0);
                values.add_bytes(&self.read_appended(offset, size)?, kind, self.is_big)?;
            }
            Some(other) => return Err(unread(format!("the format `{}`", other.escape_debug()))),
        }
        Ok(values)
    }

    fn read_appended(&self, offset: usize, size: usize) -> Result<Vec<u8>, VolumeError> {
        let cut = || VolumeError::Cut("values");
        let start = find(self.appended, b"_").ok_or_else(cut)?;
        let tag = str::from_utf8(&self.appended[..start]).map_err(|_| cut())?;
        let data = self.appended.get((start + 1).saturating_add(offset)..).ok_or_else(cut)?;
        if attribute(tag, "encoding") == Some("base64") {
            let end = find(data, b"<").unwrap_or(data.len());
            return self.unpacked(&decoded(&data[..end])?, size);
        }
        self.unpacked(data, size)
    }

    fn length(&self, data: &[u8], number: usize) -> Result<usize, VolumeError> {
        let bytes = data.get(number * self.header..).and_then(|rest| rest.get(..self.header));
        let bytes = bytes.ok_or(VolumeError::Cut("values"))?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        let length = if self.is_big { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) };
        usize::try_from(length).map_err(|_| VolumeError::Cut("values"))
    }

    /// Values after their length, or blocks after their lengths: as many bytes as the image has.
    fn unpacked(&self, data: &[u8], wanted: usize) -> Result<Vec<u8>, VolumeError> {
        let cut = || VolumeError::Cut("values");
        match self.compressor {
            None => {
                let length = self.length(data, 0)?;
                let part = data.get(self.header..).and_then(|rest| rest.get(..length)).ok_or_else(cut)?;
                if length != wanted {
                    return Err(cut());
                }
                let mut all = room(length)?;
                all.extend_from_slice(part);
                Ok(all)
            }
            Some("vtkZLibDataCompressor") => {
                let blocks = self.length(data, 0)?;
                let mut rest = blocks.checked_add(3).and_then(|count| count.checked_mul(self.header));
                let mut rest = rest.take().and_then(|start| data.get(start..)).ok_or_else(cut)?;
                let mut all = room(wanted)?;
                for block in 0..blocks {
                    let (packed, after) = rest.split_at_checked(self.length(data, 3 + block)?).ok_or_else(cut)?;
                    // The file's own sizes are not believed: what the image has no voxels for is not unpacked.
                    let left = (wanted - all.len()) as u64;
                    ZlibDecoder::new(packed).take(left + 1).read_to_end(&mut all).map_err(|_| cut())?;
                    if all.len() > wanted {
                        return Err(cut());
                    }
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

/// An empty list with room for so many bytes.
fn room(bytes: usize) -> Result<Vec<u8>, VolumeError> {
    let mut all = Vec::new();
    all.try_reserve_exact(bytes).map_err(|_| VolumeError::Memory)?;
    Ok(all)
}

/// The numbers of a list; what is none ends it.
fn numbers<T: std::str::FromStr>(text: &str) -> Vec<T> {
    text.split_ascii_whitespace().map_while(|word| word.parse().ok()).collect()
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|window| window == wanted)
}

/// Bytes of base64; each group of four may end one of several texts in a row.
fn decoded(text: &[u8]) -> Result<Vec<u8>, VolumeError> {
    let value = |letter: u8| match letter {
        b'A'..=b'Z' => Some(letter - b'A'),
        b'a'..=b'z' => Some(letter - b'a' + 26),
        b'0'..=b'9' => Some(letter - b'0' + 52),
        b'+' => Some(62),
        b'/' => Some(63),
        _ => None,
    };
    let mut all = room(text.len() / 4 * 3)?;
    let mut letters = text.iter().copied().filter(|letter| !letter.is_ascii_whitespace());
    while let (Some(a), Some(b), Some(c), Some(d)) = (letters.next(), letters.next(), letters.next(), letters.next()) {
        let group = [a, b, c, d].map(value);
        let bits = group.iter().fold(0_u32, |bits, value| bits << 6 | u32::from(value.unwrap_or(0)));
        all.extend_from_slice(&bits.to_be_bytes()[1..][..group.iter().flatten().count() * 3 / 4]);
    }
    Ok(all)
}
