//! Arrays of numpy (`.npy`), two or three axes, any byte order.

use super::{Kind, LabelNumber, Number, Values, Volume, VolumeError, Wanted, voxels};

const MAGIC: &[u8] = b"\x93NUMPY";
const FIX: &str = "save integers with two or three axes, as in numpy.save(\"labels.npy\", labels.astype(\"uint8\"))";

pub(super) fn read<N: LabelNumber>(bytes: &[u8], wanted: &Wanted<'_>) -> Result<Volume<N>, VolumeError> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(VolumeError::Begin("a file of numpy.save"))?;
    let cut = || VolumeError::Cut("header");
    // Two bytes of version, then the header's length in 2 bytes, or in 4 from version 2 on.
    let wide = *rest.first().ok_or_else(cut)? > 1;
    let length = rest.get(2..if wide { 6 } else { 4 }).ok_or_else(cut)?;
    let start = 2 + length.len();
    let length = length.iter().rev().fold(0, |sum, byte| sum << 8 | usize::from(*byte));
    let header = rest.get(start..start.saturating_add(length)).ok_or_else(cut)?;
    let header = str::from_utf8(header).map_err(|_| VolumeError::Begin("a file of numpy.save"))?;
    values(header, &rest[start + length..], wanted)
}

fn values<N: LabelNumber>(header: &str, data: &[u8], wanted: &Wanted<'_>) -> Result<Volume<N>, VolumeError> {
    let kind = entry(header, "descr").ok_or(VolumeError::Missing("descr"))?;
    let kind = kind.split('\'').nth(1).unwrap_or(kind);
    let unread = |found: String| VolumeError::Unread { found, fix: FIX };
    let (kind, is_big) = kind_of(kind).ok_or_else(|| unread(format!("the type `{}`", kind.escape_debug())))?;
    let shape = entry(header, "shape").and_then(|text| text.split(['(', ')']).nth(1));
    let shape = shape.ok_or(VolumeError::Missing("shape"))?;
    let lengths = shape.split(',').map(str::trim).filter(|length| !length.is_empty());
    let lengths = lengths.map(str::parse).collect::<Result<Vec<usize>, _>>();
    let lengths = lengths.map_err(|_| VolumeError::Missing("shape"))?;
    let is_fortran = entry(header, "fortran_order").is_some_and(|text| text.trim_start().starts_with("True"));
    let [z, y, x] = match lengths[..] {
        [y, x] => [1, y, x],
        [z, y, x] => [z, y, x],
        _ => {
            let found = format!("an array of {} axes", lengths.len());
            let is_squeezable = lengths.len() > 3 && lengths.iter().filter(|length| **length != 1).count() <= 3;
            let fix = if is_squeezable { "remove its axes of length 1 by numpy.squeeze" } else { FIX };
            return Err(VolumeError::Unread { found, fix });
        }
    };
    let size = voxels([x, y, z]).and_then(|count| count.checked_mul(kind.size));
    let data = size.and_then(|size| data.get(..size)).ok_or(VolumeError::Cut("values"))?;
    let beside = if is_fortran { size_of::<N>() * x * y * z } else { 0 };
    let mut values = Values::of([x, y, z], beside, wanted)?;
    values.add_bytes(data, kind, is_big)?;
    if is_fortran {
        let of = std::mem::take(&mut values.of);
        let at = |number: usize| of[(number % x * y + number / x % y) * z + number / (x * y)];
        values.of = (0..of.len()).map(at).collect();
    }
    values.volume([x, y, z], None)
}

/// The text after a key of the header.
fn entry<'a>(header: &'a str, key: &str) -> Option<&'a str> {
    let (_, rest) = header.split_once(&format!("'{key}'"))?;
    rest.trim_start().strip_prefix(':')
}

/// The type that a description such as `<i4` names, and whether its first byte is the largest.
fn kind_of(text: &str) -> Option<(Kind, bool)> {
    let (order, rest) = text.split_at_checked(1)?;
    let (number, size) = rest.split_at_checked(1)?;
    let number = match number {
        "u" | "b" => Number::Unsigned,
        "i" => Number::Signed,
        "f" => Number::Real,
        _ => return None,
    };
    let size = size.parse().ok()?;
    let least = if matches!(number, Number::Real) { 4 } else { 1 };
    ([1, 2, 4, 8].contains(&size) && size >= least).then_some((Kind { number, size }, order == ">"))
}
