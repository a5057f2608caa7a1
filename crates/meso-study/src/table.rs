//! The table of a study: one row a case, one column a quantity.

use crate::record::{Record, Status};
use crate::results::flatten;
use serde_json::{Map, Number, Value};
use std::collections::BTreeSet;
use std::io::{self, Write};

/// Columns of equal length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Columns from left to right.
    pub columns: Vec<Column>,
}

/// A quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Name, e.g. `fraction` or `solve.peak_mpa`.
    pub name: String,
    /// Values from top to bottom.
    pub values: Values,
}

/// Values of one type; `None` where a case has no value.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Truth values.
    Bool(Vec<Option<bool>>),
    /// Whole numbers of up to 64 bits, with or without a sign.
    Integer(Vec<Option<i128>>),
    /// Numbers.
    Float(Vec<Option<f64>>),
    /// Texts. Values of mixed types are JSON texts.
    Text(Vec<Option<String>>),
}

/// Names of columns that every table has, beside the axes.
const FIXED: [&str; 4] = ["case", "status", "warnings", "error"];

/// One row for each record: `case`, the axes' `keys`, `status`, the results by name, `warnings`, `error`. Results that are
/// tables become columns with dotted names; lists stay in the records.
pub fn tabulate(keys: &[String], records: &[Record]) -> Table {
    let flat: Vec<Map<String, Value>> = records.iter().map(|record| flatten(&record.results).collect()).collect();
    let mut names: Vec<&str> = flat.iter().flat_map(|row| row.keys().map(String::as_str)).collect();
    names.sort_unstable();
    names.dedup();
    let column = |name: String, value: &dyn Fn(usize) -> Option<Value>| Column {
        name,
        values: typed((0..records.len()).map(value).collect()),
    };
    let mut columns = vec![column("case".to_owned(), &|i| Some(records[i].case.as_str().into()))];
    columns.extend(keys.iter().map(|key| column(key.clone(), &|i| records[i].values.get(key).cloned())));
    let status = |i: usize| Some(Value::from(if records[i].status == Status::Done { "done" } else { "failed" }));
    columns.push(column("status".to_owned(), &status));
    let titles = titles(keys, &names);
    columns.extend(names.iter().zip(titles).map(|(name, title)| column(title, &|i| flat[i].get(*name).cloned())));
    let warnings = |i: usize| Some(records[i].warnings.join("; ")).filter(|text| !text.is_empty()).map(Value::from);
    columns.push(column("warnings".to_owned(), &warnings));
    columns.push(column("error".to_owned(), &|i| records[i].error.clone().map(Value::from)));
    Table { columns }
}

/// Column names of the results `names`, each unique: `result.` precedes a name that an axis or a fixed column has.
fn titles(keys: &[String], names: &[&str]) -> Vec<String> {
    let is_reserved = |name: &str| FIXED.contains(&name) || keys.iter().any(|key| key == name);
    let mut used: BTreeSet<String> =
        names.iter().filter(|name| !is_reserved(name)).map(|name| (*name).to_owned()).collect();
    let mut title = |name: &str| {
        let mut title = name.to_owned();
        if is_reserved(name) {
            while is_reserved(&title) || !used.insert(title.clone()) {
                title.insert_str(0, "result.");
            }
        }
        title
    };
    names.iter().map(|name| title(name)).collect()
}

/// The narrowest type that holds all values exactly.
fn typed(values: Vec<Option<Value>>) -> Values {
    let all = |is: fn(&Value) -> bool| values.iter().flatten().all(is) && values.iter().any(Option::is_some);
    fn each<T>(values: &[Option<Value>], of: impl Fn(&Value) -> Option<T>) -> Vec<Option<T>> {
        values.iter().map(|value| value.as_ref().and_then(&of)).collect()
    }
    if all(Value::is_boolean) {
        Values::Bool(each(&values, Value::as_bool))
    } else if all(|value| whole(value).is_some()) {
        Values::Integer(each(&values, whole))
    } else if all(|value| value.is_number() && is_exact(value)) {
        Values::Float(each(&values, Value::as_f64))
    } else {
        Values::Text(each(&values, |value| Some(value.as_str().map_or_else(|| value.to_string(), str::to_owned))))
    }
}

fn whole(value: &Value) -> Option<i128> {
    value.as_i64().map(i128::from).or_else(|| value.as_u64().map(i128::from))
}

/// Whether a number keeps its value as a float: whole numbers beyond 2^53 may not.
fn is_exact(value: &Value) -> bool {
    whole(value).is_none_or(|number| number as f64 as i128 == number)
}

impl Values {
    /// The text of a cell; empty where a case has no value.
    fn cell(&self, row: usize) -> String {
        match self {
            Self::Bool(values) => values[row].map(|value| value.to_string()),
            Self::Integer(values) => values[row].map(|value| value.to_string()),
            // The shortest decimal that reads back to the same number.
            Self::Float(values) => values[row].map(|value| format!("{value:?}")),
            Self::Text(values) => values[row].clone(),
        }
        .unwrap_or_default()
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Self::Bool(values) => values.len(),
            Self::Integer(values) => values.len(),
            Self::Float(values) => values.len(),
            Self::Text(values) => values.len(),
        }
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values as floats, or `None` for other types.
    pub(crate) fn numbers(&self) -> Option<Vec<Option<f64>>> {
        match self {
            Self::Integer(values) => Some(values.iter().map(|value| value.map(|n| n as f64)).collect()),
            Self::Float(values) => Some(values.clone()),
            Self::Bool(_) | Self::Text(_) => None,
        }
    }

    /// The value as JSON; null where a case has no value.
    pub fn json(&self, row: usize) -> Value {
        match self {
            Self::Bool(values) => values[row].into(),
            Self::Integer(values) => values[row].and_then(Number::from_i128).into(),
            Self::Float(values) => values[row].into(),
            Self::Text(values) => values[row].clone().into(),
        }
    }
}

impl Table {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The column with this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Writes the table as CSV (RFC 4180): a line of names, then one line for each row.
    ///
    /// # Errors
    /// Errors of `out`.
    pub fn write_csv(&self, mut out: impl Write) -> io::Result<()> {
        let names: Vec<String> = self.columns.iter().map(|column| quoted(&column.name)).collect();
        writeln!(out, "{}", names.join(","))?;
        for row in 0..self.rows() {
            let cells: Vec<String> = self.columns.iter().map(|column| quoted(&column.values.cell(row))).collect();
            writeln!(out, "{}", cells.join(","))?;
        }
        Ok(())
    }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
