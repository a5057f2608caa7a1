//! Sieve tables in per cent and from files, put into the spec as if their shares had been written there.

use super::SpecError;
use super::files::Files;
use super::messages::{found, number};
use super::tree::{Node, Value};
use meso_concrete::aggregate::{Grading, SizeDefinition};
use meso_concrete::import::sieve_table::{self, Choices, Meaning, SieveTable, SieveUnit, TableColumn, ValueUnit};

const KEY: &str = "grading.curve.file";
/// Keys that count beside `file` only.
const CHOICES: [&str; 6] = ["column", "blend", "means", "unit", "sieve_unit", "sheet"];

/// A table that was read, for a remark once the grading's limits are known.
pub(super) struct Remark {
    name: String,
    understood: String,
}

/// Replaces `file` in the curve of a `grading` by the sieves and shares of that table, and `passing_percent` by shares.
pub(super) fn inline(grading: &mut Node, files: &mut dyn Files) -> Result<Option<Remark>, SpecError> {
    let Some(curve) = grading.child_mut("curve") else { return Ok(None) };
    shares_of_percent(curve)?;
    let chosen: Vec<(&str, Node)> = CHOICES.iter().filter_map(|key| Some((*key, curve.take(key)?.1))).collect();
    let Some((_, Node { value, line })) = curve.take("file") else {
        return chosen
            .first()
            .map_or(Ok(None), |(key, node)| Err(fail(key, node, "counts only beside file; leave it out")));
    };
    let at = |is_wrong_type, message: String| SpecError { is_wrong_type, line, ..SpecError::value(KEY, message) };
    let Value::Text(name) = value else {
        return Err(at(true, "must be the name of a CSV file in quotes".to_owned()));
    };
    let choices = choices(&chosen)?;
    let sheet = chosen.iter().find(|(key, _)| *key == "sheet").map(|(_, node)| node);
    let table = table(files, &name, sheet, &choices).map_err(|reason| at(false, format!("is {name:?}: {reason}")))?;
    let column = |values: &[f64]| Node {
        value: Value::Array(values.iter().map(|&value| Node { value: Value::Float(value), line }).collect()),
        line,
    };
    if let Value::Table(entries) = &mut curve.value {
        entries.push(("sieves_mm".to_owned(), column(&table.sieves_mm)));
        entries.push(("passing".to_owned(), column(&table.passing)));
    }
    Ok(Some(Remark { name, understood: table.understood }))
}

fn table(files: &mut dyn Files, name: &str, sheet: Option<&Node>, choices: &Choices) -> Result<SieveTable, String> {
    let sheet = match sheet.map(|node| &node.value) {
        None => None,
        Some(Value::Text(sheet)) => Some(sheet.as_str()),
        Some(_) => return Err("sheet must be the name of a sheet in quotes".to_owned()),
    };
    let bytes = files.read_table(name, sheet).map_err(|error| error.to_string())?;
    sieve_table::read(&bytes, choices)
}

impl Remark {
    /// Says how the table was read, and which share of its curve the grading models.
    pub(super) fn say(&self, grading: &Grading, files: &mut dyn Files) {
        let percent = |share: f64| number((1000.0 * share).round() / 10.0);
        let [fine, coarse] = [grading.d_min_mm, grading.d_max_mm].map(|d| grading.curve.passing(d, grading.d_max_mm));
        let size = match grading.size {
            SizeDefinition::Sieve => "",
            SizeDefinition::LongestAxis => "; grading.size takes its openings as longest axes",
        };
        let remark = format!(
            "{}; {} to {} mm is {} % of the curve, {} % is coarser and {} % finer{size}",
            self.understood,
            number(grading.d_min_mm),
            number(grading.d_max_mm),
            percent(coarse - fine),
            percent(1.0 - coarse),
            percent(fine)
        );
        files.remark(&self.name, &remark);
    }
}

fn fail(key: &str, node: &Node, message: impl Into<String>) -> SpecError {
    SpecError { line: node.line, ..SpecError::value(format!("grading.curve.{key}"), message.into()) }
}

fn wrong(key: &str, node: &Node, wanted: &str) -> SpecError {
    SpecError {
        is_wrong_type: true,
        ..fail(key, node, format!("is {}; it must be {wanted}", found(&node.unexpected())))
    }
}

