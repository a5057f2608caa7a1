//! `mesocrete convert`: a saved model in another format.

mod flags;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::run;
