//! What is asked of a mesh: the serde view of `mesocrete mesh` and `packing.mesh(...)`.

use super::MeshError;
use crate::packing::Specimen;
use serde::{Deserialize, Serialize};

/// Everything that decides a mesh of a given packing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshOptions {
    /// How the specimen is divided.
    pub method: Method,
    /// Edge length asked of the elements, mm; rounded so that whole elements fill the specimen.
    pub element_size_mm: f64,
    /// How the interfacial transition zone enters the mesh.
    pub itz: ItzForm,
    /// Let the solid ITZ of a voxel mesh have its own thickness, even where that is less than a voxel (and the layer
    /// has holes); otherwise it is at least one voxel thick.
    pub thin_itz: bool,
    /// Sub-samples per voxel and axis: 1 takes the phase of the centre, n the majority of n^3 points.
    pub subsamples: u32,
    /// What a lattice does at the grains' surfaces.
    pub fit: Fit,
    /// 2 puts a node in the middle of every edge of a tetrahedron (C3D10), 1 does not (C3D4).
    pub order: u32,
    /// What becomes of aggregates that would share nodes.
    pub joined: Joined,
    /// Which volume the aggregates of a fitted lattice have.
    pub volumes: Volumes,
    /// Parts of a specimen, other than a sphere, that gmsh fills apart in a conforming mesh, 1 to 100; as many as its memory
    /// needs when absent.
    pub slabs: Option<u32>,
}

/// The meshing methods, siblings behind one interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A regular grid of hexahedra, each of the phase of its centre.
    Voxel,
    /// Body-centred cubic tetrahedra, fitted to the grains or plain.
    Lattice,
    /// Tetrahedra between the exact facets, by gmsh.
    Conforming,
}

/// What a lattice does at the grains' surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// Nodes move onto the surfaces, and tetrahedra that cross one are cut.
    Fitted,
    /// Every tetrahedron has the phase of its centroid.
    Plain,
}

/// The ITZ in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ItzForm {
    /// A layer of solid elements.
    Solid,
    /// Zero-thickness cohesive elements between the aggregates and what they meet.
    Cohesive,
    /// Mortar cells with a face on an aggregate are the ITZ: as stiff as mortar, and weaker.
    Smeared,
    /// Not at all: aggregates bonded to the mortar.
    None,
}

/// What becomes of aggregates that share nodes, since the elements cannot show the gap between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Joined {
    /// They stay joined: an elastic skeleton that no analysis breaks.
    #[default]
    Keep,
    /// Mortar parts them. A cohesive ITZ does so by itself.
    Mortar,
}

/// Which volume aggregates have in a mesh of tetrahedra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Volumes {
    /// That of the mesh with its nodes on their surfaces: less than their own, since chords cut corners off.
    #[default]
    Fitted,
    /// Their own; the nodes lie some hundredths of a millimetre off their surfaces. Not with a solid ITZ.
    Exact,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            method: Method::Voxel,
            element_size_mm: 2.0,
            itz: ItzForm::Solid,
            thin_itz: false,
            subsamples: 1,
            fit: Fit::Fitted,
            order: 1,
            joined: Joined::Keep,
            volumes: Volumes::Fitted,
            slabs: None,
        }
    }
}

/// Most elements along one axis: node numbers must fit 32 bits.
const MAX_COUNT: f64 = 1500.0;
/// The same for second-order elements: a lattice has 16 nodes a cube, two of them corners.
const MAX_COUNT_QUADRATIC: f64 = 600.0;

impl MeshOptions {
    /// Checks every option against its range and the specimen.
    ///
    /// # Errors
    /// Names the option, its value and what is accepted.
    pub fn validate(&self, specimen: &Specimen) -> Result<(), MeshError> {
        let size = specimen.aabb().size();
        let most = if self.order == 2 { MAX_COUNT_QUADRATIC } else { MAX_COUNT };
        let (low, high) = (size.max() / most, size.min());
        if !(self.element_size_mm >= low && self.element_size_mm <= high) {
            let accepted = format!("it must lie within {low} and {high} mm for this specimen");
            return Err(MeshError::option("element_size_mm", self.element_size_mm, accepted));
        }
        if !(1..=8).contains(&self.subsamples) {
            return Err(MeshError::option("subsamples", self.subsamples, "it must be 1 to 8"));
        }
        self.validate_order()?;
        self.validate_slabs(specimen)
    }

    fn validate_slabs(&self, specimen: &Specimen) -> Result<(), MeshError> {
        let accepted = match self.slabs {
            None | Some(1) => return Ok(()),
            Some(2..=100) if !matches!(specimen, Specimen::Sphere { .. }) => return Ok(()),
            Some(2..=100) => "a sphere takes 1",
            Some(_) => "it must be 1 to 100",
        };
        Err(MeshError::option("slabs", self.slabs.unwrap_or_default(), accepted))
    }

    fn validate_order(&self) -> Result<(), MeshError> {
        let accepted = match (self.order, self.method, self.itz) {
            (1, ..) => return Ok(()),
            (2, Method::Voxel, _) => "voxels take 1; the methods lattice and conforming take 2",
            // There is no cohesive element over faces of six nodes.
            (2, _, ItzForm::Cohesive) => "with a cohesive itz it must be 1; itz solid or none take 2",
            (2, ..) => return Ok(()),
            _ => "it must be 1 or 2",
        };
        Err(MeshError::option("order", self.order, accepted))
    }
}
