//! Tests of packings, specs, saved models and their proof, through the facade.

mod check;
pub(crate) mod folder;
mod hostile;
mod lies;
mod lies_of_labels;
pub(crate) mod models;
mod packing;
mod periodic;
mod properties;
mod saved;
mod spec;
mod statistics;
mod thin;
