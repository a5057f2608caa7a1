//! `mesocrete pack`: a spec becomes a packed specimen and its files.

mod flags;
mod plan;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::run;
