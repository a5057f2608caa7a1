//! OFF, the text of Geomview: numbers of vertices and faces, a line for each.
//!
//! `COFF`, `NOFF`, `NCOFF` and the like have colours or normals behind each position, which are ignored; `4OFF` has a fourth
//! coordinate that divides the others. The first number may follow the keyword at once. Numbers need no lines of their own
//! where a vertex has its position alone.

use super::words::{is, lines_of_words, number, text, unreadable};
use super::{Facets, ImportError};
use meso_collision::math::Vec3;

/// A line that has words, and its number.
type Line<'a> = (usize, Vec<&'a [u8]>);

/// What the lines behind the numbers hold.
struct Counts {
    vertices: usize,
    faces: usize,
    /// Numbers of a position: 3, or 4 of which the last divides the others.
    size: usize,
}

pub(super) fn read(bytes: &[u8]) -> Result<Facets, ImportError> {
    let mut lines = lines_of_words(text(bytes)?).peekable();
    let begin = |wanted: &str| ImportError::Begin { format: "an OFF", wanted: wanted.to_owned() };
    let Some((line, mut words)) = lines.next() else { return Err(begin("it is empty")) };
    let (keyword, digits) =
        words[0].split_at(words[0].iter().rposition(u8::is_ascii_alphabetic).map_or(0, |at| at + 1));
    match digits {
        [] => drop(words.remove(0)),
        _ => words[0] = digits,
    }
    if keyword == b"nOFF" || keyword.ends_with(b"nOFF") {
        return Err(begin("it is an nOFF, of any number of dimensions; save it as OFF, of three"));
    }
    let Some((size, has_more)) = vertex(keyword) else {
        return Err(begin("it must begin with OFF, of three dimensions"));
    };
    if words.first().is_some_and(|word| is(word, "binary")) {
        return Err(begin("it is binary; save it as text"));
    }
    let (line, words) = match words.is_empty() {
        true => lines.next().ok_or(ImportError::Cut { part: "head" })?,
        false => (line, words),
    };
    let count = |k: usize| words.get(k).and_then(|word| number::<usize>(word));
    let (Some(vertices), Some(faces)) = (count(0), count(1)) else {
        return Err(unreadable(line, &words, "the numbers of vertices and faces"));
    };
    let counts = Counts { vertices, faces, size };
    let mut lines: Vec<Line> = lines.collect();
    let found = by_lines(&counts, &lines);
    if found.is_ok() || has_more {
        return found;
    }
    // The number of edges, which counts for nothing, may be absent.
    let more = words.get(3..).filter(|more| !more.is_empty());
    more.into_iter().for_each(|more| lines.insert(0, (line, more.to_vec())));
    by_numbers(&counts, &lines).ok_or(()).or(found)
}

/// Numbers of a position by the keyword, and whether more stands behind it. Programs write the marks in any order.
pub(super) fn vertex(keyword: &[u8]) -> Option<(usize, bool)> {
    let (marks, name) = keyword.split_at(keyword.len().checked_sub(3)?);
    let (marks, mut size, mut has_more) = (marks.to_ascii_uppercase(), 3, false);
    let mut marks = &marks[..];
    while let [mark, rest @ ..] = marks {
        marks = match mark {
            b'4' | b'C' | b'N' => rest,
            b'S' => rest.strip_prefix(b"T")?,
            _ => return None,
        };
        size += usize::from(*mark == b'4');
        has_more |= *mark != b'4';
    }
    (is(name, "OFF") && size <= 4).then_some((size, has_more))
}

/// A vertex a line, a face a line.
fn by_lines(counts: &Counts, lines: &[Line]) -> Result<Facets, ImportError> {
    let of_vertex = |(line, words): &Line| {
        position(counts.size, words).ok_or_else(|| unreadable(*line, words, "a vertex of three numbers"))
    };
    let vertices = lines.iter().take(counts.vertices).map(of_vertex).collect::<Result<Vec<_>, _>>()?;
    if vertices.len() < counts.vertices {
        return Err(ImportError::Cut { part: "vertices" });
    }
    faces_by_lines(counts, &vertices, &lines[counts.vertices..])
}

fn faces_by_lines(counts: &Counts, vertices: &[Vec3], lines: &[Line]) -> Result<Facets, ImportError> {
    let (mut facets, mut faces) = (Facets::default(), 0);
    for (line, words) in lines.iter().take(counts.faces) {
        let corners =
            face(words).ok_or_else(|| unreadable(*line, words, "a face: how many corners, and their numbers"))?;
        facets.polygon(vertices, faces, &corners)?;
        faces += 1;
    }
    if faces < counts.faces { Err(ImportError::Cut { part: "faces" }) } else { Ok(facets) }
}

/// One number behind the other, whatever their lines; faces with colours have a line each. `None` where numbers are missing or
/// left over.
fn by_numbers(counts: &Counts, lines: &[Line]) -> Option<Facets> {
    let ends = lines.iter().scan(0, |end, (_, words)| {
        *end += words.len();
        Some(*end)
    });
    let ends: Vec<usize> = ends.collect();
    let words: Vec<&[u8]> = lines.iter().flat_map(|(_, words)| words.iter().copied()).collect();
    let behind = counts.vertices.checked_mul(counts.size).filter(|behind| *behind <= words.len())?;
    let of_vertex = |words: &[&[u8]]| position(counts.size, words);
    let vertices: Vec<Vec3> = words[..behind].chunks_exact(counts.size).map(of_vertex).collect::<Option<_>>()?;
    let rest = ends.partition_point(|end| *end <= behind);
    let begins_a_line = behind == 0 || ends.binary_search(&behind).is_ok();
    if begins_a_line && let Ok(facets) = faces_by_lines(counts, &vertices, &lines[rest..]) {
        return Some(facets);
    }
    let (mut facets, mut left) = (Facets::default(), &words[behind..]);
    for number in 0..counts.faces {
        let corners = face(left)?;
        left = &left[corners.len() + 1..];
        facets.polygon(&vertices, number, &corners).ok()?;
    }
    left.is_empty().then_some(facets)
}

/// The position of a vertex with so many coordinates.
fn position(size: usize, words: &[&[u8]]) -> Option<Vec3> {
    let numbers = words.get(..size)?.iter().map(|word| number::<f64>(word)).collect::<Option<Vec<f64>>>()?;
    let over = numbers.get(3).copied().unwrap_or(1.0);
    (over != 0.0).then(|| Vec3::new(numbers[0], numbers[1], numbers[2]) / over)
}

/// The corners of a face; a colour may follow them.
fn face(words: &[&[u8]]) -> Option<Vec<i64>> {
    let (count, rest) = words.split_first()?;
    let corners = rest.get(..number(count)?)?;
    corners.iter().map(|word| number::<u32>(word).map(i64::from)).collect()
}
