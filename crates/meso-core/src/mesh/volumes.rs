//! How much of the specimen each phase fills: in the mesh, and exactly.

use super::cells::{CellKind, Mesh, Phase};
use super::error::MeshError;
use super::tet::{TetMesh, volume};
use crate::aggregate::{Aggregate, Kind};
use crate::geometry::OffsetError;
use crate::math::Vec3;
use crate::packing::Specimen;
use rayon::prelude::*;
use serde::Serialize;

/// Volume of every phase, mm3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PhaseVolumes {
    /// Aggregate cores.
    pub aggregate: f64,
    /// Shells.
    pub itz: f64,
    /// Everything else, but for voids.
    pub mortar: f64,
    /// Fibres.
    #[serde(skip_serializing_if = "is_zero")]
    pub fibre: f64,
}

/// Cells added up together.
const RUN: usize = 1 << 16;

fn is_zero(volume: &f64) -> bool {
    *volume == 0.0
}

impl PhaseVolumes {
    /// The phases' volumes in `mesh`.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let nodes = mesh.kind.nodes();
        let of_run = |(cells, phases): (&[u32], &[Phase])| {
            let mut sums = [0.0; 5];
            for (cell, phase) in cells.chunks_exact(nodes).zip(phases) {
                sums[*phase as usize] += cell_volume(mesh.kind, cell, &mesh.points);
            }
            sums
        };
        // Runs of one length, added in their order: the same on any number of threads.
        let runs: Vec<[f64; 5]> =
            mesh.cells.par_chunks(RUN * nodes).zip(mesh.phase.par_chunks(RUN)).map(of_run).collect();
        let [mortar, itz, aggregate, _, fibre] = std::array::from_fn(|i| runs.iter().map(|sums| sums[i]).sum());
        Self { aggregate, itz, mortar, fibre }
    }

    /// That of one phase.
    pub fn of(&self, phase: Phase) -> f64 {
        match phase {
            Phase::Mortar => self.mortar,
            Phase::Itz => self.itz,
            Phase::Aggregate => self.aggregate,
            Phase::Fibre => self.fibre,
        }
    }

    /// The exact volumes, from the polyhedra; `shell(aggregate)` is the thickness of its shell, mm.
    ///
    /// # Errors
    /// Where an aggregate's core has no trustworthy volume.
    pub fn exact(
        aggregates: &[Aggregate],
        specimen: &Specimen,
        shell: impl Fn(&Aggregate) -> f64 + Sync,
    ) -> Result<Self, OffsetError> {
        let core = |aggregate: &Aggregate| {
            let inner = if aggregate.kind == Kind::Aggregate { shell(aggregate) } else { 0.0 };
            Ok(crate::geometry::inward_offset(&aggregate.body, inner)?.map_or(0.0, |body| body.volume()))
        };
        // Summed in the aggregates' order: the same on any number of threads.
        let cores = aggregates.par_iter().map(core).collect::<Result<Vec<f64>, OffsetError>>()?;
        let (mut all, mut outer, mut inside, mut fibre) = (0.0, 0.0, 0.0, 0.0);
        for (aggregate, core) in aggregates.iter().zip(cores) {
            let volume = aggregate.body.volume();
            all += volume;
            match aggregate.kind {
                Kind::Aggregate => (outer, inside) = (outer + volume, inside + core),
                Kind::Void => {}
                Kind::Fibre => fibre += volume,
            }
        }
        Ok(Self { aggregate: inside, itz: outer - inside, mortar: specimen.volume() - all, fibre })
    }

    /// Sum of the phases, mm3.
    pub fn total(&self) -> f64 {
        self.aggregate + self.itz + self.mortar + self.fibre
    }
}

/// Refuses a mesh with a cell of no positive volume: no solver takes it.
pub(super) fn all_positive(mesh: &Mesh) -> Result<(), MeshError> {
    let cells = mesh.cells.par_chunks_exact(mesh.kind.nodes());
    let solid = |cell: &&[u32]| cell_volume(mesh.kind, cell, &mesh.points) > 0.0;
    let flat: Vec<&[u32]> = cells.filter(|cell| !solid(cell)).collect();
    match flat.first() {
        None => Ok(()),
        Some(first) => Err(MeshError::Flat { cells: flat.len(), at: mesh.points[first[0] as usize].into() }),
    }
}

/// Refuses tetrahedra of which one has no positive volume.
pub(super) fn all_tetrahedra_positive(mesh: &TetMesh) -> Result<(), MeshError> {
    let flat: Vec<u32> = mesh.numbers().into_par_iter().filter(|&cell| !(mesh.volume(cell) > 0.0)).collect();
    match flat.first() {
        None => Ok(()),
        Some(&first) => Err(MeshError::Flat { cells: flat.len(), at: mesh.position(mesh.cell(first)[0]).into() }),
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
