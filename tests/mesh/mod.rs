//! Tests of meshes, through the facade.

mod caps;
mod conforming_retries;
mod distance;
mod itz;
pub(crate) mod lattice;
mod periodic;
mod report;
pub(crate) mod specimens;
pub(crate) mod voxel;
