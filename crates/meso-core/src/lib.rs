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
//! [`statistics`](mod@statistics) measures it, and [`page`] shows it. [`gjk`] answers about collision alone, without the
//! feature `concrete`.
//!
//! Units everywhere: mm, mm3, N, MPa, tonne, s, radians; volume fractions from 0 to 1, by volume of the specimen, from
//! the exact polyhedra.

// No environment, clock, file, print or mathematics of the platform: the list stands in this crate's `clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]
// Collision alone (no feature `concrete`) leaves some of geometry without a user.
#![cfg_attr(not(feature = "concrete"), allow(dead_code, unused_imports, rustdoc::broken_intra_doc_links))]

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
mod import;
mod lanes;
#[cfg(feature = "concrete")]
mod location;
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
#[doc(hidden)]
pub mod stop;
#[cfg(feature = "concrete")]
pub mod voxel_image;

/// Internals for the tests and benches of this workspace; no promise covers them.
#[doc(hidden)]
pub mod testing {
    pub use crate::geometry::hull::HullBuilder;
    pub use crate::geometry::sieve::principal_axes;
    pub use crate::gjk::cascade::Counters;
    pub use crate::simd::{Isa, choose, isa};

    #[cfg(feature = "concrete")]
    pub use crate::aggregate::random::{Purpose, Stream};
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
