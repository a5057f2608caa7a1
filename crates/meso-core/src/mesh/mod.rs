//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build()`] is the one entry; the methods are siblings. A mesh knows nothing of file formats.

mod acceptance;
mod build;
mod clip;
pub mod conforming;
mod draft;
mod error;
mod lattice;
mod layer;
mod options;
mod voxel;

#[doc(hidden)]
pub use acceptance::PhaseOff;
pub use build::{build, build_with};
#[doc(hidden)]
pub use build::{build_accepted, build_parts};
pub use conforming::VolumeMesher;
pub use error::MeshError;
pub use options::{Fit, ItzForm, Joined, MeshOptions, Method, NarrowGaps, Order, Volumes};
#[doc(hidden)]
pub use options::{MeshTable, MethodName};

pub use crate::cells::{CellKind, Mesh, Notes, Phase};
pub use crate::mesh_figures::{InterfaceDistance, PhaseVolumes};

/// How good a mesh is: the angles and shapes of its cells, the report on it, and the cost of a time step.
pub mod quality {
    pub use crate::mesh_figures::{CellQuality, MassScaling, PhaseScaling, QualityReport};
}

/// The sides of a mesh.
#[doc(hidden)]
pub mod sides {
    pub use crate::cells::{SIDES, Sides};
}
