//! Parsers of flags.

pub mod names;
pub mod values;
