//! Wavefront OBJ: `v x y z`, and faces `f 1 2 3` or `f 1/2/3 ...`, counted from 1 or back from -1.

use super::words::{is, lines_of_words, number, position, text, unreadable};
use super::{Facets, ImportError};

/// A new object or group is a new part. Lines that end in a backslash go on in the next.
pub(super) fn read(bytes: &[u8]) -> Result<Facets, ImportError> {
    let (mut facets, mut vertices, mut faces) = (Facets::default(), Vec::new(), 0);
    let mut before: Vec<&[u8]> = Vec::new();
    for (line, words) in lines_of_words(text(bytes)?) {
        before.extend(words);
        if before.last() == Some(&&b"\\"[..]) {
            before.pop();
            continue;
        }
        let words = std::mem::take(&mut before);
        let Some((keyword, rest)) = words.split_first() else { continue };
        if is(keyword, "v") {
            vertices.push(position(rest).ok_or_else(|| unreadable(line, &words, "a vertex of three numbers"))?);
        } else if is(keyword, "f") {
            let corners = rest.iter().map(|word| corner(word, vertices.len())).collect::<Option<Vec<i64>>>();
            let corners = corners.ok_or_else(|| unreadable(line, &words, "a face of whole numbers, counted from 1"))?;
            facets.polygon(&vertices, faces, &corners)?;
            faces += 1;
        } else if is(keyword, "o") || is(keyword, "g") {
            facets.begin();
        }
    }
    Ok(facets)
}

/// The index, from 0, of a corner such as `3`, `3/1/2` or `-1`.
fn corner(word: &[u8], vertices: usize) -> Option<i64> {
    match number::<i32>(word.split(|&byte| byte == b'/').next()?)? {
        0 => None,
        index @ 1.. => Some(i64::from(index) - 1),
        index => Some(vertices as i64 + i64::from(index)),
    }
}
