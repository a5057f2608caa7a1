//! Which format a file has by its first bytes, for the error of one whose name says another.

use super::words::{is, lines_of_words, number};
use super::{ending, list, off};

/// A format that people bring, whether it is read or not.
struct FileFormat {
    /// With its article.
    name: &'static str,
    /// Endings of such files' names; the usual one first.
    endings: &'static [&'static str],
}

const PLY: FileFormat = FileFormat { name: "a PLY", endings: &["ply"] };
const OFF: FileFormat = FileFormat { name: "an OFF", endings: &["off"] };
const STL: FileFormat = FileFormat { name: "an STL", endings: &["stl"] };
const OBJ: FileFormat = FileFormat { name: "an OBJ", endings: &["obj"] };
const JSON: FileFormat = FileFormat { name: "a JSON", endings: &["json"] };
const COEFFICIENTS: FileFormat = FileFormat { name: "a harmonics", endings: &["dat", "anm", "txt"] };
const TIFF: FileFormat = FileFormat { name: "a TIFF", endings: &["tif", "tiff"] };
const NUMPY: FileFormat = FileFormat { name: "a NumPy", endings: &["npy"] };
const VTK_IMAGE: FileFormat = FileFormat { name: "a VTK image", endings: &["vti"] };
const GZIP: FileFormat = FileFormat { name: "a gzip", endings: &["gz"] };
const ZIP: FileFormat = FileFormat { name: "a ZIP", endings: &["zip", "3mf", "npz"] };
const GLTF: FileFormat = FileFormat { name: "a glTF", endings: &["glb"] };

/// First bytes that are a format's own.
const MAGIC: [(&[u8], FileFormat); 12] = [
    (b"ply\n", PLY),
    (b"ply\r", PLY),
    (b"\x93NUMPY", NUMPY),
    (b"II*\0", TIFF),
    (b"II+\0", TIFF),
    (b"MM\0*", TIFF),
    (b"MM\0+", TIFF),
    (b"\x1f\x8b", GZIP),
    (b"PK\x03\x04", ZIP),
    (b"glTF", GLTF),
    // A brace or a bracket opens.
    (b"\x7b", JSON),
    (b"\x5b", JSON),
];

/// Explains a file that is not what its name says: its format, and the fix. `read_here` are the endings that its reader takes.
/// `None` for a file of the format that its name says, or of an unknown one.
pub fn misnamed(name: &str, bytes: &[u8], read_here: &[&str]) -> Option<String> {
    let FileFormat { name: format, endings } = format_of(bytes)?;
    let said = ending(name).unwrap_or_default();
    if endings.contains(&said.as_str()) {
        return None;
    }
    let fix = match endings.iter().find(|ending| read_here.contains(ending)) {
        Some(ending) => format!("; let its name end in .{ending}"),
        None if [GZIP.name, ZIP.name].contains(&format) => "; unpack it first".to_owned(),
        None => format!(", which is not read here: name one that ends in {}", list(read_here)),
    };
    Some(format!("it begins as {format} file does{fix}"))
}

fn format_of(bytes: &[u8]) -> Option<FileFormat> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    // Records of 50 bytes follow their number; texts have none that fits.
    let triangles = bytes.get(80..84).map(|count| count.iter().rev().fold(0, |n, byte| n << 8 | usize::from(*byte)));
    let is_binary_stl = triangles.is_some_and(|count| count > 0 && 84 + 50 * count == bytes.len());
    if is_binary_stl {
        return Some(STL);
    }
    let magic = MAGIC.into_iter().find(|(magic, _)| text.starts_with(magic)).map(|(_, format)| format);
    magic.or_else(|| format_of_text(text))
}

/// Bytes of a text that are looked at.
const HEAD: usize = 4096;

fn format_of_text(text: &[u8]) -> Option<FileFormat> {
    let head = &text[..text.len().min(HEAD)];
    let holds = |part: &[u8]| head.windows(part.len()).any(|window| window == part);
    if head.starts_with(b"<") {
        return holds(b"ImageData").then_some(VTK_IMAGE);
    }
    let (_, words) = lines_of_words(head).next()?;
    if is(words[0], "solid") && holds(b"facet") {
        return Some(STL);
    }
    if off::vertex(words[0]).is_some() {
        return Some(OFF);
    }
    let is_coefficient = |words: &[&[u8]]| words.len() == 4 && words.iter().all(|word| number::<f64>(word).is_some());
    if is_coefficient(&words) && is(words[0], "0") && is(words[1], "0") {
        return Some(COEFFICIENTS);
    }
    let is_corner = |words: &[&[u8]]| words.len() >= 4 && is(words[0], "v") && number::<f64>(words[1]).is_some();
    lines_of_words(head).any(|(_, words)| is_corner(&words)).then_some(OBJ)
}
