//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build()`] is the one entry; the methods are siblings. A mesh knows nothing of file formats.

mod build;
pub(crate) mod cells;
mod clip;
pub mod conforming;
mod error;
mod fidelity;
mod gaps;
mod interface;
mod lattice;
mod layer;
mod options;
pub mod quality;
#[doc(hidden)]
pub mod sides;
mod tet;
mod volumes;
mod voxel;

pub use build::{build, build_with};
#[doc(hidden)]
pub use build::{build_accepted, build_parts};
pub use cells::{CellKind, Mesh, Notes, Phase};
pub use conforming::VolumeMesher;
pub use error::MeshError;
pub use fidelity::InterfaceDistance;
pub use options::{Fit, ItzForm, Joined, MeshOptions, Method, NarrowGaps, Order, Volumes};
#[doc(hidden)]
pub use options::{MeshTable, MethodName};
#[doc(hidden)]
pub use volumes::PhaseOff;
pub use volumes::PhaseVolumes;
