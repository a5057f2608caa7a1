//! Linear elasticity of a packing: stiffness on voxels, and expansion by eigenstrains.

mod blocks;
mod equations;
mod field;
mod laminate;
mod modes;
mod rows;
mod task;
mod voxels;

pub use field::StressField;
pub(crate) use field::{COMPONENTS, OF_VTK, von_mises};
pub use task::{ElasticBounds, ElasticShare, Isotropic, Stiffness, StiffnessOptions, StiffnessTensor, stiffness};
pub(crate) use task::{ElasticMedium, Solved, Strained, Sums, of_medium, shares};
pub(crate) use voxels::Voxels;
