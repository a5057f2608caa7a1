//! Lines and words of texts in any encoding that keeps ASCII: UTF-8, Latin-1, GBK.

use super::ImportError;

/// A text without its byte order mark.
pub(super) fn text(bytes: &[u8]) -> Result<&[u8], ImportError> {
    let is_wide = matches!(
        bytes,
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] | [0, 1..=255, 0, 1..=255, ..] | [1..=255, 0, 1..=255, 0, ..]
    );
    if is_wide { Err(ImportError::Utf16) } else { Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)) }
}

/// Lines with their numbers, from 1; they end in LF, CR or both.
pub(super) fn lines(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let whole = text.split(|&byte| byte == b'\n').map(|line| line.strip_suffix(b"\r").unwrap_or(line));
    (1..).zip(whole.flat_map(|line| line.split(|&byte| byte == b'\r')))
}

/// The words of a line.
pub(super) fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    // A vertical tab is a blank in C, which wrote many of these files.
    line.split(|&byte| byte.is_ascii_whitespace() || byte == 0x0b).filter(|word| !word.is_empty())
}

/// Lines that have words, with their words; `#` begins a comment.
pub(super) fn lines_of_words(text: &[u8]) -> impl Iterator<Item = (usize, Vec<&[u8]>)> {
    lines(text).filter_map(|(number, line)| {
        let meant = line.split(|&byte| byte == b'#').next()?;
        let words: Vec<&[u8]> = words(meant).collect();
        (!words.is_empty()).then_some((number, words))
    })
}

pub(super) fn is(word: &[u8], keyword: &str) -> bool {
    word.eq_ignore_ascii_case(keyword.as_bytes())
}

pub(super) fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// The first three words as a position.
pub(super) fn position(words: &[&[u8]]) -> Option<meso_collision::math::Vec3> {
    let [x, y, z, ..] = words else { return None };
    Some(meso_collision::math::Vec3::new(number(x)?, number(y)?, number(z)?))
}

/// The error of words that are not `wanted`.
pub(super) fn unreadable(line: usize, words: &[&[u8]], wanted: &'static str) -> ImportError {
    let found = String::from_utf8_lossy(&words.join(&b' ')).chars().take(60).collect();
    ImportError::Line { line, found, wanted }
}
