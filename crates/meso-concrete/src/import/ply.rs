//! PLY, text or binary of either byte order: a header that names elements and their properties, then the numbers.
//!
//! Faces are polygons, or strips of triangles: each corner of a strip makes a triangle with the two before it, every other one
//! turned round, and -1 ends a strip.

use super::words::{is, lines, number, text, words};
use super::{Facets, ImportError};
use meso_collision::math::Vec3;

/// Type of a number.
#[derive(Clone, Copy)]
enum Kind {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

/// A property: a number, or a list whose length comes first.
struct PlyProperty {
    name: Vec<u8>,
    length: Option<Kind>,
    kind: Kind,
}

struct PlyElement {
    name: Vec<u8>,
    count: u64,
    properties: Vec<PlyProperty>,
}

/// Values behind the header.
enum Values<'a> {
    Text(Box<dyn Iterator<Item = &'a [u8]> + 'a>),
    Binary { rest: &'a [u8], is_big: bool },
}

pub(super) fn read(bytes: &[u8]) -> Result<Facets, ImportError> {
    let (elements, mut values) = header(text(bytes)?)?;
    let (mut facets, mut vertices) = (Facets::default(), Vec::new());
    let mut face_rows = Vec::new();
    for element in &elements {
        let (is_vertex, is_face) = (is(&element.name, "vertex"), is(&element.name, "face"));
        let is_strip = is(&element.name, "tristrips");
        let cut = || ImportError::Cut { part: if is_vertex { "vertices" } else { "faces" } };
        // Elements without properties take no bytes, whatever their number.
        let count = if element.properties.is_empty() { 0 } else { element.count };
        for _ in 0..count {
            if is_vertex {
                vertices.push(vertex(element, &mut values).ok_or_else(cut)?);
            } else {
                let corners = row(element, &mut values).ok_or_else(cut)?;
                if is_strip {
                    face_rows.extend(triangles(&corners));
                }
                face_rows.extend(is_face.then_some(corners));
            }
        }
    }
    let names = || elements.iter().map(|element| String::from_utf8_lossy(&element.name).into_owned());
    if face_rows.is_empty() && !names().any(|name| name == "face" || name == "tristrips") {
        let elements = names().collect::<Vec<_>>().join(", ");
        let wanted = format!("a surface has an element face or tristrips, and its elements are {elements}");
        return Err(ImportError::Begin { format: "a PLY", wanted });
    }
    face_rows.iter().enumerate().try_for_each(|(face, corners)| facets.polygon(&vertices, face, corners))?;
    Ok(facets)
}

/// The elements that the header describes, and the values behind it.
fn header(text: &[u8]) -> Result<(Vec<PlyElement>, Values<'_>), ImportError> {
    let wrong = |wanted: String| ImportError::Begin { format: "a PLY", wanted };
    let (mut elements, mut format): (Vec<PlyElement>, Option<&[u8]>) = (Vec::new(), None);
    for (number, line) in lines(text) {
        let words: Vec<&[u8]> = words(line).collect();
        let unclear = || {
            wrong(format!(
                "line {number} of its header, `{}`, is unclear",
                String::from_utf8_lossy(line).chars().take(60).collect::<String>()
            ))
        };
        match words.as_slice() {
            [b"ply"] if number == 1 => {}
            _ if number == 1 => return Err(wrong("it must begin with a line `ply`".to_owned())),
            [b"format", form, ..] => format = Some(*form),
            [b"element", name, count] => {
                let count = super::words::number(count).ok_or_else(unclear)?;
                elements.push(PlyElement { name: name.to_vec(), count, properties: Vec::new() });
            }
            [b"property", ..] => {
                let element = elements.last_mut().ok_or_else(unclear)?;
                element.properties.push(property(&words).ok_or_else(unclear)?);
            }
            [b"end_header"] => {
                return Ok((
                    elements,
                    values(behind(text, line), format).ok_or_else(|| {
                        wrong("its format is not ascii, binary_little_endian or binary_big_endian".to_owned())
                    })?,
                ));
            }
            [] | [b"comment" | b"obj_info", ..] => {}
            _ => return Err(unclear()),
        }
    }
    Err(wrong("its header has no end_header".to_owned()))
}

/// The bytes behind a line of `text` and the line's end.
fn behind<'a>(text: &'a [u8], line: &[u8]) -> &'a [u8] {
    let end = line.as_ptr() as usize - text.as_ptr() as usize + line.len();
    let rest = &text[end..];
    rest.strip_prefix(b"\r\n").or(rest.strip_prefix(b"\n")).or(rest.strip_prefix(b"\r")).unwrap_or(rest)
}

