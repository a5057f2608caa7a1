//! `mesocrete import`: a label volume becomes a saved model.

mod flags;
mod run;
mod settings;

pub(crate) use flags::Args;
pub(crate) use run::run;
