//! `mesocrete pack`: a spec becomes a packed specimen and its files.

mod flags;
mod plan;
mod run;
mod settings;

pub(crate) use flags::Args;
pub(crate) use run::run;
