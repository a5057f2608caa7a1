//! The fields of a moment, computed on demand.

use crate::block::matter::LawTask;
use crate::block::{Block, Cells, Common, EMPTY, Group, Scratch, without};
use crate::element::uniform::Uniform;
use crate::lanes::{Eight, LANES, Lanes, Task, Vectors};
use crate::law::{Law, Tensor};
use crate::march::run::Run;
use meso_mesh::Mesh;
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
        self.run.state.travel.abs() / self.run.supports.length_mm
    }

    /// Stress of the latest row, MPa.
    pub fn stress_mpa(&self) -> f64 {
        self.run.state.rows.last().map_or(0.0, |row| row.stress_mpa)
    }

    /// s.
    pub fn time_s(&self) -> f64 {
        self.run.state.time
    }

    /// Values of the gauges at this moment, by the first columns of [`Extra`](crate::Extra).
    pub fn gauges(&self) -> Vec<f64> {
        self.run.gauges.iter().map(|gauge| gauge.read(&self.run.nodes.displacement)).collect()
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh {
        self.run.sample.mesh
    }

    /// Displacements of the mesh's nodes, mm; the lower plate rests.
    pub fn displacement(&self) -> Vec<[f32; 3]> {
        let rest = self.run.rest();
        let mut moved = vec![[0.0; 3]; self.run.order.len()];
        for (u, &node) in self.run.nodes.displacement.iter().zip(&self.run.order) {
            moved[node as usize] = [0, 1, 2].map(|k| (u[k] - rest[k]) as f32);
        }
        moved
    }

    /// `of` every cell of the mesh, in the mesh's order; smoothed cells have the mean of their patches.
    pub fn cells<T: Mean>(&self, of: impl Fn(&Point) -> T + Sync) -> Vec<T> {
        let mut all = vec![T::default(); self.mesh().cell_count()];
        let (common, displacement) = (&self.run.common, &self.run.nodes.displacement[..]);
        // A few blocks at a time, so that little is held twice.
        for blocks in self.run.blocks.chunks(64) {
            let probe = |block: &Block| {
                let points = self.run.set.run(Probe { block, common, displacement });
                points.into_iter().map(|(element, point)| (element, of(&point))).collect::<Vec<_>>()
            };
            let parts: Vec<Vec<(Element, T)>> = blocks.par_iter().map(probe).collect();
            for (element, x) in parts.iter().flatten() {
                match element {
                    Element::Cell(cell) => all[*cell as usize] = *x,
                    Element::Patch(patch) => {
                        let patches =
                            self.run.patches.as_ref().expect("patches have elements where strains are smoothed");
                        for &cell in patches.cells(*patch) {
                            all[cell as usize].add(x, patches.part(cell) as f32);
                        }
                    }
                }
            }
        }
        all
    }
}

/// Values that have a mean.
pub trait Mean: Copy + Default + Send + Sync {
    /// Adds a share of another one.
    fn add(&mut self, other: &Self, share: f32);
}

impl Mean for f32 {
    fn add(&mut self, other: &Self, share: f32) {
        *self += share * other;
    }
}

impl Mean for [f32; 6] {
    fn add(&mut self, other: &Self, share: f32) {
        self.iter_mut().zip(other).for_each(|(own, x)| *own += share * x);
    }
}

impl Mean for Point {
    fn add(&mut self, other: &Self, share: f32) {
        self.stress.add(&other.stress, share);
        self.damage.add(&other.damage, share);
        self.tension.add(&other.tension, share);
        self.compression.add(&other.compression, share);
        self.opening_mm.add(&other.opening_mm, share);
        self.stored.add(&other.stored, share);
    }
}

/// The cell or patch of a point, by its number.
#[derive(Clone, Copy, Debug)]
enum Element {
    Cell(u32),
    Patch(u32),
}

/// Asks the elements of a block.
struct Probe<'a> {
    block: &'a Block,
    common: &'a Common,
    displacement: &'a [[f64; 3]],
}

impl Task for Probe<'_> {
    type Output = Vec<(Element, Point)>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { block, common, displacement } = self;
        let mut scratch = Scratch::new();
        scratch.take_in(block, displacement, common.free.as_ref());
        let mut points = Vec::new();
        for group in &block.groups {
            let matter = &common.matter[usize::from(group.matter)];
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

impl<L: Lanes> LawTask<L> for GroupProbe<'_> {
    type Output = Vec<(Element, Point)>;

    #[inline(always)]
    fn run<W: Law<L>>(self, law: &W) -> Self::Output {
        let Self { group, common, u } = self;
        let strains: Vec<(Tensor<L>, L)> = match &group.cells {
            Cells::Tets(cells) => strains(cells, u),
            Cells::Patches8(cells) => strains(cells, u),
            Cells::Patches9(cells) => strains(cells, u),
            Cells::Patches12(cells) => strains(cells, u),
            Cells::Hexes(cells) => {
                cells.iter().map(|cells| (cells.strain(u, &common.shape).0, L::splat(common.band_mm))).collect()
            }
            Cells::Triangles(_) | Cells::Quads(_) => Vec::new(),
        };
        let remembered = group.memory.len() / strains.len().max(1);
        let free = common.over(group.phase);
        let element = if group.cells.are_patches() { Element::Patch } else { Element::Cell };
        let mut points = Vec::with_capacity(strains.len() * LANES);
        for (i, (strain, width)) in strains.iter().enumerate() {
            let memory = &group.memory[i * remembered..(i + 1) * remembered];
            let eight = answer(law, &without(*strain, free), *width, memory);
            let numbers = group.numbers[i * LANES..][..LANES].iter().zip(eight);
            points.extend(
                numbers.filter(|(number, _)| **number != EMPTY).map(|(&number, point)| (element(number), point)),
            );
        }
        points
    }
}

/// Strains and widths of crack bands.
#[inline(always)]
fn strains<L: Lanes, const N: usize>(cells: &[Uniform<N>], u: &Vectors) -> Vec<(Tensor<L>, L)> {
    cells.iter().map(|cells| (cells.strain(u), L::load(&cells.width))).collect()
}

#[inline(always)]
fn answer<L: Lanes, W: Law<L>>(law: &W, strain: &Tensor<L>, width: L, memory: &[Eight]) -> [Point; LANES] {
    let mut history = crate::block::history::<L, W>(memory);
    let response = law.stress(strain, &mut history, width);
    let state = law.state(strain, &history, width);
    let stress = response.stress.map(L::eight);
    // Laws lose stiffness or strength.
    let weakened = L::splat(0.0).lt(state.weakened);
    let damage = L::select(weakened, state.weakened, L::splat(1.0) - response.integrity);
    let [damage, tension, compression, opening, stored] =
        [damage, state.tension, state.compression, state.opening, state.stored].map(L::eight);
    std::array::from_fn(|lane| Point {
        stress: stress.map(|s| s.0[lane]),
        damage: damage.0[lane],
        tension: tension.0[lane],
        compression: compression.0[lane],
        opening_mm: opening.0[lane],
        stored: stored.0[lane],
    })
}
