//! mesocrete: mesoscale concrete, packed without overlap.
//!
//! Units everywhere: mm, mm3, N, MPa, tonne, s, radians; volume fractions from 0 to 1, by volume of the specimen, from
//! the exact polyhedra.

// No environment, clock, file, print or mathematics of the platform: the list stands in this crate's `clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]
// Collision alone (no feature `concrete`) leaves some of geometry without a user.
#![cfg_attr(not(feature = "concrete"), allow(dead_code, unused_imports))]

#[cfg(feature = "concrete")]
pub mod aggregate;
#[cfg(feature = "concrete")]
pub mod check;
#[cfg(feature = "concrete")]
pub mod export;
#[cfg(feature = "concrete")]
pub mod formats;
pub mod geometry;
pub mod gjk;
#[cfg(feature = "concrete")]
pub mod import;
mod lanes;
#[cfg(feature = "concrete")]
pub mod materials;
pub mod math;
#[cfg(feature = "concrete")]
pub mod mesh;
#[cfg(feature = "concrete")]
pub mod model;
#[cfg(feature = "concrete")]
pub mod packing;
#[cfg(feature = "concrete")]
pub mod page;
#[cfg(feature = "concrete")]
mod prefetch;
#[cfg(feature = "concrete")]
pub mod recipes;
#[cfg(feature = "concrete")]
pub mod saved;
mod simd;
#[cfg(feature = "concrete")]
pub mod spec;
#[cfg(feature = "concrete")]
pub mod statistics;
#[cfg(feature = "concrete")]
pub mod stop;

/// What tests and benches force; results do not change with it.
#[doc(hidden)]
pub mod testing {
    pub use crate::simd::{Isa, choose, isa};
}

#[cfg(feature = "concrete")]
pub use model::{Model, pack};
#[cfg(feature = "concrete")]
pub use packing::{Progress, Silent};
#[cfg(feature = "concrete")]
pub use spec::{Spec, SpecError};

// The README's Rust example is tested, too.
#[cfg(all(doctest, feature = "concrete"))]
#[doc = include_str!("../../../README.md")]
struct Readme;
