//! Words of error messages: numbers, names and types as a reader writes them.

use serde::de::Unexpected;

/// A number as a person writes it: 25, 0.1, 5e-324, nan.
pub(super) fn number(value: f64) -> String {
    let plain = value == 0.0 || (1e-4..1e9).contains(&value.abs()) || !value.is_finite();
    if plain { format!("{value}").to_lowercase() } else { format!("{value:e}") }
}

/// A length that there is at most, mm: to a micrometre, and never more than it is.
pub(super) fn at_most(length: f64) -> String {
    let near = (length * 1e3).round() / 1e3;
    number(if near <= length { near } else { ((length * 1e3).floor()) / 1e3 })
}

/// An unexpected value; long texts are cut.
pub(super) fn found(value: &Unexpected<'_>) -> String {
    match value {
        Unexpected::Bool(flag) => flag.to_string(),
        Unexpected::Unsigned(n) => n.to_string(),
        Unexpected::Signed(n) => n.to_string(),
        // With its point: that may be all that is wrong.
        Unexpected::Float(x) => format!("{x:?}").to_lowercase(),
        Unexpected::Str(text) if text.chars().count() > 40 => {
            format!("{:?}...", text.chars().take(40).collect::<String>())
        }
        Unexpected::Str(text) => format!("{text:?}"),
        Unexpected::Unit | Unexpected::Option => "empty".to_owned(),
        Unexpected::Seq => "a list".to_owned(),
        Unexpected::Map => "a table".to_owned(),
        other => other.to_string(),
    }
}

/// A list described by its length.
pub(super) fn list_of(length: usize) -> String {
    format!("a list of length {length}")
}

/// The known name at most two slips, or a third of its letters, away.
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let plain = |s: &str| s.to_lowercase().replace(['-', ' '], "_");
    let name = plain(name);
    // A missing unit is the commonest slip: `side` for `side_mm`.
    let forgot_unit = |k: &&&str| plain(k).strip_prefix(&name).is_some_and(|rest| rest.starts_with('_'));
    if let Some(whole) = known.iter().filter(forgot_unit).min_by_key(|k| k.len()) {
        return Some(whole);
    }
    let (distance, best) = known.iter().map(|k| (edits(&name, &plain(k)), *k)).min()?;
    let length = best.chars().count();
    (distance < length && distance <= (length / 3).max(2)).then_some(best)
}

/// Insertions, deletions and replacements between two words (Levenshtein).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

/// The names in quotes, with commas.
pub(super) fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

/// serde's name of a type in a reader's words.
pub(super) fn plain_words(expected: &str) -> String {
    match expected {
        "f64" | "f32" => "a number".to_owned(),
        "u16" => format!("a whole number from 0 to {}", u16::MAX),
        "u32" => format!("a whole number from 0 to {}", u32::MAX),
        "u64" | "usize" => format!("a whole number from 0 to {}", u64::MAX),
        "a boolean" => "true or false".to_owned(),
        "a sequence" => "a list".to_owned(),
        _ if expected.starts_with("struct ") || expected.contains("tagged enum") => "a table".to_owned(),
        _ if expected.starts_with("variant ") => "a name in quotes".to_owned(),
        _ if expected.ends_with(" elements in sequence") => {
            format!("a list of length {}", expected.trim_end_matches(" elements in sequence"))
        }
        _ if expected.starts_with("enum ") => "a name".to_owned(),
        _ => expected.replace("an array of length", "a list of length"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_or_a_forgotten_unit_finds_its_key() {
        let known = ["d_min_mm", "d_max_mm", "curve", "classes_mm"];
        assert_eq!(nearest("dmin_mm", &known), Some("d_min_mm"));
        assert_eq!(nearest("d-max", &known), Some("d_max_mm"));
        assert_eq!(nearest("Curve", &known), Some("curve"));
        assert_eq!(nearest("colour", &known), None);
    }

    #[test]
    fn edits_are_counted_as_levenshtein_does() {
        assert_eq!(edits("kitten", "sitting"), 3);
        assert_eq!(edits("", "abc"), 3);
    }

    #[test]
    fn lengths_that_there_are_at_most_are_cut_to_a_micrometre() {
        assert_eq!(
            [15.0, 20.1, 33.3, 18.025073931097815, 7.7699999].map(at_most),
            ["15", "20.1", "33.3", "18.025", "7.769"]
        );
        assert_eq!([0.001, 1e6].map(at_most), ["0.001", "1000000"]);
    }

    #[test]
    fn numbers_are_short_at_any_size() {
        assert_eq!([0.1, 25.0, 5e-324, 1e308, f64::NAN].map(number), ["0.1", "25", "5e-324", "1e308", "nan"]);
    }
}
