//! mesocrete: mesoscale concrete, packed without overlap.
//!
//! ```
//! use meso_core::{Silent, Spec, check::check, pack, saved};
//!
//! let spec = Spec::from_toml("fraction = 0.3\nspecimen = { kind = \"cube\", side_mm = 60 }")?;
//! let model = pack(&spec, &Silent)?;
//! assert!((model.report.fraction - 0.3).abs() < 2e-3);
//! assert!(check(&model).is_sound());
//! saved::write(&model, std::io::sink())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The way through: a [`Spec`] holds every option, [`pack`] makes a [`Model`] of it, [`mesh::build`](mesh::build())
//! meshes the model, and [`formats`] and [`export`] write both. [`check`](mod@check) proves a model,
//! [`statistics`](mod@statistics) measures it, and [`page`] shows it. [`gjk`] answers about collision; it and [`geometry`] are
//! the crate `meso-collision`.
//!
//! Units everywhere: mm, mm3, N, MPa, tonne, s, radians; volume fractions from 0 to 1, by volume of the specimen, from
//! the exact polyhedra.

// No environment, clock, file, print or mathematics of the platform: the list stands in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

pub mod aggregate;
mod analysis_mesh;
mod cells;
pub mod check;
pub mod export;
pub mod formats;
mod import;
mod location;
pub mod materials;
pub mod mesh;
mod mesh_figures;
pub mod model;
pub mod packing;
pub mod page;
mod parallel;
pub mod recipes;
pub mod saved;
pub mod spec;
pub mod statistics;
#[doc(hidden)]
pub mod stop;
mod tet;
mod thousands;
mod triangulation;
pub mod voxel_image;

/// Internals for the tests and benches of this workspace; no promise covers them.
#[doc(hidden)]
pub mod testing {
    pub use crate::aggregate::random::{Purpose, Stream};
}

// For the engine.
#[doc(hidden)]
pub use meso_collision::prefetch;
pub use meso_collision::{geometry, gjk, math};
use meso_collision::{lanes, simd};

pub use model::{Model, pack};
pub use packing::{Progress, Silent};
pub use spec::{Spec, SpecError};
// For the fronts: the command, the Python package, the page of a test.
#[doc(hidden)]
pub use thousands::thousands;

// The README's Rust example is tested, too.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
