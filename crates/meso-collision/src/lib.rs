#![doc = include_str!("../README.md")]
//!
//! Lengths are in any unit. The crate `meso-core` re-exports [`gjk`], [`geometry`] and [`math`]. What is hidden here is
//! shared with it alone; no promise covers that.

// No environment, clock, file, print or mathematics of the platform: the list stands in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

pub mod geometry;
pub mod gjk;
#[doc(hidden)]
pub mod lanes;
pub mod math;
#[doc(hidden)]
pub mod prefetch;
#[doc(hidden)]
pub mod simd;

#[cfg(test)]
mod random;
