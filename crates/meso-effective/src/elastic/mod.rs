//! Linear elasticity of a packing: stiffness on voxels, and expansion by eigenstrains.

mod blocks;
mod equations;
mod laminate;
mod modes;
mod rows;
mod task;
mod voxels;

pub use task::{ElasticBounds, ElasticShare, Isotropic, Stiffness, StiffnessOptions, StiffnessTensor, stiffness};
pub(crate) use task::{ElasticMedium, Strained, Sums, columns, of_medium, shares};
pub(crate) use voxels::Voxels;
