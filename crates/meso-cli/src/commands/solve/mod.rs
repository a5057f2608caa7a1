//! `mesocrete solve`: the test itself, from a model, a spec or nothing to the stress-strain curve.

mod flags;
mod folder;
mod run;
mod watch;

pub(crate) use flags::Args;
pub(crate) use run::run;
