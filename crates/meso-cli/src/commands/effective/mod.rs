//! `mesocrete effective`: effective diffusivity, conductivity and stiffness of a saved model or a label volume.

mod flags;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::run;
