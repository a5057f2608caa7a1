//! Strain smoothing: the strains of mortar and ITZ belong to edges instead of tetrahedra.
//!
//! Edge-based smoothed finite elements (Liu, Nguyen-Thoi and Lam 2009, J. Sound Vib. 320, 1100; in three dimensions Cazes
//! and Meschke 2013, Int. J. Numer. Meth. Engng 94). Every edge takes a sixth of each tetrahedron around it: its
//! *patch*. The mean of their strains by volume is the strain of the patch. Linear tetrahedra that flow between stiff
//! grains are too strong, and patches much less so (docs/engine.md).

use crate::element::tet::{Shape, corners};
use meso_core::math::{Mat3, Vec3};
use meso_core::mesh::{Mesh, Phase};
use rayon::prelude::*;

/// Edges of a tetrahedron: the number of patches that have a cell.
pub(crate) const EDGES: usize = 6;
/// Width of a crack band of patches over that of their tetrahedra: with the same width, weak bands one and three elements
/// wide spend 1.30 to 1.37 of their energy, at 1.5, 2 and 3 mm.
pub(crate) const BAND: f64 = 1.35;
/// Nodes of a patch, at most.
pub(crate) const MOST_NODES: usize = 12;
/// Tetrahedra of a patch, at most, where all of those around the edge are in it: neighbours, which share nodes.
const MOST_CELLS: usize = 9;
/// Tetrahedra of each part, where there are more: they need not be neighbours.
const MOST_APART: usize = 5;
/// Nodes whose edges go together.
const RUN: usize = 4096;

/// The patches of a mesh: one per edge, or one per edge and phase where mortar and ITZ differ in stiffness.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patches {
    /// Where each patch's cells begin in `cells`, and their end.
    first: Vec<u32>,
    cells: Vec<u32>,
    /// The phase whose law each patch has.
    pub(crate) phase: Vec<Phase>,
}

/// The shape of a patch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    /// The mesh's numbers.
    pub(crate) nodes: Vec<u32>,
    /// Mean gradient of each node's shape function, 1/mm; they add up to zero.
    pub(crate) gradients: Vec<Vec3>,
    /// Share of each node in the mass.
    pub(crate) shares: Vec<f64>,
    /// mm3.
    pub(crate) volume: f64,
}

/// A mesh, the phases of its cells in the test, and the engine's numbers of its nodes.
#[derive(Clone, Copy)]
pub(crate) struct Numbered<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) phases: &'a [Phase],
    /// The engine's number of every node.
    pub(crate) number: &'a [u32],
}

impl Patches {
    /// Whether the strains of `phase` are smoothed.
    pub(crate) fn take(phase: Phase) -> bool {
        matches!(phase, Phase::Mortar | Phase::Itz)
    }

    /// Those around the edges from every node, in the order of `nodes`, to nodes of higher numbers. Where they may be
    /// `mixed`, a patch has cells of mortar and ITZ, and the law of the phase that fills most of it.
    pub(crate) fn of(numbered: Numbered, nodes: &[u32], mixed: bool) -> Self {
        let around = Around::of(&numbered);
        let of_run = |run: &[u32]| {
            let mut own = Self::default();
            run.iter().for_each(|&node| own.add(numbered, node, around.cells(node), mixed));
            own
        };
        let runs: Vec<Self> = nodes.par_chunks(RUN).map(of_run).collect();
        let mut all = Self::default();
        for run in runs {
            let start = all.cells.len() as u32;
            all.first.extend(run.first.iter().map(|first| start + first));
            all.cells.extend(run.cells);
            all.phase.extend(run.phase);
        }
        all.first.push(all.cells.len() as u32);
        all
    }

