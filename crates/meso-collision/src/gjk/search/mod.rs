//! Searches that propose an answer, in f32 or f64.

pub(crate) mod classical;
pub(crate) mod enhanced;
pub(crate) mod kernel;
pub(crate) mod mpr;
pub(crate) mod nearest;
pub(crate) mod simplex;
