//! Packing: a [`Model`] of a [`Spec`], its proof and its statistics.
//!
//! The way through: [`spec`] holds every option, [`pack`] takes grains and places them, [`saved`] keeps the model,
//! [`check`](mod@check) proves it and [`statistics`](mod@statistics) measures it.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

mod accept;
pub mod check;
mod drilled;
pub mod labelled;
pub mod model;
pub mod recipes;
pub mod saved;
pub mod statistics;

/// The *place*: its options, and the report of a packing.
pub mod packing {
    pub use meso_place::{
        ClassReport, LabelReport, OwnPhaseReport, PhaseReport, Placement, ReducedGrain, Report, Seconds, ShellReport,
        SpecimenReport,
    };
    pub use meso_place::{StopReason, Strategy, Work};
}

/// Every option, as a SPEC.toml has it.
pub mod spec {
    pub use meso_spec::{
        Files, MixDesign, NoFiles, Spec, SpecError, line_of, nearest, options_from_toml, options_from_value,
    };
}

pub use accept::Fault;
pub use meso_spec::{Spec, SpecError};
pub use model::{Model, pack};
