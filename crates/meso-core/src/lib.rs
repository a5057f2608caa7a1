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

pub use meso_collision::{geometry, gjk, math};
pub use meso_concrete::watch::{Silent, Watch};
pub use meso_concrete::{aggregate, images, import, specimen, watch};
pub use meso_mesh as mesh;
pub use meso_mesh::materials;
pub use meso_pack::{Model, Spec, SpecError, check, labelled, model, pack, packing, recipes, saved, spec, statistics};
pub use meso_trial as trial;
pub use meso_write::{export, formats, methods, page, voxel_image};

// The README's Rust example is tested, too.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;