fn values<'a>(rest: &'a [u8], format: Option<&[u8]>) -> Option<Values<'a>> {
    match format? {
        b"ascii" => Some(Values::Text(Box::new(words(rest)))),
        b"binary_little_endian" => Some(Values::Binary { rest, is_big: false }),
        b"binary_big_endian" => Some(Values::Binary { rest, is_big: true }),
        _ => None,
    }
}

fn property(words: &[&[u8]]) -> Option<PlyProperty> {
    match words {
        [_, b"list", length, kind, name] => {
            Some(PlyProperty { name: name.to_vec(), length: Some(kind_of(length)?), kind: kind_of(kind)? })
        }
        [_, kind, name] => Some(PlyProperty { name: name.to_vec(), length: None, kind: kind_of(kind)? }),
        _ => None,
    }
}

fn kind_of(word: &[u8]) -> Option<Kind> {
    Some(match word {
        b"char" | b"int8" => Kind::Signed(1),
        b"short" | b"int16" => Kind::Signed(2),
        b"int" | b"int32" => Kind::Signed(4),
        b"uchar" | b"uint8" => Kind::Unsigned(1),
        b"ushort" | b"uint16" => Kind::Unsigned(2),
        b"uint" | b"uint32" => Kind::Unsigned(4),
        b"float" | b"float32" => Kind::Float(4),
        b"double" | b"float64" => Kind::Float(8),
        _ => return None,
    })
}

impl Values<'_> {
    /// The next number; every type fits in f64.
    fn next(&mut self, kind: Kind) -> Option<f64> {
        match self {
            Self::Text(words) => number(words.next()?),
            Self::Binary { rest, is_big } => {
                let (Kind::Signed(size) | Kind::Unsigned(size) | Kind::Float(size)) = kind;
                let (bytes, after) = rest.split_at_checked(size)?;
                *rest = after;
                let from_top = |bits: u64, &byte: &u8| bits << 8 | u64::from(byte);
                let bits = if *is_big { bytes.iter().fold(0, from_top) } else { bytes.iter().rev().fold(0, from_top) };
                let unused = 64 - 8 * size;
                Some(match kind {
                    Kind::Signed(_) => ((bits << unused) as i64 >> unused) as f64,
                    Kind::Unsigned(_) => bits as f64,
                    Kind::Float(4) => f64::from(f32::from_bits(bits as u32)),
                    Kind::Float(_) => f64::from_bits(bits),
                })
            }
        }
    }

    /// The numbers of a property.
    fn of(&mut self, property: &PlyProperty, mut each: impl FnMut(f64)) -> Option<()> {
        let length = property.length.map_or(Some(1.0), |kind| self.next(kind))?;
        // A length that is negative counts as 0. Each number takes a byte, so that a length too large ends the file.
        for _ in 0..length as u64 {
            each(self.next(property.kind)?);
        }
        Some(())
    }
}

fn vertex(element: &PlyElement, values: &mut Values<'_>) -> Option<Vec3> {
    let mut position = Vec3::from_element(f64::NAN);
    for property in &element.properties {
        let axis = ["x", "y", "z"].iter().position(|name| is(&property.name, name));
        values.of(property, |x| axis.into_iter().for_each(|axis| position[axis] = x))?;
    }
    Some(position)
}

/// The triangles of strips, without those that have a corner twice, which lead from one strip to the next.
fn triangles(corners: &[i64]) -> impl Iterator<Item = Vec<i64>> {
    let is_end = |corner: &i64| *corner < 0 || *corner == i64::from(u32::MAX);
    let strips = corners.split(is_end).flat_map(|strip| strip.windows(3).enumerate());
    let turned = strips.map(|(number, t)| if number % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] });
    turned.filter(|[a, b, c]| a != b && b != c && c != a).map(Vec::from)
}

/// The corners of a face; rows of other elements are read past.
fn row(element: &PlyElement, values: &mut Values<'_>) -> Option<Vec<i64>> {
    let mut corners = Vec::new();
    for property in &element.properties {
        let is_corners = is(&property.name, "vertex_indices") || is(&property.name, "vertex_index");
        // A number that is not whole names no vertex.
        let index = |x: f64| if x.fract() == 0.0 { x as i64 } else { -1 };
        values.of(property, |x| corners.extend(is_corners.then(|| index(x))))?;
    }
    Some(corners)
}
