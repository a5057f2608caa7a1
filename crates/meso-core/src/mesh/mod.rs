//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build()`] is the one entry; the methods are siblings. A mesh knows nothing of file formats.

pub(crate) mod apart;
mod build;
pub(crate) mod cells;
pub mod conforming;
mod error;
mod fidelity;
mod interface;
mod lattice;
mod layer;
mod location;
mod options;
mod own_volume;
pub mod quality;
#[doc(hidden)]
pub mod sides;
mod smeared;
mod tet;
mod voxel;

#[doc(hidden)]
pub use build::build_parts;
pub use build::{build, build_with};
pub use cells::{CellKind, Mesh, NO_AGGREGATE, Notes, Phase};
pub use conforming::VolumeMesher;
pub use error::MeshError;
pub use fidelity::InterfaceDistance;
pub use options::{Fit, ItzForm, Joined, MeshOptions, Method, Order, Volumes};
#[doc(hidden)]
pub use options::{MeshTable, MethodName};
pub use quality::PhaseVolumes;
