//! Values with the line they stand on, from TOML text or from a JSON value.

use super::SpecError;
use serde_json::Value as Json;
use toml::de::{DeTable, DeValue};

/// A value and the line it begins on, where there are lines.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) line: Option<usize>,
}

/// JSON's and TOML's values in one; integers wide enough for both.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Null,
    Bool(bool),
    Integer(i128),
    Float(f64),
    Text(String),
    Array(Vec<Node>),
    Table(Vec<(String, Node)>),
}

impl SpecError {
    /// Adds the line of the key in `tree`, if the tree has it.
    pub(super) fn at(mut self, tree: &Node) -> Self {
        self.line = self.line.or_else(|| tree.line_of(&self.key));
        self
    }
}

impl Node {
    /// The line of the longest part of a dotted path that is there, without the root.
    fn line_of(&self, path: &str) -> Option<usize> {
        let mut node = self;
        let mut line = None;
        for name in path.split('.') {
            let Some(child) = node.child(name) else { break };
            (node, line) = (child, child.line);
        }
        line
    }

    /// The line of the value at a dotted path, whose parts may stand in one quoted key.
    pub(super) fn line_at(&self, path: &str) -> Option<usize> {
        let Value::Table(entries) = &self.value else { return None };
        entries.iter().find_map(|(name, child)| match path.strip_prefix(name.as_str())? {
            "" => child.line,
            rest => child.line_at(rest.strip_prefix('.')?),
        })
    }
}

impl Node {
    /// Values of no line of their own, one after the other.
    pub(super) fn list(values: impl Iterator<Item = Value>) -> Self {
        Self { value: Value::Array(values.map(|value| Self { value, line: None }).collect()), line: None }
    }

    /// The value of `key`, where this is a table that has it.
    pub(super) fn child(&self, key: &str) -> Option<&Self> {
        let Value::Table(entries) = &self.value else { return None };
        entries.iter().find(|(name, _)| name == key).map(|(_, child)| child)
    }

    /// Finds a child by its key, to change it.
    pub(super) fn child_mut(&mut self, key: &str) -> Option<&mut Self> {
        let Value::Table(entries) = &mut self.value else { return None };
        entries.iter_mut().find(|(name, _)| name == key).map(|(_, child)| child)
    }

    /// Takes `key` out of this table.
    pub(super) fn take(&mut self, key: &str) -> Option<(String, Self)> {
        let Value::Table(entries) = &mut self.value else { return None };
        let index = entries.iter().position(|(name, _)| name == key)?;
        Some(entries.remove(index))
    }
}

/// Reads TOML text, a leading byte order mark allowed.
pub(super) fn parse_toml(text: &str) -> Result<Node, SpecError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim_start().starts_with('{') {
        let message = "this is JSON, not TOML; a saved model needs no packing, and holds its spec under the key spec";
        return Err(SpecError { line: Some(1), ..SpecError::value("", message) });
    }
    let lines = Lines::of(text);
    let document = DeTable::parse(text).map_err(|error| lines.syntax_error(&error))?;
    let entries = lines.table(document.get_ref())?;
    Ok(Node { value: Value::Table(entries), line: Some(1) })
}

/// The text and the byte offsets at which its lines begin.
impl Node {
    /// Refuses a number that is nan or inf; `path` is the dotted one of this node.
    pub(super) fn finite(&self, path: &str) -> Result<(), SpecError> {
        match &self.value {
            Value::Float(x) if !x.is_finite() => {
                let wrong = SpecError::value(path, format!("is {}; it must be finite", x.to_string().to_lowercase()));
                Err(SpecError { line: self.line, ..wrong })
            }
            Value::Array(items) => items.iter().try_for_each(|item| item.finite(path)),
            Value::Table(entries) => entries.iter().try_for_each(|(key, node)| {
                let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                node.finite(&inner)
            }),
            _ => Ok(()),
        }
    }
}

struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    fn of(text: &'a str) -> Self {
        let breaks = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(i, _)| i + 1);
        Self { text, starts: std::iter::once(0).chain(breaks).collect() }
    }

    /// Line of a byte offset, from 1.
    fn number(&self, offset: usize) -> usize {
        self.starts.partition_point(|&start| start <= offset)
    }

    fn syntax_error(&self, error: &toml::de::Error) -> SpecError {
        let span = error.span().unwrap_or(0..0);
        let token = self.text.get(span.clone()).map(str::trim).filter(|t| !t.is_empty() && t.len() <= 40);
        let message = match token {
            Some(token) if error.message().contains("duplicate") => {
                let error = SpecError::value(token, "is given twice; keep one of the two");
                return SpecError { line: Some(self.number(span.start)), ..error };
            }
            Some(token) => format!("{} at {token:?}", error.message()),
            None => error.message().to_owned(),
        };
        let message = format!("this is not TOML: {message}");
        SpecError { line: Some(self.number(span.start)), ..SpecError::value("", message) }
    }

    fn table(&self, table: &DeTable<'_>) -> Result<Vec<(String, Node)>, SpecError> {
        table
            .iter()
            .map(|(key, value)| {
                let line = Some(self.number(key.span().start));
                Ok((key.get_ref().to_string(), Node { line, value: self.value(value.get_ref(), key.get_ref(), line)? }))
            })
            .collect()
    }

    fn value(&self, value: &DeValue<'_>, key: &str, line: Option<usize>) -> Result<Value, SpecError> {
        let wrong = |message: String| SpecError { line, is_wrong_type: true, ..SpecError::value(key, message) };
        Ok(match value {
            DeValue::String(text) => Value::Text(text.to_string()),
            DeValue::Boolean(flag) => Value::Bool(*flag),
            DeValue::Integer(n) => Value::Integer(
                i128::from_str_radix(n.as_str(), n.radix()).map_err(|_| wrong(format!("is {n}; that is too large")))?,
            ),
            DeValue::Float(x) => {
                Value::Float(x.as_str().parse().map_err(|_| wrong(format!("is {x}; it must be a number")))?)
            }
            DeValue::Datetime(date) => return Err(wrong(format!("is the date {date}; no option takes a date"))),
            DeValue::Table(table) => Value::Table(self.table(table)?),
            DeValue::Array(items) => Value::Array(
                items
                    .iter()
                    .map(|item| {
                        let line = Some(self.number(item.span().start));
                        Ok(Node { line, value: self.value(item.get_ref(), key, line)? })
                    })
                    .collect::<Result<_, _>>()?,
            ),
        })
    }
}

/// Makes a tree of a JSON value, without lines.
pub(super) fn from_json(json: &Json) -> Node {
    let value = match json {
        Json::Null => Value::Null,
        Json::Bool(flag) => Value::Bool(*flag),
        Json::Number(n) => match n.as_i128() {
            Some(n) => Value::Integer(n),
            None => Value::Float(n.as_f64().unwrap_or(f64::NAN)),
        },
        Json::String(text) => Value::Text(text.clone()),
        Json::Array(items) => Value::Array(items.iter().map(from_json).collect()),
        Json::Object(entries) => {
            Value::Table(entries.iter().map(|(key, value)| (key.clone(), from_json(value))).collect())
        }
    };
    Node { value, line: None }
}
