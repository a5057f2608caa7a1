//! Linear elasticity of a packing: stiffness on voxels, and expansion by eigenstrains.

mod equations;
mod laminate;
mod task;
mod voxels;

pub use task::{ElasticBounds, ElasticShare, Isotropic, Stiffness, StiffnessOptions, StiffnessTensor, stiffness};
