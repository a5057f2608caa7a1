//! The sample of a test: a mesh, and the facts about its specimen that the mesh does not hold.

use crate::error::SolveError;
use meso_collision::math::Aabb;
use meso_concrete::Ranges;
use meso_concrete::specimen::Specimen;
use meso_mesh::materials::band_factor;
use meso_mesh::{CellKind, Mesh, MeshOptions, PhaseVolumes};

/// A meshed specimen; it is loaded along z.
#[derive(Clone, Debug)]
pub struct Sample<'a> {
    /// Linear tetrahedra, or boxes of one size.
    pub mesh: &'a Mesh,
    /// Gross section, mm2: forces over it are stresses.
    pub section_mm2: f64,
    /// Gross volume, mm3: volumes over it are fractions.
    pub volume_mm3: f64,
    /// Element size asked of the mesh, mm: it decides the time step.
    pub element_size_mm: f64,
    /// Width of a crack band over the edge of a box, or of the regular tetrahedron of a cell's volume: [`band_factor`].
    pub band_factor: f64,
    /// The phases' exact volumes, where known.
    pub exact: Option<PhaseVolumes>,
}

impl<'a> Sample<'a> {
    /// `mesh` as it was built of `specimen` with `options`.
    pub fn of(mesh: &'a Mesh, specimen: &Specimen, options: &MeshOptions) -> Self {
        Self {
            mesh,
            section_mm2: gross_section_mm2(specimen),
            volume_mm3: specimen.volume(),
            element_size_mm: options.element_size_mm,
            band_factor: band_factor(mesh),
            exact: None,
        }
    }

    /// Along z, mm.
    pub fn height_mm(&self) -> f64 {
        Aabb::around(&self.mesh.points).size().z
    }

    pub(crate) fn validate(&self) -> Result<(), SolveError> {
        if self.mesh.kind == CellKind::QuadraticTetrahedron {
            return Err(SolveError::mesh("its tetrahedra are of second order; mesh with order 1"));
        }
        if self.mesh.cell_count() == 0 {
            return Err(SolveError::mesh("it has no cells"));
        }
        for (key, value) in [
            ("section_mm2", self.section_mm2),
            ("volume_mm3", self.volume_mm3),
            ("element_size_mm", self.element_size_mm),
            ("band_factor", self.band_factor),
        ] {
            Ranges("sample").positive(key, value)?;
        }
        Ok(())
    }
}

/// Section across z that a test's forces are divided by, mm2: that of a sphere is its largest, notches do not count.
pub fn gross_section_mm2(specimen: &Specimen) -> f64 {
    match specimen {
        Specimen::Sphere { diameter_mm } => std::f64::consts::FRAC_PI_4 * diameter_mm * diameter_mm,
        Specimen::NotchedPrism { length_mm, width_mm, .. } => length_mm * width_mm,
        _ => specimen.volume() / specimen.aabb().size().z,
    }
}
