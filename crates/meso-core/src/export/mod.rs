//! Writers, one file per format; each takes `impl io::Write` and knows nothing of packing.

pub mod abaqus;
pub mod csv;
pub mod msh;
pub mod pvtu;
pub mod raster;
pub mod stl;
pub mod vtk;
pub mod vtu;
pub mod vtu_mesh;
