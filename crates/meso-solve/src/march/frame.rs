//! The fields of a moment, computed on demand.

use crate::march::run::Run;
use meso_element::block::Block;
use meso_element::block::probe::{Element, Point};
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
                let points = self.run.set.probe(block, common, displacement);
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
