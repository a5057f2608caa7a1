//! mesocrete: mesoscale concrete, packed without overlap.
//!
//! Units everywhere: mm, mm3, N, MPa, tonne, s, radians; volume fractions from 0 to 1, by volume of the specimen, from
//! the exact polyhedra.

// No environment, clock, file, print or mathematics of the platform: the list stands in this crate's `clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

pub mod aggregate;
pub mod check;
pub mod export;
pub mod formats;
pub mod geometry;
pub mod gjk;
pub mod import;
mod lanes;
pub mod materials;
pub mod math;
pub mod mesh;
pub mod model;
pub mod packing;
pub mod page;
mod prefetch;
pub mod recipes;
pub mod saved;
pub mod spec;
pub mod statistics;
pub mod stop;
mod wide;

pub use model::{Model, pack};
pub use packing::{Progress, Silent};
pub use spec::{Spec, SpecError};

// The README's Rust example is tested, too.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
