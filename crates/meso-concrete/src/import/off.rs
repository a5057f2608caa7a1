//! OFF, the text of Geomview: numbers of vertices and faces, a line for each.
//!
//! `COFF`, `NOFF` and the like have colours or normals behind each position, which are ignored.

use super::words::{is, lines_of_words, number, position, text, unreadable};
use super::{Facets, ImportError};

pub(super) fn read(bytes: &[u8]) -> Result<Facets, ImportError> {
    let mut lines = lines_of_words(text(bytes)?).peekable();
    let begin = |wanted: &str| ImportError::Begin { format: "an OFF", wanted: wanted.to_owned() };
    let Some((line, mut counts)) = lines.next() else { return Err(begin("it is empty")) };
    let keyword = counts.remove(0).to_ascii_uppercase();
    if !["OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"].iter().any(|known| is(&keyword, known))
    {
        return Err(begin("it must begin with OFF, of three dimensions"));
    }
    if counts.first().is_some_and(|word| is(word, "binary")) {
        return Err(begin("it is binary; save it as text"));
    }
    let (line, counts) = if counts.is_empty() { lines.next().unwrap_or((line, counts)) } else { (line, counts) };
    let wanted = "the numbers of vertices and faces";
    let count = |k: usize| counts.get(k).and_then(|word| number::<usize>(word));
    let (Some(vertex_count), Some(face_count)) = (count(0), count(1)) else {
        return Err(unreadable(line, &counts, wanted));
    };
    let of_vertex = |(line, words): (usize, Vec<&[u8]>)| {
        position(&words).ok_or_else(|| unreadable(line, &words, "a vertex of three numbers"))
    };
    let vertices = lines.by_ref().take(vertex_count).map(of_vertex).collect::<Result<Vec<_>, _>>()?;
    if vertices.len() < vertex_count {
        return Err(ImportError::Cut { part: "vertices" });
    }
    let (mut facets, mut faces) = (Facets::default(), 0);
    for (line, words) in lines.take(face_count) {
        let corners =
            face(&words).ok_or_else(|| unreadable(line, &words, "a face: how many corners, and their numbers"))?;
        facets.polygon(&vertices, faces, &corners)?;
        faces += 1;
    }
    if faces < face_count { Err(ImportError::Cut { part: "faces" }) } else { Ok(facets) }
}

/// The corners of a face; a colour may follow them.
fn face(words: &[&[u8]]) -> Option<Vec<i64>> {
    let (count, rest) = words.split_first()?;
    let corners = rest.get(..number(count)?)?;
    corners.iter().map(|word| number::<u32>(word).map(i64::from)).collect()
}
