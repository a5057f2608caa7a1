//! `mesocrete image`: voxel images and sections of a saved model, .npy, .tif, .vti, .png, .svg.

mod flags;
mod run;

pub(crate) use flags::Args;
pub(crate) use run::run;
