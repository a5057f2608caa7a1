//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build()`] is the one way in; the methods are siblings. A mesh knows nothing of file formats.

mod build;
pub(crate) mod cells;
mod clip;
mod closed_gaps;
pub mod conforming;
mod error;
mod interface;
mod interface_error;
mod lattice;
mod layer;
mod location;
mod options;
pub(crate) mod periodic;
pub mod quality;
mod second_order;
pub mod sides;
mod tet;
mod volumes;
mod voxel;

pub use build::{build, build_parts, build_with};
pub use cells::{CellKind, Mesh, NO_AGGREGATE, Notes, Phase};
pub use conforming::VolumeMesher;
pub use error::MeshError;
pub use interface_error::InterfaceDistance;
pub use options::{Fit, ItzForm, MeshOptions, MeshTable, Method, MethodName, Order};
pub use volumes::PhaseVolumes;
