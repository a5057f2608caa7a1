//! Requests: what a user can ask of mesocrete, each as one value.
//!
//! A request is a struct. Its doc comments, ranges and defaults are the only ones: the command reads it from flags, a study
//! from a section of its file, Python from keywords. `accept` finds what contradicts itself before anything is read, `settle`
//! what a specimen cannot have before any work is done. A refusal names the option by its key; the [`Giver`] turns the key
//! into the user's own spelling.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

mod axes;
mod deck;
mod effective;
mod error;
pub mod files;
mod fit;
pub mod flags;
pub mod footing;
mod given;
mod giver;
mod labels;
mod machine;
mod mesh;
mod mesh_figures;
mod options;
mod over;
mod solve;
mod strains;

pub use axes::Axes;
pub use deck::{DeckAsk, DeckSettled};
pub use effective::{
    EffectiveAsk, EffectiveTask, Facts, Filling, FramePick, Input, PhaseTables, PhasesGiven, Properties, RunRecord,
    Subject, What,
};
pub use error::AskError;
pub use fit::FitAsk;
pub use given::{Given, Options};
pub use giver::Giver;
pub use labels::labels_refusal;
pub use machine::{Machine, sizes};
pub use mesh::MeshAsk;
pub use mesh_figures::{MeshFigures, strict_doubt};
pub use options::{FRAMES, deck_refusal};
pub use over::Over;
pub use solve::{SolveAsk, TestGiven};
