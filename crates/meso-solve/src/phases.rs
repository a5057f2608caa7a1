//! What every cell is made of in a test: joined aggregates are parted, and the ITZ is smeared where the mesh has none.

use crate::test::{Itz, Joined};
use meso_core::mesh::{Mesh, NO_AGGREGATE, Phase};

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
        let owners = Owners::of(mesh, &mesh.phase);
        let (of_cells, joined_pairs) = (mesh.phase.clone(), owners.pairs(mesh));
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
        let owners = Owners::of(mesh, &self.of_cells);
        for (cell, phase) in mesh.cells().zip(&mut self.of_cells) {
            let touches = |face: &&[usize]| {
                let owner = owners.aggregate(cell[face[0]]);
                owner != NO_AGGREGATE && face.iter().all(|&corner| owners.aggregate(cell[corner]) == owner)
            };
            if *phase == Phase::Mortar && mesh.kind.faces().iter().any(touches) {
                *phase = Phase::Itz;
                self.smeared_cells += 1;
            }
        }
    }
}

/// Which aggregates and fibres have cells at a node.
struct Owners {
    one: Vec<u32>,
    several: Vec<bool>,
}

impl Owners {
    fn of(mesh: &Mesh, phases: &[Phase]) -> Self {
        let mut owners = Self { one: vec![NO_AGGREGATE; mesh.points.len()], several: vec![false; mesh.points.len()] };
        for ((cell, &owner), _) in stiff(mesh, phases) {
            for &node in cell {
                let one = &mut owners.one[node as usize];
                owners.several[node as usize] |= *one != NO_AGGREGATE && *one != owner;
                *one = owner;
            }
        }
        owners
    }

    fn are_several(&self, node: u32) -> bool {
        self.several[node as usize]
    }

    fn aggregate(&self, node: u32) -> u32 {
        self.one[node as usize]
    }

    /// Pairs that share a node.
    fn pairs(&self, mesh: &Mesh) -> usize {
        let cells = stiff(mesh, &mesh.phase);
        let shared = cells.flat_map(|((cell, &owner), _)| cell.iter().map(move |&node| (node, owner)));
        let mut members: Vec<(u32, u32)> = shared.filter(|(node, _)| self.are_several(*node)).collect();
        members.sort_unstable();
        members.dedup();
        let at_node = members.chunk_by(|a, b| a.0 == b.0);
        let mut pairs: Vec<(u32, u32)> = at_node.flat_map(each_pair).collect();
        pairs.sort_unstable();
        pairs.dedup();
        pairs.len()
    }
}

fn each_pair(owners: &[(u32, u32)]) -> impl Iterator<Item = (u32, u32)> {
    owners.iter().enumerate().flat_map(|(i, higher)| owners[..i].iter().map(move |lower| (lower.1, higher.1)))
}

/// The cells of elastic bodies, with their bodies.
fn stiff<'a>(mesh: &'a Mesh, phases: &'a [Phase]) -> impl Iterator<Item = ((&'a [u32], &'a u32), &'a Phase)> {
    let bodies = |phase: &Phase| matches!(phase, Phase::Aggregate | Phase::Fibre);
    mesh.cells().zip(&mesh.aggregate).zip(phases).filter(move |(_, phase)| bodies(phase))
}
