//! Grains of a label volume as closed surfaces: connected, smooth, of the volume of their voxels, and apart.

mod distance;
mod field;
mod labelled;
mod surfaces;
mod tetrahedra;

pub use labelled::{LabelledGrain, LabelledGrains, Roles};
pub use surfaces::{CoreCylinder, GrainSurfaces, SmoothOptions, SurfacesError};
