//! Sieve tables from CSV files, put into the spec as if they had been written there.

use super::SpecError;
use super::files::{Files, read_text};
use super::tree::{Node, Value};

const KEY: &str = "grading.curve.file";

/// Replaces `file` in `grading.curve` by the sieves and shares it holds.
pub(super) fn inline(tree: &mut Node, files: &mut dyn Files) -> Result<(), SpecError> {
    let Some(curve) = tree.child_mut("grading").and_then(|grading| grading.child_mut("curve")) else { return Ok(()) };
    let Some((_, Node { value, line })) = curve.take("file") else { return Ok(()) };
    let fail = |is_wrong_type, message: String| SpecError { is_wrong_type, line, ..SpecError::value(KEY, message) };
    let Value::Text(name) = value else {
        return Err(fail(true, "must be the name of a CSV file in quotes".to_owned()));
    };
    let text = read_text(files, &name).map_err(|error| fail(false, format!("is {name:?}: {error}")))?;
    let rows = parse(&text).map_err(|reason| fail(false, format!("is {name:?}: {reason}")))?;
    let column = |pick: fn(&(f64, f64)) -> f64| Node {
        value: Value::Array(rows.iter().map(|row| Node { value: Value::Float(pick(row)), line }).collect()),
        line,
    };
    if let Value::Table(entries) = &mut curve.value {
        entries.push(("sieves_mm".to_owned(), column(|row| row.0)));
        entries.push(("passing".to_owned(), column(|row| row.1)));
    }
    Ok(())
}

/// Two columns under the heading `sieve_mm,passing` (shares from 0 to 1) or `sieve_mm,passing_percent`; in any order of
/// rows; lines that are empty or begin with # are passed over. Where the heading has a semicolon or a tab between its
/// names, so have the rows, and a decimal comma is a point: as spreadsheets write them in half of the world.
fn parse(text: &str) -> Result<Vec<(f64, f64)>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().zip(1..).map(|(line, number)| (line.trim(), number));
    let mut lines = lines.filter(|(line, _)| !line.is_empty() && !line.starts_with('#'));
    let heading = lines.next().map_or_else(String::new, |(line, _)| line.to_lowercase());
    let between = [';', '\t'].into_iter().find(|between| heading.contains(*between)).unwrap_or(',');
    let scale = match fields(&heading, between)[..] {
        ["sieve_mm", "passing"] => 1.0,
        ["sieve_mm", "passing_percent"] => 100.0,
        _ => {
            return Err(
                "its first line must be sieve_mm,passing (shares from 0 to 1) or sieve_mm,passing_percent".into()
            );
        }
    };
    let mut rows = lines.map(|(line, number)| row(line, number, between, scale)).collect::<Result<Vec<_>, _>>()?;
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(rows)
}

/// Splits a row at its separators, and removes quotes.
fn fields(line: &str, between: char) -> Vec<&str> {
    line.split(between).map(|field| field.trim().trim_matches('"').trim()).collect()
}

fn row(line: &str, number: usize, between: char, scale: f64) -> Result<(f64, f64), String> {
    let number_in = |field: &&str| match between {
        ',' => field.parse().ok(),
        _ => field.replace(',', ".").parse().ok(),
    };
    match fields(line, between).iter().map(number_in).collect::<Vec<Option<f64>>>()[..] {
        [Some(sieve), Some(share)] => Ok((sieve, share / scale)),
        _ => {
            Err(format!("line {number} is {line:?}; it must be two numbers, separated as the names in its first line"))
        }
    }
}
