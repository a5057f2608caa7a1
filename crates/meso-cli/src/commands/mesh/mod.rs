//! `mesocrete mesh`: a saved model as finite elements.

mod flags;
mod report;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::{fill, how_to_run, print, run, target};
