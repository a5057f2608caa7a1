//! The mesh itself: points, cells, and the phase and owner of every cell.

use super::notes::Notes;
use meso_collision::math::Vec3;
use meso_concrete::{Phase, PhaseNames, parallel};

/// The shape of a mesh's cells, with the numbering of their nodes.
///
/// Numbers count from 0, as in [`Mesh::cells`]; Abaqus and gmsh count from 1. Tetrahedra have a positive volume: seen from
/// node 3, nodes 0, 1, 2 are counter-clockwise. The second-order tetrahedron has nodes 4 to 9 in the middle of edges.
///
/// ```text
///        tetrahedron              second order                 hexahedron
///
///             3                        3                        7--------6
///            /|\                      /|\                      /|       /|
///           / | \                    / | \                    / |      / |
///          /  |  \                  7  |  9                  4--------5  |
///         /   |   \                /   8   \                 |  3-----|--2
///        0 -.-|-.- 2              0 -.6|-.- 2                | /      | /
///         \   |   /                \   |   /                 |/       |/
///          \  |  /                  4  |  5                  0--------1
///           \ | /                    \ | /
///             1                        1                     z up, x to the right, y to the back
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellKind {
    /// Four nodes in the order of Abaqus and VTK.
    Tetrahedron,
    /// Four corners, then the middles of the edges 0-1, 1-2, 2-0, 0-3, 1-3, 2-3.
    QuadraticTetrahedron,
    /// Eight nodes, bottom face counter-clockwise from above, then the top face.
    Hexahedron,
}

impl CellKind {
    /// Nodes per cell.
    pub fn nodes(self) -> usize {
        match self {
            Self::Tetrahedron => 4,
            Self::QuadraticTetrahedron => 10,
            Self::Hexahedron => 8,
        }
    }

    /// Nodes of a cell that are corners; they come first.
    pub fn corners(self) -> usize {
        match self {
            Self::Tetrahedron | Self::QuadraticTetrahedron => 4,
            Self::Hexahedron => 8,
        }
    }

