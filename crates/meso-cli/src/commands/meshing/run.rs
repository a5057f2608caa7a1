//! Meshing: the packing becomes a mesh whose phases have nearly their volumes.

use crate::failure::Failure;
use crate::progress::Watch;
use crate::stderr;
use meso_ask::MeshAsk;
use meso_core::Model;
use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::{Mesh, MeshError, PhaseOff, Tools, VolumeMesher};
use meso_gmsh::Gmsh;
use meso_solve::footing::Footing;

/// Meshes, and finds the phase that is farthest off its exact volume.
pub(crate) fn build(
    ask: &MeshAsk,
    footing: &Footing,
    model: &Model,
    gmsh: &Gmsh,
    quiet: bool,
    watch: &Watch,
) -> Result<(Mesh, Option<PhaseOff>), Failure> {
    let gmsh = Announced { gmsh, quiet };
    footing.mesh(model, &Tools { gmsh: &gmsh, watch }).map_err(|error| ask.wrong(&error).into())
}

/// gmsh, whose second attempts are announced.
struct Announced<'a> {
    gmsh: &'a Gmsh,
    quiet: bool,
}

impl VolumeMesher for Announced<'_> {
    fn fill(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        if let Some(size) = surfaces.again_mm().filter(|_| !self.quiet) {
            stderr::line(format!("gmsh's mesh cannot be used; running it again with elements of {size:.3} mm"));
        }
        self.gmsh.fill(surfaces)
    }
}
