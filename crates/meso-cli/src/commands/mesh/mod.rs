//! `mesocrete mesh`: a saved model as finite elements.

mod flags;
mod report;
mod run;
mod settings;

pub(crate) use flags::Args;
pub(crate) use run::{fill, how_to_run, print, run};
pub(crate) use settings::target;