    /// Adds those from `node`, which the cells `around` have.
    fn add(&mut self, numbered: Numbered, node: u32, around: &[u32], mixed: bool) {
        let Numbered { mesh, phases, number } = numbered;
        let own = number[node as usize];
        let mut edges: Vec<(u32, u8, u32)> = Vec::new();
        for &cell in around {
            let class = if mixed { 0 } else { phases[cell as usize] as u8 };
            let others = mesh.cell(cell as usize).iter().map(|&other| number[other as usize]);
            edges.extend(others.filter(|&other| other > own).map(|other| (other, class, cell)));
        }
        edges.sort_unstable();
        for edge in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            let most = if edge.len() > MOST_CELLS { MOST_APART } else { MOST_CELLS };
            for part in edge.chunks(most) {
                self.first.push(self.cells.len() as u32);
                let start = self.cells.len();
                self.cells.extend(part.iter().map(|&(.., cell)| cell));
                self.phase.push(fills_most(mesh, phases, &self.cells[start..]));
            }
        }
    }

    /// Number of patches.
    pub(crate) fn len(&self) -> usize {
        self.phase.len()
    }

    /// Cells of a patch.
    pub(crate) fn cells(&self, patch: u32) -> &[u32] {
        let [start, end] = [0, 1].map(|next| self.first[patch as usize + next] as usize);
        &self.cells[start..end]
    }

    /// Bytes that they hold.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(&*self.first) + size_of_val(&*self.cells) + size_of_val(&*self.phase)
    }

    /// The shape of a patch.
    pub(crate) fn patch(&self, mesh: &Mesh, patch: u32) -> Patch {
        let mut found = Patch::default();
        self.cells(patch)
            .iter()
            .for_each(|&cell| found.add(mesh.cell(cell as usize), &Shape::of(&corners(mesh, cell))));
        found.gradients.iter_mut().for_each(|gradient| *gradient /= found.volume);
        found.shares.iter_mut().for_each(|share| *share /= found.volume);
        found
    }

    /// Mean volume of a patch's cells, mm3.
    pub(crate) fn mean_cell_mm3(&self, patch: u32, volume: f64) -> f64 {
        EDGES as f64 * volume / self.cells(patch).len() as f64
    }
}

impl Patch {
    /// Adds a sixth of a cell; gradients and shares are still times the volume.
    fn add(&mut self, nodes: &[u32], shape: &Shape) {
        let volume = shape.volume / EDGES as f64;
        self.volume += volume;
        for (&node, gradient) in nodes.iter().zip(shape.all_gradients()) {
            let place = self.nodes.iter().position(|&other| other == node).unwrap_or(self.nodes.len());
            if place == self.nodes.len() {
                self.nodes.push(node);
                self.gradients.push(Vec3::zeros());
                self.shares.push(0.0);
            }
            self.gradients[place] += volume * gradient;
            self.shares[place] += volume / nodes.len() as f64;
        }
    }

    /// sum g_a g_a^T over the nodes' shares in the mass, 1/mm2.
    pub(crate) fn metric(&self) -> Mat3 {
        self.gradients.iter().zip(&self.shares).map(|(g, share)| g * g.transpose() / *share).sum()
    }
}

/// The phase that fills most of some cells; mortar where both fill a half.
fn fills_most(mesh: &Mesh, phases: &[Phase], cells: &[u32]) -> Phase {
    let is_itz = |cell: u32| phases[cell as usize] == Phase::Itz;
    let mut balance = 0.0;
    for &cell in cells {
        let volume = Shape::of(&corners(mesh, cell)).volume;
        balance += if is_itz(cell) { volume } else { -volume };
    }
    if balance > 0.0 { Phase::Itz } else { Phase::Mortar }
}

/// The smoothed cells around every node.
struct Around {
    first: Vec<u32>,
    cells: Vec<u32>,
}

impl Around {
    fn of(numbered: &Numbered) -> Self {
        let Numbered { mesh, phases, .. } = numbered;
        let smoothed = || (0..).zip(mesh.cells()).filter(|(cell, _)| Patches::take(phases[*cell as usize]));
        let mut first = vec![0_u32; mesh.points.len() + 1];
        smoothed().for_each(|(_, nodes): (u32, _)| nodes.iter().for_each(|&node| first[node as usize + 1] += 1));
        (1..first.len()).for_each(|node| first[node] += first[node - 1]);
        let mut next = first.clone();
        let mut cells = vec![0; first[mesh.points.len()] as usize];
        for (cell, nodes) in smoothed() {
            for &node in nodes {
                let next = &mut next[node as usize];
                cells[*next as usize] = cell;
                *next += 1;
            }
        }
        Self { first, cells }
    }

    fn cells(&self, node: u32) -> &[u32] {
        &self.cells[self.first[node as usize] as usize..self.first[node as usize + 1] as usize]
    }
}