/// Turns `passing_percent` into `passing`; values that can only be shares are an error.
fn shares_of_percent(curve: &mut Node) -> Result<(), SpecError> {
    const KEY: &str = "passing_percent";
    let Some((_, node)) = curve.take(KEY) else { return Ok(()) };
    if curve.child("passing").is_some() {
        return Err(fail(KEY, &node, "stands beside passing; keep one of the two"));
    }
    let Value::Array(items) = &node.value else { return Err(wrong(KEY, &node, "a list of numbers")) };
    let values = items
        .iter()
        .map(|item| real(item).ok_or_else(|| wrong(KEY, item, "a number")))
        .collect::<Result<Vec<_>, _>>()?;
    let most = values.iter().copied().fold(0.0, f64::max);
    if most > 0.0 && most <= 1.0 {
        return Err(fail(
            KEY,
            &node,
            format!("has nothing above {}; these are shares: call them passing", number(most)),
        ));
    }
    if let Some(beyond) = values.iter().find(|value| !(0.0..=100.0).contains(*value)) {
        return Err(fail(KEY, &node, format!("has {}; per cent are from 0 to 100", number(*beyond))));
    }
    let shares =
        values.iter().zip(items).map(|(value, item)| Node { value: Value::Float(value / 100.0), line: item.line });
    let shares = Node { value: Value::Array(shares.collect()), line: node.line };
    if let Value::Table(entries) = &mut curve.value {
        entries.push(("passing".to_owned(), shares));
    }
    Ok(())
}

fn real(node: &Node) -> Option<f64> {
    match node.value {
        Value::Float(value) => Some(value),
        Value::Integer(value) => Some(value as f64),
        _ => None,
    }
}

/// What the spec says about the columns of its table.
fn choices(chosen: &[(&str, Node)]) -> Result<Choices, SpecError> {
    let mut choices = Choices::default();
    for (key, node) in chosen {
        match *key {
            "means" => choices.means = Some(name(key, node, &Meaning::NAMES)?),
            "unit" => choices.unit = Some(name(key, node, &ValueUnit::NAMES)?),
            "sieve_unit" => choices.sieve_unit = Some(name(key, node, &SieveUnit::NAMES)?),
            "column" => choices.columns.push((column(key, node)?, 1.0)),
            "blend" if !choices.columns.is_empty() => {
                return Err(fail(key, node, "stands beside column; keep one of the two"));
            }
            "blend" => choices.columns = blend(node)?,
            _ => {}
        }
    }
    Ok(choices)
}

fn name<T: Copy>(key: &str, node: &Node, names: &[(&str, T)]) -> Result<T, SpecError> {
    let text = if let Value::Text(text) = &node.value { text.as_str() } else { "" };
    let known = names.iter().find(|(name, _)| *name == text).map(|(_, value)| *value);
    let list: Vec<String> = names.iter().map(|(name, _)| format!("{name:?}")).collect();
    known.ok_or_else(|| wrong(key, node, &format!("one of {}", list.join(", "))))
}

fn column(key: &str, node: &Node) -> Result<TableColumn, SpecError> {
    match &node.value {
        Value::Text(heading) => Ok(TableColumn::Heading(heading.clone())),
        Value::Integer(position) if (1..1000).contains(position) => Ok(TableColumn::Position(*position as usize)),
        _ => Err(wrong(key, node, "a heading in quotes, or the position of a column from 1")),
    }
}

/// Columns and their shares, which sum to 1 or to 100.
fn blend(node: &Node) -> Result<Vec<(TableColumn, f64)>, SpecError> {
    const KEY: &str = "blend";
    let Value::Table(entries) = &node.value else {
        return Err(wrong(KEY, node, "a table of headings and shares, { \"Sand\" = 0.4, \"Gravel\" = 0.6 }"));
    };
    let share = |(heading, node): &(String, Node)| {
        let share = real(node).filter(|share| *share >= 0.0 && share.is_finite());
        let column = TableColumn::Heading(heading.clone());
        share.map(|share| (column, share)).ok_or_else(|| wrong(KEY, node, "a share of at least 0"))
    };
    let columns = entries.iter().map(share).collect::<Result<Vec<_>, _>>()?;
    let whole: f64 = columns.iter().map(|column| column.1).sum();
    if [1.0, 100.0].iter().any(|all| (whole / all - 1.0).abs() < 1e-6) {
        return Ok(columns);
    }
    Err(fail(KEY, node, format!("sums to {}; shares sum to 1, or per cent to 100", number(whole))))
}
