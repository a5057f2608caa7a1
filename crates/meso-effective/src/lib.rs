//! Effective diffusivity, conductivity and stiffness of packings, each with its error.
//!
//! A packing's mean flux for a mean gradient, on voxels whose links take their conductances from the exact geometry: see
//! `links`. The solver is `solver`'s; periodic axes stay periodic, walls have given potentials at the faces and insulated
//! sides. Solutions on voxels of twice and four times the size give the error: see `estimate`. Label volumes have bounds. Stiffness has trilinear voxels of layered phases: see
//! `elastic`.
//!
//! ```
//! use meso_core::{Silent, Spec, pack};
//! use meso_effective::{EffectiveOptions, Phases, Property, effective};
//!
//! let spec = Spec::from_toml("fraction = 0.3\nspecimen = { kind = \"cube\", side_mm = 40, periodic = [\"x\", \"y\", \"z\"] }")?;
//! let model = pack(&spec, &Silent)?;
//! let options = EffectiveOptions::new(Property::Diffusivity, 2.0);
//! let found = effective(&model, &Phases::default(), &options, &Silent)?.0;
//! assert!(found.tensor[0][0].unwrap() < found.bounds.voigt);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

mod boundary;
mod bounds;
mod effective;
mod elastic;
mod error;
mod estimate;
mod field;
mod flow;
mod grid;
mod labels;
mod links;
mod moduli;
mod phases;
mod resolution;
pub mod results;
mod sections;
mod shares;
mod solutions;
mod solver;
mod surfaces;
mod tetrahedra;

pub use boundary::Boundary;
pub use bounds::PropertyBounds;
pub use effective::{At, Effective, EffectiveOptions, FluxTensor, PhaseShare, effective};
pub use elastic::{ElasticBounds, ElasticShare, Isotropic, Stiffness, StiffnessOptions, StiffnessTensor, stiffness};
pub use error::EffectiveError;
pub use field::{FieldCells, PropertyField};
pub use labels::{LabelPhases, LabelSpecimen, effective_of_labels, stiffness_of_labels};
pub use moduli::{GivenModuli, Moduli, PhaseModuli};
pub use phases::{GivenValues, PhaseValues, Phases, Property};
pub use resolution::Resolution;
pub use surfaces::ByPhase;
pub use tetrahedra::{
    CrackValues, Cracked, Unloading, effective_in_cracks, effective_in_tetrahedra, moduli_in_cracks,
    stiffness_in_tetrahedra,
};
