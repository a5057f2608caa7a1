//! Meshes of a packing: points, cells, and the phase of every cell.
//!
//! [`build`] is the one way in; the methods are siblings, one file each. A mesh knows nothing of file formats.

mod error;
mod options;
mod sweep;
mod volumes;
mod voxel;

pub use error::MeshError;
pub use options::{ItzForm, MeshOptions, Method};
pub use volumes::PhaseVolumes;

use crate::aggregate::Aggregate;
use crate::math::Vec3;
use crate::model::Model;
use crate::packing::Specimen;

/// The material a cell is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Phase {
    /// The matrix.
    Mortar = 0,
    /// The shell between an aggregate's outer and inner surface.
    Itz = 1,
    /// The inside of an aggregate.
    Aggregate = 2,
}

impl Phase {
    /// All phases, in the order decks list them.
    pub const ALL: [Self; 3] = [Self::Aggregate, Self::Itz, Self::Mortar];

    /// The name of its element set and of its material.
    pub fn name(self) -> &'static str {
        match self {
            Self::Mortar => "MORTAR",
            Self::Itz => "ITZ",
            Self::Aggregate => "AGGREGATE",
        }
    }
}

/// The shape of a mesh's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Four nodes, positive volume in Abaqus' (and VTK's) order.
    Tetrahedron,
    /// Eight nodes, bottom face counter-clockwise from above, then the top face.
    Hexahedron,
}

impl CellKind {
    /// Nodes per cell.
    pub fn nodes(self) -> usize {
        match self {
            Self::Tetrahedron => 4,
            Self::Hexahedron => 8,
        }
    }

    /// The faces in Abaqus' order, S1 first, as positions in the cell; counter-clockwise seen from outside.
    pub fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            Self::Hexahedron => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
        }
    }
}

/// A mesh of one kind of cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Node positions, mm.
    pub points: Vec<Vec3>,
    /// Kind of all cells.
    pub kind: CellKind,
    /// Node indices, [`CellKind`]'s number of them per cell.
    pub cells: Vec<u32>,
    /// Phase of every cell.
    pub phase: Vec<Phase>,
    /// Id of the aggregate every cell belongs to; `u32::MAX` in the mortar.
    pub aggregate: Vec<u32>,
}

/// [`Mesh::aggregate`] of a cell that belongs to none.
pub const NO_AGGREGATE: u32 = u32::MAX;

impl Mesh {
    /// The cells' node indices, one slice per cell.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.cells.chunks_exact(self.kind.nodes())
    }

    /// Number of cells.
    pub fn cell_count(&self) -> usize {
        self.phase.len()
    }
}

/// Meshes a packed specimen.
///
/// # Errors
/// Options that cannot be met are named before any work starts; see [`MeshError`].
pub fn build(model: &Model, options: &MeshOptions) -> Result<Mesh, MeshError> {
    build_parts(&model.aggregates, &model.spec.specimen, options)
}

/// Meshes `aggregates`, which must be disjoint and inside `specimen`.
///
/// # Errors
/// As [`build`].
pub fn build_parts(aggregates: &[Aggregate], specimen: &Specimen, options: &MeshOptions) -> Result<Mesh, MeshError> {
    options.validate(specimen)?;
    match options.method {
        Method::Voxel => Ok(voxel::build(aggregates, specimen, options)),
    }
}
