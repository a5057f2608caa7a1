//! The table of a study: one row a case, one column a quantity.

use crate::record::{Record, Status};
use serde_json::{Map, Value};
use std::io::{self, Write};

/// Columns of the same length.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// From the left.
    pub columns: Vec<Column>,
}

/// A quantity.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// E.g. `fraction`, `solve.peak_mpa`.
    pub name: String,
    /// From the top.
    pub values: Values,
}

/// Values of one type; none where a case has no such value.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Yes and no.
    Bool(Vec<Option<bool>>),
    /// Whole numbers.
    Integer(Vec<Option<i64>>),
    /// Numbers.
    Float(Vec<Option<f64>>),
    /// Texts; also what is of no single type, as JSON.
    Text(Vec<Option<String>>),
}

/// One row for each record: `case`, the axes' `keys`, `status`, the results by name, `error`. Results that are tables become
/// columns with dotted names; lists stay in the records alone.
pub fn tabulate(keys: &[String], records: &[Record]) -> Table {
    let flat: Vec<Map<String, Value>> = records.iter().map(flatten).collect();
    let mut names: Vec<&str> = flat.iter().flat_map(|row| row.keys().map(String::as_str)).collect();
    names.sort_unstable();
    names.dedup();
    // A result that has the name of an axis, like the fraction reached, is told apart.
    let shown = |name: &str| if is_taken(keys, name) { format!("result.{name}") } else { name.to_owned() };
    let column = |name: String, value: &dyn Fn(usize) -> Option<Value>| Column {
        name,
        values: typed((0..records.len()).map(value).collect()),
    };
    let mut columns = vec![column("case".to_owned(), &|i| Some(records[i].case.as_str().into()))];
    columns.extend(keys.iter().map(|key| column(key.clone(), &|i| records[i].values.get(key).cloned())));
    let status = |i: usize| Some(Value::from(if records[i].status == Status::Done { "done" } else { "failed" }));
    columns.push(column("status".to_owned(), &status));
    columns.extend(names.iter().map(|name| column(shown(name), &|i| flat[i].get(*name).cloned())));
    columns.push(column("error".to_owned(), &|i| records[i].error.clone().map(Value::from)));
    Table { columns }
}

fn is_taken(keys: &[String], name: &str) -> bool {
    ["case", "status", "error"].contains(&name) || keys.iter().any(|key| key == name)
}

/// The scalar results by dotted names.
fn flatten(record: &Record) -> Map<String, Value> {
    let mut flat = Map::new();
    for (name, value) in &record.results {
        flatten_into(&mut flat, name.clone(), value);
    }
    flat
}

fn flatten_into(flat: &mut Map<String, Value>, name: String, value: &Value) {
    match value {
        Value::Object(map) => map.iter().for_each(|(key, inner)| flatten_into(flat, format!("{name}.{key}"), inner)),
        Value::Array(_) | Value::Null => {}
        scalar => {
            flat.insert(name, scalar.clone());
        }
    }
}

/// The narrowest type that holds all values.
fn typed(values: Vec<Option<Value>>) -> Values {
    let all = |is: fn(&Value) -> bool| values.iter().flatten().all(is) && values.iter().any(Option::is_some);
    fn each<T>(values: &[Option<Value>], of: impl Fn(&Value) -> Option<T>) -> Vec<Option<T>> {
        values.iter().map(|value| value.as_ref().and_then(&of)).collect()
    }
    if all(Value::is_boolean) {
        Values::Bool(each(&values, Value::as_bool))
    } else if all(Value::is_i64) {
        Values::Integer(each(&values, Value::as_i64))
    } else if all(Value::is_number) {
        Values::Float(each(&values, Value::as_f64))
    } else {
        Values::Text(each(&values, |value| Some(value.as_str().map_or_else(|| value.to_string(), str::to_owned))))
    }
}

impl Values {
    /// The text of a cell; empty for none.
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

    /// Numbers, where these are numbers.
    pub(crate) fn numbers(&self) -> Option<Vec<Option<f64>>> {
        match self {
            Self::Integer(values) => Some(values.iter().map(|value| value.map(|n| n as f64)).collect()),
            Self::Float(values) => Some(values.clone()),
            Self::Bool(_) | Self::Text(_) => None,
        }
    }

    /// The value as JSON; null for none.
    pub fn json(&self, row: usize) -> Value {
        match self {
            Self::Bool(values) => values[row].into(),
            Self::Integer(values) => values[row].into(),
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

    /// The column of this name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Writes the table as CSV (RFC 4180): a line of names, then one line for each row.
    ///
    /// # Errors
    /// Those of `out`.
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
