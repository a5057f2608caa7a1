//! Phase of every cell in a test: joined aggregates are parted, and the ITZ is smeared where the mesh has none.

use crate::test::{Itz, Joined};
use meso_mesh::{Mesh, Phase};

/// Phases as they are solved, and what was changed.
#[derive(Clone, Debug)]
pub(crate) struct Phases {
    /// Of every cell.
    pub(crate) of_cells: Vec<Phase>,
    /// Pairs of aggregates or fibres that share nodes in the mesh.
    pub(crate) joined_pairs: usize,
    /// Cells of aggregates that became mortar.
    pub(crate) parted_cells: usize,
    /// Cells of aggregates.
    pub(crate) aggregate_cells: usize,
    /// Mortar cells that took the ITZ's strength.
    pub(crate) smeared_cells: usize,
}

impl Phases {
    /// Those of `mesh`.
    pub(crate) fn of(mesh: &Mesh, joined: Joined, itz: Itz) -> Self {
        let aggregate_cells = mesh.phase.iter().filter(|&&phase| phase == Phase::Aggregate).count();
        let (of_cells, joined_pairs) = (mesh.phase.clone(), mesh.owners(are_stiff(&mesh.phase)).pairs().len());
        let mut phases = Self { of_cells, joined_pairs, parted_cells: 0, aggregate_cells, smeared_cells: 0 };
        if joined == Joined::Mortar && joined_pairs > 0 {
            let cells = mesh.joining_cells();
            cells.iter().for_each(|&cell| phases.of_cells[cell] = Phase::Mortar);
            phases.parted_cells = cells.len();
        }
        let has_itz = mesh.phase.contains(&Phase::Itz) || !mesh.cohesive.is_empty();
        if itz == Itz::Smeared && !has_itz {
            phases.smear(mesh);
        }
        phases
    }

    /// Gives the ITZ's strength to mortar with a face whose nodes are all of one aggregate.
    fn smear(&mut self, mesh: &Mesh) {
        let owners = mesh.owners(are_stiff(&self.of_cells));
        for (cell, phase) in mesh.cells().zip(&mut self.of_cells) {
            let touches = |face: &&[usize]| {
                let owner = owners.last(cell[face[0]]);
                owner != Mesh::NO_AGGREGATE && face.iter().all(|&corner| owners.last(cell[corner]) == owner)
            };
            if *phase == Phase::Mortar && mesh.kind.faces().iter().any(touches) {
                *phase = Phase::Itz;
                self.smeared_cells += 1;
            }
        }
    }
}

/// Cells of elastic bodies, by their numbers.
fn are_stiff(phases: &[Phase]) -> impl Fn(usize) -> bool {
    move |cell| matches!(phases[cell], Phase::Aggregate | Phase::Fibre)
}
