//! STL, text or binary.
//!
//! Normals are ignored; the order of the corners defines the outside. A binary file may begin with "solid" as a text
//! does, so its length decides first.

use super::words::{is, lines, number, text, unreadable, words};
use super::{Facets, ImportError};
use meso_collision::math::Vec3;
use std::iter::Peekable;

/// Bytes before the first record: a header and the number of triangles.
const HEAD: usize = 84;
const RECORD: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Facets, ImportError> {
    let Some((head, records)) = bytes.split_at_checked(HEAD) else { return read_text(bytes) };
    let count = u32::from_le_bytes([80, 81, 82, 83].map(|byte| head[byte])) as usize;
    if count.checked_mul(RECORD) == Some(records.len()) {
        return Ok(binary(records, None));
    }
    let begins = text(bytes)?.trim_ascii_start();
    // Texts have no NUL; the number of triangles nearly always does.
    if begins_with_solid(begins) && !head.contains(&0) {
        return read_text(bytes);
    }
    let whole = count.saturating_mul(RECORD);
    if count > 0 && records.len() > whole && records.len() - whole < RECORD {
        let note = format!("{} byte(s) after its {count} triangles were ignored", records.len() - whole);
        return Ok(binary(&records[..whole], Some(note)));
    }
    // Programs that write as they go leave the number at 0.
    if count == 0 && records.len() % RECORD == 0 {
        let note = format!("it counts 0 triangles; its length says {}", records.len() / RECORD);
        return Ok(binary(records, Some(note)));
    }
    let wanted = format!(
        "it is no text that begins with `solid`, and as a binary file its count, at byte 80, is {count} triangles, which take \
         {} bytes; it has {}",
        HEAD.saturating_add(whole),
        bytes.len()
    );
    Err(ImportError::Begin { format: "an STL", wanted })
}

fn binary(records: &[u8], note: Option<String>) -> Facets {
    let corners = records.chunks_exact(RECORD).flat_map(corners_of).collect();
    Facets { corners, notes: note.into_iter().collect(), ..Facets::default() }
}

/// The corners of one record: a normal, three corners and two bytes of attributes.
fn corners_of(record: &[u8]) -> [Vec3; 3] {
    let number = |k: usize| f32::from_le_bytes([0, 1, 2, 3].map(|byte| record[4 * k + byte]));
    [1, 2, 3].map(|corner| Vec3::from_fn(|axis, _| f64::from(number(3 * corner + axis))))
}

fn begins_with_solid(text: &[u8]) -> bool {
    text.get(..5).is_some_and(|word| is(word, "solid"))
}

/// A text is read word by word, since some files are one line. A new `solid` is a new part.
fn read_text(bytes: &[u8]) -> Result<Facets, ImportError> {
    let text = text(bytes)?;
    if !begins_with_solid(text.trim_ascii_start()) {
        let wanted =
            "it is neither text that begins with `solid` nor a binary file of 84 + 50 n bytes, n the number at byte 80";
        return Err(ImportError::Begin { format: "an STL", wanted: wanted.to_owned() });
    }
    let mut facets = Facets::default();
    let mut all = lines(text).flat_map(|(line, text)| words(text).map(move |word| (line, word))).peekable();
    while let Some((line, word)) = all.next() {
        if is(word, "vertex") {
            facets.corners.push(vertex(&mut all, line)?);
        } else if is(word, "solid") || is(word, "endsolid") {
            facets.begin();
            skip_name(&mut all, line);
        }
    }
    Ok(facets)
}

/// Skips the name of a solid: the words of its line up to a keyword.
fn skip_name<'a>(words: &mut Peekable<impl Iterator<Item = (usize, &'a [u8])>>, line: usize) {
    let is_name = |&(at, word): &(usize, &[u8])| {
        at == line && !["facet", "solid", "endsolid"].iter().any(|keyword| is(word, keyword))
    };
    while words.next_if(is_name).is_some() {}
}

fn vertex<'a>(words: &mut Peekable<impl Iterator<Item = (usize, &'a [u8])>>, line: usize) -> Result<Vec3, ImportError> {
    let (mut found, mut position) = (vec![&b"vertex"[..]], Vec3::zeros());
    for axis in 0..3 {
        let word = words.next().map(|(_, word)| word);
        found.extend(word);
        let Some(x) = word.and_then(number) else { return Err(unreadable(line, &found, "a vertex of three numbers")) };
        position[axis] = x;
    }
    match words.peek() {
        Some((_, word)) if number::<f64>(word).is_some() => {
            found.push(word);
            Err(unreadable(line, &found, "a vertex of three numbers"))
        }
        _ => Ok(position),
    }
}
