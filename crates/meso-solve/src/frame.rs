//! The fields of a moment, computed on demand.

use crate::block::{Block, Cells, Common, EMPTY, Group, Scratch};
use crate::lanes::{Eight, LANES, Lanes, Task, Vectors};
use crate::law::{Law, Tensor};
use crate::matter::LawTask;
use crate::plates::Plates;
use crate::run::Run;
use meso_core::mesh::{Mesh, Phase};
use rayon::prelude::*;

/// A moment of a test.
pub struct Frame<'a> {
    run: &'a Run<'a>,
    number: u32,
}

/// The state of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// xx yy zz xy yz zx, MPa; tension is positive.
    pub stress: [f32; 6],
    /// 1 less the share of the stiffness that is left.
    pub damage: f32,
    /// Damage in tension, 0 to 1.
    pub tension: f32,
    /// Damage in compression, 0 to 1.
    pub compression: f32,
    /// Opening of its crack, mm.
    pub opening_mm: f32,
    /// Energy per volume that unloading would give back, N/mm2.
    pub stored: f32,
}

impl<'a> Frame<'a> {
    pub(crate) fn new(run: &'a Run<'a>, number: u32) -> Self {
        Self { run, number }
    }

    /// From 1 to the test's number of frames.
    pub fn number(&self) -> u32 {
        self.number
    }

    /// Mean axial strain, positive in the test's sense.
    pub fn strain(&self) -> f64 {
        self.run.state.travel.abs() / self.run.outline.height_mm
    }

    /// Stress of the latest row, MPa.
    pub fn stress_mpa(&self) -> f64 {
        self.run.state.rows.last().map_or(0.0, |row| row.stress_mpa)
    }

    /// s.
    pub fn time_s(&self) -> f64 {
        self.run.state.time
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        self.run.sample.mesh
    }

    /// The phase that every cell has in the test.
    pub fn phases(&self) -> &[Phase] {
        self.run.phases()
    }

    /// Displacements of the mesh's nodes, mm; the lower plate rests.
    pub fn displacement(&self) -> Vec<[f32; 3]> {
        let lower = -Plates::share(self.run.state.travel);
        let mut moved = vec![[0.0; 3]; self.run.order.len()];
        for (u, &node) in self.run.nodes.displacement.iter().zip(&self.run.order) {
            moved[node as usize] = [u[0], u[1], u[2] - lower].map(|x| x as f32);
        }
        moved
    }

    /// `of` every cell of the mesh, in the mesh's order.
    pub fn cells<T: Copy + Default + Send>(&self, of: impl Fn(&Point) -> T + Sync) -> Vec<T> {
        let mut all = vec![T::default(); self.mesh().cell_count()];
        let (common, displacement) = (&self.run.common, &self.run.nodes.displacement[..]);
        // A few blocks at a time, so that little is held twice.
        for blocks in self.run.blocks.chunks(64) {
            let probe = |block: &Block| {
                let points = self.run.set.run(Probe { block, common, displacement });
                points.into_iter().map(|(cell, point)| (cell, of(&point))).collect::<Vec<_>>()
            };
            let parts: Vec<Vec<(u32, T)>> = blocks.par_iter().map(probe).collect();
            parts.into_iter().flatten().for_each(|(cell, x)| all[cell as usize] = x);
        }
        all
    }
}

/// Asks the cells of a block.
struct Probe<'a> {
    block: &'a Block,
    common: &'a Common,
    displacement: &'a [[f64; 3]],
}

impl Task for Probe<'_> {
    type Output = Vec<(u32, Point)>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { block, common, displacement } = self;
        let mut scratch = Scratch::new();
        scratch.take_in(block, displacement);
        let mut points = Vec::new();
        for group in &block.groups {
            let matter = &common.matter[group.phase as usize];
            points.extend(matter.law::<L, _>(GroupProbe { group, common, u: &scratch.u }));
        }
        points
    }
}

struct GroupProbe<'a> {
    group: &'a Group,
    common: &'a Common,
    u: &'a Vectors,
}

impl LawTask for GroupProbe<'_> {
    type Output = Vec<(u32, Point)>;

    #[inline(always)]
    fn run<L: Lanes, W: Law<L>>(self, law: &W) -> Self::Output {
        let Self { group, common, u } = self;
        let strains: Vec<(Tensor<L>, L)> = match &group.cells {
            Cells::Tets(cells) => cells.iter().map(|cells| (cells.strain(u), L::load(&cells.width))).collect(),
            Cells::Hexes(cells) => {
                cells.iter().map(|cells| (cells.strain(u, &common.shape).0, L::splat(common.band_mm))).collect()
            }
            Cells::Triangles(_) | Cells::Quads(_) => Vec::new(),
        };
        let remembered = group.memory.len() / strains.len().max(1);
        let mut points = Vec::with_capacity(strains.len() * LANES);
        for (i, (strain, width)) in strains.iter().enumerate() {
            let memory = &group.memory[i * remembered..(i + 1) * remembered];
            let eight = answer(law, strain, *width, memory);
            let numbers = group.numbers[i * LANES..][..LANES].iter().zip(eight);
            points.extend(numbers.filter(|(number, _)| **number != EMPTY).map(|(&number, point)| (number, point)));
        }
        points
    }
}

#[inline(always)]
fn answer<L: Lanes, W: Law<L>>(law: &W, strain: &Tensor<L>, width: L, memory: &[Eight]) -> [Point; LANES] {
    let mut history = crate::block::history::<L, W>(memory);
    let response = law.stress(strain, &mut history, width);
    let state = law.state(strain, &history, width);
    let stress = response.stress.map(L::eight);
    let [damage, tension, compression, opening, stored] =
        [L::splat(1.0) - response.integrity, state.tension, state.compression, state.opening, state.stored]
            .map(L::eight);
    std::array::from_fn(|lane| Point {
        stress: stress.map(|s| s.0[lane]),
        damage: damage.0[lane],
        tension: tension.0[lane],
        compression: compression.0[lane],
        opening_mm: opening.0[lane],
        stored: stored.0[lane],
    })
}
