//! The sample of a test: a mesh, and the facts about its specimen that the mesh does not hold.

use crate::error::TrialError;
use meso_collision::math::Aabb;
use meso_concrete::Ranges;
use meso_concrete::specimen::{Container, Specimen};
use meso_mesh::materials::band_factor;
use meso_mesh::{CellKind, Mesh, MeshOptions, PhaseVolumes};
use std::sync::Arc;

/// Difference of a mesh's volume from its specimen's, over that, beyond which stresses mean nothing. A cylinder of 6 voxels in
/// diameter had 12 % too much strength.
const FAR_FROM_SPECIMEN: f64 = 0.02;

/// The measures of a specimen that a test depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Sizes along x, y and z, mm.
    pub size_mm: [f64; 3],
    /// Gross section across z, mm2.
    pub section_mm2: f64,
    /// Depth of the notch in the lower side, mm; 0 without a notch.
    pub notch_mm: f64,
    /// Depth of the notch in the upper side, mm; 0 without a notch.
    pub upper_notch_mm: f64,
    /// Place of both notches along x, mm from the middle.
    pub notch_at_mm: f64,
}

impl Geometry {
    /// Measures of a specimen.
    pub fn of(specimen: &Specimen) -> Self {
        let (size_mm, section_mm2) = (specimen.aabb().size().into(), gross_section_mm2(specimen));
        let [notch_mm, upper_notch_mm] = notches_mm(specimen);
        Self { size_mm, section_mm2, notch_mm, upper_notch_mm, notch_at_mm: notch_at_mm(specimen) }
    }
}

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
    /// Depths of the notches in the lower and in the upper side, mm; 0 without a notch.
    pub notches_mm: [f64; 2],
    /// Place of the notches along x, mm from the middle.
    pub notch_at_mm: f64,
    /// Volume of both notches, mm3.
    pub notches_mm3: f64,
    /// Shape of the specimen, for depths below its surface.
    pub container: Arc<dyn Container>,
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
            notches_mm: notches_mm(specimen),
            notch_at_mm: notch_at_mm(specimen),
            notches_mm3: notches_mm3(specimen),
            container: specimen.container(),
            exact: None,
        }
    }

    /// Geometry that a test depends on.
    pub fn geometry(&self) -> Geometry {
        let size_mm = Aabb::around(&self.mesh.points).size().into();
        let [notch_mm, upper_notch_mm] = self.notches_mm;
        let notch_at_mm = self.notch_at_mm;
        Geometry { size_mm, section_mm2: self.section_mm2, notch_mm, upper_notch_mm, notch_at_mm }
    }

    /// Refuses a mesh without cells or of second order, and measures that are no positive numbers.
    pub fn validate(&self) -> Result<(), TrialError> {
        if self.mesh.kind == CellKind::QuadraticTetrahedron {
            return Err(TrialError::mesh("its tetrahedra are of second order; mesh with order 1"));
        }
        if self.mesh.cell_count() == 0 {
            return Err(TrialError::mesh("it has no cells"));
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

    /// Compares the whole mesh with the specimen: where it is larger, forces over the gross section are no stresses.
    pub fn validate_volume(&self) -> Result<(), TrialError> {
        let share = self.meshed_mm3() / self.volume_mm3;
        if (share - 1.0).abs() <= FAR_FROM_SPECIMEN {
            return Ok(());
        }
        let share = 100.0 * share;
        Err(TrialError::mesh(format!(
            "its cells fill {share:.1} % of the specimen's volume, so that strength and modulus would be off by as much; take \
             smaller elements, or the method lattice, whose surface follows the specimen"
        )))
    }

    /// Share of the notches' volume by which the mesh differs from the specimen; 0 without notches.
    pub fn notch_error(&self) -> f64 {
        if self.notches_mm3 > 0.0 { (self.meshed_mm3() - self.volume_mm3) / self.notches_mm3 } else { 0.0 }
    }

    /// Volume of all cells and of the voids, mm3.
    fn meshed_mm3(&self) -> f64 {
        let PhaseVolumes { mortar, itz, aggregate, fibre, .. } = PhaseVolumes::of_mesh(self.mesh);
        mortar + itz + aggregate + fibre + self.mesh.notes.voids_mm3
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

/// Volume of a specimen's notches, mm3.
fn notches_mm3(specimen: &Specimen) -> f64 {
    match specimen {
        Specimen::NotchedPrism { notch_width_mm, width_mm, .. } => {
            notches_mm(specimen).iter().sum::<f64>() * notch_width_mm * width_mm
        }
        _ => 0.0,
    }
}

/// Place of a specimen's notches along x, mm from its middle.
fn notch_at_mm(specimen: &Specimen) -> f64 {
    if let Specimen::NotchedPrism { notch_at_mm, .. } = specimen { *notch_at_mm } else { 0.0 }
}

/// Depths of a specimen's lower and upper notch, mm; 0 without one.
fn notches_mm(specimen: &Specimen) -> [f64; 2] {
    match specimen {
        Specimen::NotchedPrism { notch_depth_mm, upper_notch_depth_mm, .. } => [*notch_depth_mm, *upper_notch_depth_mm],
        _ => [0.0; 2],
    }
}
