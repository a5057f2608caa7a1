//! The fields of a moment, computed on demand.

use crate::march::run::{Run, SCRATCH};
use meso_element::block::Block;
use meso_element::block::probe::{Element, Point, Probe};
use meso_mesh::Mesh;
use rayon::prelude::*;

/// A moment of a test.
pub struct Frame<'a> {
    run: &'a Run<'a>,
    number: u32,
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

    /// Whether strengths scatter.
    pub(crate) fn is_scattered(&self) -> bool {
        self.run.scatter.is_some()
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
        self.visit(of, |cell, x, share| all[cell].take(x, share));
        all
    }

    /// Gives `of` every cell, with the cell's number; a smoothed cell is given each of its patches, with the patch's share.
    pub(crate) fn visit<T: Send>(&self, of: impl Fn(&Point) -> T + Sync, mut give: impl FnMut(usize, &T, Option<f32>)) {
        let (common, displacement, set) = (&self.run.common, &self.run.nodes.displacement[..], self.run.set);
        // A few blocks at a time, so that little is held twice.
        for blocks in self.run.blocks.chunks(64) {
            let probe = |block: &Block| {
                let points =
                    SCRATCH.with_borrow_mut(|scratch| set.probe(Probe { block, common, displacement, scratch }));
                points.into_iter().map(|(element, point)| (element, of(&point))).collect::<Vec<_>>()
            };
            let parts: Vec<Vec<(Element, T)>> = blocks.par_iter().map(probe).collect();
            for (element, x) in parts.iter().flatten() {
                match element {
                    Element::Cell(cell) => give(*cell as usize, x, None),
                    Element::Patch(patch) => {
                        let patches =
                            self.run.patches.as_ref().expect("patches have elements where strains are smoothed");
                        for &cell in patches.cells(*patch) {
                            give(cell as usize, x, Some(patches.part(cell) as f32));
                        }
                    }
                }
            }
        }
    }
}

/// Values that have a mean.
pub trait Mean: Copy + Default + Send + Sync {
    /// Adds a share of another one.
    fn add(&mut self, other: &Self, share: f32);

    /// Becomes another one, or adds a share of it.
    fn take(&mut self, other: &Self, share: Option<f32>) {
        match share {
            None => *self = *other,
            Some(share) => self.add(other, share),
        }
    }
}

impl Mean for f32 {
    fn add(&mut self, other: &Self, share: f32) {
        *self += share * other;
    }
}

impl<const N: usize> Mean for [f32; N]
where
    Self: Default,
{
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
        self.strength.add(&other.strength, share);
        self.stiffness_left.add(&other.stiffness_left, share);
        self.width_mm.add(&other.width_mm, share);
        self.plastic.add(&other.plastic, share);
    }
}
