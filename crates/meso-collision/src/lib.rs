//! Exact collision of convex bodies, and the geometry it stands on; what mesocrete packs and meshes with.
//!
//! ```
//! use meso_collision::{gjk, math::Vec3};
//!
//! let tetrahedron = |x: f64| [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [0., 0., 1.]].map(|p| Vec3::new(x + p[0], p[1], p[2]));
//! assert!(gjk::intersects(&tetrahedron(0.0), &tetrahedron(1.0))?); // they touch in one corner
//! assert_eq!(gjk::distance(&tetrahedron(0.0), &tetrahedron(3.0))?, 2.0);
//! # Ok::<(), gjk::GjkError>(())
//! ```
//!
//! [`gjk`] answers about collision, [`geometry`] has polyhedra, their hulls and their offsets. Lengths are in any unit.
//!
//! The crate `meso-core` re-exports both modules and [`math`]. What is hidden here is shared with it alone; no promise
//! covers that.

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

// The README's example is tested, too.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
