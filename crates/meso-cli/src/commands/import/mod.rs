//! `mesocrete import`: a label volume becomes a saved model.

mod flags;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::run;
