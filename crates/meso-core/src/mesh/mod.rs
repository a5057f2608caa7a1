//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build()`] is the one entry; the methods are siblings. A mesh knows nothing of file formats.

pub(crate) mod apart;
mod build;
pub(crate) mod cells;
mod clip;
pub mod conforming;
mod crack_band;
mod error;
pub(crate) mod fidelity;
mod interface;
mod lattice;
mod layer;
pub(crate) mod location;
mod narrow_gaps;
mod options;
mod own_volume;
mod phase_error;
pub mod quality;
#[doc(hidden)]
pub mod sides;
mod smeared;
mod subsamples;
mod tet;
mod voxel;

pub use build::{build, build_with};
#[doc(hidden)]
pub use build::{build_accepted, build_parts, build_watched};
pub use cells::{CellKind, Mesh, NO_AGGREGATE, Notes, Phase};
pub use conforming::VolumeMesher;
#[doc(hidden)]
pub use crack_band::{band_factor, regular_edge};
pub(crate) use crack_band::{characteristic_mm, width_mm};
pub use error::MeshError;
pub use fidelity::InterfaceDistance;
pub use options::{Fit, ItzForm, Joined, MeshOptions, Method, NarrowGaps, Order, Volumes};
#[doc(hidden)]
pub use options::{MeshTable, MethodName};
#[doc(hidden)]
pub use phase_error::PhaseOff;
pub use quality::PhaseVolumes;
