//! Linear elasticity of a packing: stiffness on voxels, and expansion by eigenstrains.

mod equations;
mod field;
mod laminate;
mod task;
mod voxels;

pub(crate) use field::COMPONENTS;
pub use field::StressField;
pub use task::{ElasticBounds, ElasticShare, Isotropic, Stiffness, StiffnessOptions, StiffnessTensor, stiffness};
pub(crate) use task::{ElasticMedium, of_medium};
pub(crate) use voxels::Voxels;
