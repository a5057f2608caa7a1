//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build()`] is the one entry; the methods are siblings. A mesh knows nothing of file formats.

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

mod acceptance;
mod analysis;
mod build;
pub mod cells;
mod clip;
pub mod conforming;
mod draft;
mod error;
pub mod figures;
mod lattice;
mod layer;
pub mod location;
pub mod materials;
mod options;
mod tet;
mod triangulation;
mod voxel;

pub use acceptance::PhaseOff;
pub use build::{Tools, build};
pub use cells::{CellKind, Mesh, Notes, Phase};
pub use conforming::VolumeMesher;
pub use error::{MeshError, Ways};
pub use figures::{InterfaceDistance, PhaseVolumes};
pub use meso_concrete::Room;
pub use options::{
    Fit, ItzForm, Joined, MeshOptions, MeshTable, Method, MethodName, NarrowGaps, Order, Purpose, Volumes,
};
