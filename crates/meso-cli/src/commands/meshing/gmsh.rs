//! gmsh, as the command runs it.

use crate::stderr;
use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::{MeshError, VolumeMesher};
use meso_gmsh::Gmsh;

/// gmsh, whose second attempts are announced.
pub(crate) struct Announced {
    pub(super) gmsh: Gmsh,
    pub(super) quiet: bool,
}

impl VolumeMesher for Announced {
    fn available(&self) -> Result<(), MeshError> {
        self.gmsh.available()
    }

    fn fill(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        if let Some(size) = surfaces.again_mm().filter(|_| !self.quiet) {
            stderr::line(format!("gmsh's mesh cannot be used; running it again with elements of {size:.3} mm"));
        }
        self.gmsh.fill(surfaces)
    }
}
