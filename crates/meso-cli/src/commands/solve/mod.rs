//! `mesocrete solve`: the test itself, from a model, a spec or nothing to the stress-strain curve.

mod flags;
mod folder;
mod run;
mod settings;
mod watch;

pub(crate) use flags::{Args, is_toml};
pub(crate) use run::run;
pub(crate) use settings::{deck_of_file, tables, take_tables};
