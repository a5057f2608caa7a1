//! Writers, one file per format; each takes `impl io::Write` and knows nothing of packing.

pub mod abaqus;
#[doc(hidden)]
pub mod csv;
#[doc(hidden)]
pub mod msh;
#[doc(hidden)]
pub mod pvtu;
#[doc(hidden)]
pub mod stl;
pub mod vtk;
#[doc(hidden)]
pub mod vtu;
#[doc(hidden)]
pub mod vtu_mesh;
