#![doc = include_str!("../README.md")]
//!
//! Lengths are in any unit. The crate `meso-core` re-exports [`gjk`], [`geometry`] and [`math`]. Other items are
//! shared within the workspace; no promise covers them.

// No environment, clock, file, print or mathematics of the platform: the list stands in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

pub mod dents;
pub mod geometry;
pub mod gjk;
pub mod lanes;
pub mod math;
#[doc(hidden)]
pub mod posed;
#[doc(hidden)]
pub mod prefetch;
pub mod round_bodies;
#[doc(hidden)]
pub mod simd;
#[doc(hidden)]
pub mod stop;

#[cfg(test)]
mod random;