    /// The faces' corners in Abaqus' order, S1 first, as positions in the cell; counter-clockwise seen from outside.
    pub fn faces(self) -> &'static [&'static [usize]] {
        match self {
            Self::Tetrahedron | Self::QuadraticTetrahedron => &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
            Self::Hexahedron => {
                &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]]
            }
        }
    }

    /// The tetrahedra that make up a cell, by its corners; a box has six around the diagonal from its first corner. Boxes of a grid
    /// share the diagonals of their faces.
    pub fn tetrahedra(self) -> &'static [[usize; 4]] {
        match self {
            Self::Tetrahedron | Self::QuadraticTetrahedron => &[[0, 1, 2, 3]],
            Self::Hexahedron => &[[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]],
        }
    }

    /// The faces' corners, then the middle nodes of their edges, the first edge's first; as positions in the cell.
    pub fn face_nodes(self) -> &'static [&'static [usize]] {
        match self {
            Self::QuadraticTetrahedron => {
                &[&[0, 2, 1, 6, 5, 4], &[0, 1, 3, 4, 8, 7], &[1, 2, 3, 5, 9, 8], &[2, 0, 3, 6, 7, 9]]
            }
            _ => self.faces(),
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
    /// Index of the body that every cell belongs to, one for a body and its periodic images; [`Mesh::NO_BODY`] in the mortar.
    pub owner: Vec<u32>,
    /// Id of every body, by its index; only files have ids.
    pub id_of: Vec<u32>,
    /// Zero-thickness cohesive elements: the aggregate side's face, then the nodes over it (6 or 8 in all).
    pub cohesive: Vec<u32>,
    /// Index of the body below every cohesive element.
    pub cohesive_owner: Vec<u32>,
    /// The directions in which the specimen repeats itself.
    pub periodic: [bool; 3],
    /// The phases, with the names of the specimen's own.
    pub phases: PhaseNames,
    /// Decisions of the builder.
    pub notes: Notes,
}

/// [`Mesh::NO_BODY`] by a short name.
pub(crate) const NO_BODY: u32 = Mesh::NO_BODY;

impl Mesh {
    /// The owner of a cell that lies in no body, and its id in files.
    pub const NO_BODY: u32 = u32::MAX;

    /// A mesh without cohesive elements, of a specimen that does not repeat itself; ids are the bodies' indices.
    pub fn of(kind: CellKind, points: Vec<Vec3>, cells: Vec<u32>, phase: Vec<Phase>, owner: Vec<u32>) -> Self {
        let bodies = owner.iter().filter(|owner| **owner != NO_BODY).max().map_or(0, |last| last + 1);
        let (cohesive, cohesive_owner) = (Vec::new(), Vec::new());
        let (periodic, phases, notes) = ([false; 3], PhaseNames::default(), Notes::default());
        let id_of = (0..bodies).collect();
        Self { points, kind, cells, phase, owner, id_of, cohesive, cohesive_owner, periodic, phases, notes }
    }

    /// The cells' node indices, one slice per cell.
    pub fn cells(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.cells.chunks_exact(self.kind.nodes())
    }

    /// The node indices of one cell.
    pub fn cell(&self, cell: usize) -> &[u32] {
        let nodes = self.kind.nodes();
        &self.cells[nodes * cell..][..nodes]
    }

    /// The cohesive elements' nodes, one slice per element.
    pub fn cohesive(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.cohesive.chunks_exact(2 * self.kind.faces()[0].len())
    }

    /// Id of the body that every cell belongs to; [`Mesh::NO_BODY`] in the mortar.
    pub fn ids(&self) -> impl ExactSizeIterator<Item = u32> {
        self.owner.iter().map(|&owner| self.id(owner))
    }

    /// Id of the body of index `owner`.
    pub fn id(&self, owner: u32) -> u32 {
        self.id_of.get(owner as usize).copied().unwrap_or(NO_BODY)
    }

    /// Number of cells, cohesive elements apart.
    pub fn cell_count(&self) -> usize {
        self.phase.len()
    }

    /// Whether the ITZ is mortar at the aggregates' surfaces, [`ItzForm::Smeared`](crate::ItzForm::Smeared): its cells
    /// belong to no aggregate.
    pub fn has_smeared_itz(&self) -> bool {
        let mut cells = self.phase.iter().zip(&self.owner);
        cells.any(|(phase, owner)| *phase == Phase::Itz && *owner == NO_BODY)
    }
}

/// Volume of a cell, mm3; negative where its nodes are out of order.
pub(crate) fn cell_volume(kind: CellKind, cell: &[u32], points: &[Vec3]) -> f64 {
    let p = |i: usize| points[cell[i] as usize];
    let six = |a: usize, b: usize, c: usize, d: usize| (p(b) - p(a)).cross(&(p(c) - p(a))).dot(&(p(d) - p(a)));
    match kind {
        CellKind::Tetrahedron | CellKind::QuadraticTetrahedron => volume([p(0), p(1), p(2), p(3)]),
        // Six tetrahedra around the diagonal 0-6: exact for the parallelepipeds that voxels are.
        CellKind::Hexahedron => {
            [(1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1)].iter().map(|&(b, c)| six(0, b, c, 6)).sum::<f64>() / 6.0
        }
    }
}

/// The new number of a node that is dropped.
pub(crate) const DROPPED: u32 = u32::MAX;

/// Takes the nodes without cells out, and numbers the others anew in their order; the new numbers, or [`DROPPED`].
pub(crate) fn drop_lone_nodes(points: &mut Vec<Vec3>, cells: &mut [u32]) -> Vec<u32> {
    let mut number = vec![DROPPED; points.len()];
    cells.iter().for_each(|&node| number[node as usize] = 0);
    for (count, number) in (0..).zip(number.iter_mut().filter(|number| **number != DROPPED)) {
        *number = count;
    }
    let mut old = number.iter();
    points.retain(|_| old.next() != Some(&DROPPED));
    parallel::each_short_mut(cells, |_, node| *node = number[*node as usize]);
    number
}

/// Volume of a tetrahedron, mm3; negative where its corners are out of order.
pub(crate) fn volume([a, b, c, d]: [Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// Cells of a mesh, with the index of the body that owns each.
#[derive(Clone, Copy)]
pub struct Cells<'a> {
    pub(crate) kind: CellKind,
    pub(crate) points: &'a [Vec3],
    /// Node indices, [`CellKind`]'s number of them per cell.
    pub(crate) nodes: &'a [u32],
    pub(crate) owner: &'a [u32],
}

impl<'a> Cells<'a> {
    /// The cells' node indices, one slice per cell.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = &'a [u32]> + use<'a> {
        self.nodes.chunks_exact(self.kind.nodes())
    }

    /// The node indices of one cell.
    pub(crate) fn cell(&self, cell: usize) -> &'a [u32] {
        let nodes = self.kind.nodes();
        &self.nodes[nodes * cell..][..nodes]
    }

    /// The corners of a cell's face, counter-clockwise from outside.
    pub fn face(&self, cell: u32, face: usize) -> impl Iterator<Item = u32> + use<'a> {
        let of_cell = self.cell(cell as usize);
        self.kind.faces()[face].iter().map(|&i| of_cell[i])
    }
}

/// Cells whose volumes are known at once.
const WINDOW: usize = 1 << 20;

/// Calls `visit` with the number and the volume, mm3, of every cell that a body owns, in order.
pub(crate) fn owned_volumes(cells: Cells, mut visit: impl FnMut(usize, f64)) {
    let is_owned = |cell: usize| cells.owner[cell] != NO_BODY;
    let volume = |cell: usize| cell_volume(cells.kind, cells.cell(cell), cells.points);
    for first in (0..cells.owner.len()).step_by(WINDOW) {
        let of = |i: usize| if is_owned(first + i) { volume(first + i) } else { 0.0 };
        let volumes = parallel::map_short(WINDOW.min(cells.owner.len() - first), of);
        (first..).zip(volumes).filter(|(cell, _)| is_owned(*cell)).for_each(|(cell, volume)| visit(cell, volume));
    }
}

/// Cells looked at, or added up, together.
const RUN: usize = 1 << 16;

impl Mesh {
    /// The cells by their bodies' indices.
    pub fn by_owner(&self) -> Cells<'_> {
        Cells { kind: self.kind, points: &self.points, nodes: &self.cells, owner: &self.owner }
    }

    /// Volume of a cell, mm3.
    pub(crate) fn volume(&self, cell: usize) -> f64 {
        let nodes = self.kind.nodes();
        cell_volume(self.kind, &self.cells[cell * nodes..][..nodes], &self.points)
    }

    /// Applies `of_run` to runs of cells: the number of the first, all nodes, all phases. Runs have one length and their results are
    /// in order, so that sums are the same on any number of threads.
    pub(crate) fn in_runs<T: Send>(&self, of_run: impl Fn(usize, &[u32], &[Phase]) -> T + Sync) -> Vec<T> {
        let runs: Vec<_> = self.cells.chunks(RUN * self.kind.nodes()).zip(self.phase.chunks(RUN)).collect();
        parallel::map(runs.len(), |run| of_run(run * RUN, runs[run].0, runs[run].1))
    }
}
