//! Tests of meshes, through the facade.

mod caps;
mod conforming_retries;
mod distance;
mod itz;
pub(crate) mod lattice;
mod periodic;
mod report;
mod scatter;
pub(crate) mod specimens;
pub(crate) mod voxel;
