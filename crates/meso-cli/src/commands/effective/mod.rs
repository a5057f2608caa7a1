//! `mesocrete effective`: effective properties of a saved model, a label volume or a frame of a test.

mod flags;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::run;
