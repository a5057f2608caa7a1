//! Meshes of a packing: points, cells, and the phase of every cell.

use crate::math::Vec3;

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

/// The shape of a mesh's cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Four nodes, positive volume in Abaqus' (and VTK's) order.
    Tetrahedron,
    /// Eight nodes, bottom face counter-clockwise from above, then the top face.
    Hexahedron,
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
