//! An invalid spec: the fault, its place, and the remedy.

/// A spec that cannot be; displayed as `line 4: grading.d_min_mm is 25, ...`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{key}{}{message}", line.map(|n| format!("line {n}: ")).unwrap_or_default(), if key.is_empty() { "" } else { " " })]
pub struct SpecError {
    /// Dotted path of the key, e.g. `grading.d_min_mm`; empty for a syntax error.
    pub key: String,
    /// Continues the sentence that the key begins: the value, its fault, the accepted range.
    pub message: String,
    /// Where in the SPEC.toml, from 1.
    pub line: Option<usize>,
    /// Whether the value has the wrong type: a text where a number belongs, and the like.
    pub is_wrong_type: bool,
    /// Whether the time limit came before all was proved; the spec may be right.
    pub is_late: bool,
}

impl SpecError {
    /// A value that cannot be; `message` continues the sentence that `key` begins.
    pub fn value(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into(), line: None, is_wrong_type: false, is_late: false }
    }

    /// The error of a key within a table.
    #[must_use]
    pub(crate) fn within(self, table: &str) -> Self {
        Self { key: format!("{table}.{}", self.key), ..self }
    }

    /// Names the option of a time limit that was `given` beside the spec, and drops the line. Other errors pass
    /// unchanged.
    #[must_use]
    pub fn of_limit(self, given: Option<f64>, name: &str) -> Self {
        match (self.is_late, given) {
            (true, Some(_)) => Self { key: name.to_owned(), line: None, ..self },
            _ => self,
        }
    }
}
