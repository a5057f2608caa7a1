//! The error of a value out of its range, for every table of options.

use std::fmt::Display;

/// A value outside its accepted range.
///
/// It reads `table.key is value; accepted`, as in `mesh.slabs is 0; it must be 1 to 100`.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{table}.{key} is {value}; {accepted}")]
pub struct OutOfRange {
    /// The table of options that holds the value: `mesh`, `deck`, `test` or `materials`.
    pub table: &'static str,
    /// The option's name within the table, dotted in a table within it: `interface.friction`.
    pub key: String,
    /// The value given.
    pub value: String,
    /// The accepted range, as a sentence that follows a semicolon.
    pub accepted: String,
}

impl OutOfRange {
    /// Continues a sentence that begins with the option's name: the value and the accepted range.
    pub fn fault(&self) -> String {
        format!("is {}; {}", self.value, self.accepted)
    }

    /// Moves the error into an outer table: `materials.mortar` becomes `materials.mortar` of `deck`.
    #[must_use]
    pub fn within(self, outer: &'static str) -> Self {
        Self { table: outer, key: format!("{}.{}", self.table, self.key), ..self }
    }
}

/// Checks the values of one table of options, which has this name.
#[derive(Clone, Copy, Debug)]
pub struct Ranges(pub &'static str);

impl Ranges {
    /// The error of a value whose range is known to be missed.
    pub fn error(self, key: impl Into<String>, value: impl Display, accepted: impl Into<String>) -> OutOfRange {
        OutOfRange { table: self.0, key: key.into(), value: written(value), accepted: accepted.into() }
    }

    /// Accepts a value whose condition is `met`. A condition compares the value with its bounds, so that NaN fails it.
    ///
    /// # Errors
    /// `met` is false.
    pub fn require(
        self,
        key: impl Into<String>,
        value: impl Display,
        met: bool,
        accepted: impl Into<String>,
    ) -> Result<(), OutOfRange> {
        if met { Ok(()) } else { Err(self.error(key, value, accepted)) }
    }

    /// Accepts positive finite numbers.
    ///
    /// # Errors
    /// Any other number, NaN included.
    pub fn positive(self, key: impl Into<String>, value: f64) -> Result<(), OutOfRange> {
        self.require(key, value, value > 0.0 && value.is_finite(), "it must be a positive number")
    }
}

/// A value as a person would write it: one of many digits has a power of ten.
pub fn written(value: impl Display) -> String {
    let text = value.to_string();
    match text.parse::<f64>() {
        Ok(number) if text.len() > 24 => format!("{number:e}"),
        _ => text,
    }
}

/// Whether `value` is beyond a limit that it must keep; NaN keeps none.
pub fn exceeds(value: f64, limit: f64) -> bool {
    let is_kept = value <= limit;
    !is_kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_in_an_inner_table_has_the_path_from_the_outer_one() {
        let error = Ranges("materials").positive("mortar.youngs_modulus_mpa", f64::NAN).unwrap_err();
        assert_eq!(error.to_string(), "materials.mortar.youngs_modulus_mpa is NaN; it must be a positive number");
        let huge = Ranges("mesh").positive("element_size_mm", -1e300).unwrap_err();
        assert_eq!(huge.to_string(), "mesh.element_size_mm is -1e300; it must be a positive number");
        let error = error.within("deck");
        assert_eq!(error.to_string(), "deck.materials.mortar.youngs_modulus_mpa is NaN; it must be a positive number");
        assert_eq!(error.fault(), "is NaN; it must be a positive number");
    }
}
