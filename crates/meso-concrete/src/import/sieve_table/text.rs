//! Text to rows of cells: encodings, separators, quotes, comments.

/// A row of the file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    /// Line of the file, from 1.
    pub(super) line: usize,
    /// Cells without quotes and outer spaces.
    pub(super) cells: Vec<String>,
}

/// A table's file as text: UTF-8, UTF-16 with its mark, or Latin-1.
///
/// # Errors
/// A workbook, damaged UTF-16, and bytes that are no text.
pub fn decode(bytes: &[u8]) -> Result<String, String> {
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(&[0xd0, 0xcf, 0x11, 0xe0]) {
        return Err("it is a workbook; save its sheet as CSV, or read the .xlsx with Python".to_owned());
    }
    let wide = |order: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| order([pair[0], pair[1]])).collect();
        String::from_utf16(&units).map_err(|_| "it is damaged text in UTF-16; save it as UTF-8".to_owned())
    };
    let text = match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes)?,
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes)?,
        _ => match std::str::from_utf8(bytes) {
            Ok(text) => text.strip_prefix('\u{feff}').unwrap_or(text).to_owned(),
            Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
        },
    };
    if text.contains('\0') {
        return Err("it is not text; save the table as CSV".to_owned());
    }
    // Lines of old spreadsheets end in a carriage return alone.
    Ok(text.replace("\r\n", "\n").chars().map(plain).collect())
}

/// Digits and marks of Arabic, Persian and full-width text as ASCII; a carriage return as the end of a line.
fn plain(letter: char) -> char {
    let shifted = |first: char, to: char| char::from_u32(u32::from(letter) - u32::from(first) + u32::from(to));
    let found = match letter {
        '\r' => Some('\n'),
        '٠'..='٩' => shifted('٠', '0'),
        '۰'..='۹' => shifted('۰', '0'),
        '٫' => Some('.'),
        '\u{ff01}'..='\u{ff5e}' => shifted('\u{ff01}', '!'),
        _ => None,
    };
    found.unwrap_or(letter)
}

/// Separators of fields that stand in at least two lines, the most telling first; a space stands for any white space.
pub(super) fn separators(text: &str) -> Vec<char> {
    let lines = || text.lines().filter(|line| !line.trim().is_empty());
    let stands = |separator: char| lines().filter(|line| split(line, separator).len() > 1).count() >= 2;
    [';', '\t', '|', ',', ' '].into_iter().filter(|&separator| stands(separator)).collect()
}

/// The rows of a file under one separator; blank lines become rows without cells, comments go.
pub(super) fn rows(text: &str, separator: char) -> Vec<Row> {
    let numbered = text.lines().zip(1..);
    let kept = numbered.filter(|(line, _)| !is_comment(line, separator));
    kept.map(|(line, number)| Row { line: number, cells: cells(line, separator) }).collect()
}

/// What a spreadsheet writes into a cell that it cannot compute.
const NO_VALUE: [&str; 7] = ["#n/a", "#div/0!", "#ref!", "#value!", "#name?", "#num!", "#null!"];

/// A line that begins with `#` is a comment, but for a sieve number with a value behind it, and a spreadsheet's error.
fn is_comment(line: &str, separator: char) -> bool {
    let line = line.trim_start();
    if line.starts_with("//") {
        return true;
    }
    let Some(rest) = line.strip_prefix('#') else { return false };
    let first = split(rest, separator).first().map(|cell| cell.trim().to_owned()).unwrap_or_default();
    let is_error = NO_VALUE.iter().any(|error| first.to_lowercase() == error[1..]);
    !is_error && !first.chars().next().is_some_and(|c| c.is_ascii_digit())
}

fn cells(line: &str, separator: char) -> Vec<String> {
    let line = line.find(" # ").map_or(line, |at| &line[..at]);
    let line = if separator == '|' { line.trim().trim_matches('|') } else { line };
    let mut cells: Vec<String> = split(line, separator).iter().map(|cell| cell.trim().to_owned()).collect();
    // A rule under the headings of a text table.
    if cells.iter().all(|cell| cell.chars().all(|c| matches!(c, '-' | '=' | ':' | '+' | ' '))) {
        cells.clear();
    }
    while cells.last().is_some_and(String::is_empty) {
        cells.pop();
    }
    cells
}

/// Fields of a line; a separator in quotes separates nothing, a doubled quote is one.
fn split(line: &str, separator: char) -> Vec<String> {
    if separator == ' ' {
        let wide = line.trim().split("  ").map(str::trim).filter(|cell| !cell.is_empty()).count() > 1;
        let split: Vec<&str> = if wide { line.split("  ").collect() } else { line.split_whitespace().collect() };
        return split.iter().map(|cell| cell.trim()).filter(|cell| !cell.is_empty()).map(str::to_owned).collect();
    }
    let (mut fields, mut quoted) = (vec![String::new()], false);
    let mut letters = line.chars().peekable();
    while let Some(letter) = letters.next() {
        let begins = fields.last().is_some_and(|field| field.trim().is_empty());
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                letters.next();
                fields.last_mut().expect("a field").push('"');
            }
            '"' if quoted => quoted = false,
            '"' if begins => quoted = true,
            letter if letter == separator && !quoted => fields.push(String::new()),
            letter => fields.last_mut().expect("a field").push(letter),
        }
    }
    fields
}
