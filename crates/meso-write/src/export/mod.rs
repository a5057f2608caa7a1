//! Writers, one file per format; each takes `impl io::Write` and knows nothing of packing.

pub mod abaqus;
pub(crate) mod ansys;
pub(crate) mod appearance;
mod columns;
pub(crate) mod csv;
pub(crate) mod glb;
mod heading;
mod lines;
pub mod lsdyna;
pub(crate) mod msh;
pub(crate) mod obj;
pub(crate) mod ply;
pub(crate) mod pvtu;
pub(crate) mod raster;
pub(crate) mod script;
pub(crate) mod step;
pub mod stl;
pub(crate) mod vtu;
pub(crate) mod xdmf;

pub use meso_view::vtk::mesh as vtu_mesh;

pub use appearance::{CLASSES, PALETTE};
