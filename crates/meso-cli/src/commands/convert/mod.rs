//! `mesocrete convert`: a saved model in another format.

mod flags;
mod run;
mod settings;

pub(crate) use flags::Args;
pub(crate) use run::run;
