//! Parsers of flags.

pub mod names;
pub mod of_schema;
pub mod values;
