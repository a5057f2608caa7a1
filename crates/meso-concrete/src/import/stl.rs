//! Triangle surfaces from STL, text or binary.
//!
//! The format has no units: a number is a millimetre. Normals are ignored; the order of the corners defines the
//! outside. A binary file may begin with "solid" like a text, so its length decides.

use meso_collision::geometry::TriangleMesh;
use meso_collision::math::Vec3;

const HEADER: usize = 80;
const RECORD: usize = 50;

/// Why bytes are no STL.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StlError {
    /// Neither form fits.
    #[error(
        "this is not an STL file: neither text that begins with `solid` nor a binary file of 84 + 50 n bytes, n the number at byte 80"
    )]
    NotStl,
    /// A line of a text that cannot be read.
    #[error("line {line}: `{found}` is not a vertex of three numbers")]
    Vertex {
        /// From 1.
        line: usize,
        /// The text found there.
        found: String,
    },
    /// No facets.
    #[error("it has no triangles")]
    Empty,
    /// Facets without three corners each.
    #[error("it has {corners} vertices, which is not a multiple of 3")]
    Incomplete {
        /// Number of `vertex` lines.
        corners: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error("triangle {triangle} has a coordinate that is not finite")]
    NotFinite {
        /// From 0.
        triangle: usize,
    },
}

/// Reads the surface in `bytes`, mm; corners at the same position become one vertex.
///
/// # Errors
/// See [`StlError`]. [`TriangleMesh::check_closed`] tests whether the surface is closed.
pub fn read(bytes: &[u8]) -> Result<TriangleMesh, StlError> {
    let corners = match binary_records(bytes) {
        Some(records) => records.chunks_exact(RECORD).flat_map(corners_of).collect(),
        None => text_corners(bytes)?,
    };
    if corners.is_empty() {
        return Err(StlError::Empty);
    }
    if corners.len() % 3 != 0 {
        return Err(StlError::Incomplete { corners: corners.len() });
    }
    if let Some(corner) = corners.iter().position(|p: &Vec3| !p.iter().all(|x| x.is_finite())) {
        return Err(StlError::NotFinite { triangle: corner / 3 });
    }
    Ok(TriangleMesh::welded(&corners))
}

/// The triangles of a binary file, whose length its count must fit.
fn binary_records(bytes: &[u8]) -> Option<&[u8]> {
    let count = bytes.get(HEADER..HEADER + 4)?;
    let count = u32::from_le_bytes(count.try_into().ok()?) as usize;
    let records = &bytes[HEADER + 4..];
    (records.len() == count.checked_mul(RECORD)?).then_some(records)
}

/// The corners of one record: a normal, three corners and two bytes of attributes.
fn corners_of(record: &[u8]) -> [Vec3; 3] {
    let number = |k: usize| f32::from_le_bytes([0, 1, 2, 3].map(|byte| record[4 * k + byte]));
    [1, 2, 3].map(|corner| Vec3::from_fn(|axis, _| f64::from(number(3 * corner + axis))))
}

fn text_corners(bytes: &[u8]) -> Result<Vec<Vec3>, StlError> {
    let text = std::str::from_utf8(bytes).map_err(|_| StlError::NotStl)?;
    if !begins_with(text.trim_start(), "solid") {
        return Err(StlError::NotStl);
    }
    let lines = text.lines().zip(1..).map(|(line, number)| (line.trim(), number));
    lines.filter(|(line, _)| begins_with(line, "vertex")).map(|(line, number)| text_corner(line, number)).collect()
}

/// Some programs write their words in capitals.
fn begins_with(line: &str, word: &str) -> bool {
    line.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

fn text_corner(line: &str, number: usize) -> Result<Vec3, StlError> {
    let fields = line.split_ascii_whitespace().skip(1).map(str::parse);
    match fields.collect::<Result<Vec<f64>, _>>().as_deref() {
        Ok(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err(StlError::Vertex { line: number, found: line.chars().take(60).collect() }),
    }
}
