//! `mesocrete fit`: the mortar with which a specimen's curve meets a measured one.

mod flags;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::run;
