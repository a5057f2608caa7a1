//! Blocks of 2 x 2 x 2 voxels as the groups of a coarse level.
//!
//! A coarse link has the sum of the fine links between two blocks, halved where the blocks' distance has doubled. A gap keeps its
//! links on every level, and closed voxels stay closed.

use super::network::Network;
use super::stencil::{Real, layers_mut};
use crate::links::Links;

/// A level of so few voxels is the last.
const FEWEST: usize = 64;

impl Network for Links {
    fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn layer_len(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    #[inline]
    fn fluxes<T: Real>(&self, u: &[T], k: usize, mut visit: impl FnMut(usize, T, f32)) {
        let [nx, ny, _] = self.counts;
        let outside = vec![T::default(); nx];
        for j in 0..ny {
            self.row(u, &outside, j, k).fluxes(|i, flux, links| visit(j * nx + i, flux, links));
        }
    }

    fn coarse(&self) -> Option<Self> {
        (self.len() > FEWEST).then(|| self.of_blocks())
    }

    fn restrict(&self, coarse: &Self, x: &[f32], rhs: &[f32], into: &mut [f32]) {
        let [nx, _, nz] = self.counts;
        let (steps, len) = (self.steps(), self.layer_len());
        let [cx, ..] = coarse.counts;
        layers_mut(into, coarse.layer_len(), |layer, into| {
            into.fill(0.0);
            for k in layer * steps[2]..nz.min((layer + 1) * steps[2]) {
                let rhs = &rhs[k * len..][..len];
                let mut residual = vec![0.0; len];
                self.fluxes(x, k, |at, flux, _| residual[at] = rhs[at] - flux);
                for (j, row) in residual.chunks(nx).enumerate() {
                    let into = &mut into[j / steps[1] * cx..][..cx];
                    for (sum, block) in into.iter_mut().zip(row.chunks(steps[0])) {
                        *sum += block.iter().sum::<f32>();
                    }
                }
            }
        });
    }

    fn correct(&self, coarse: &Self, x: &mut [f32], correction: &[f32]) {
        let (steps, nx) = (self.steps(), self.counts[0]);
        let [cx, ..] = coarse.counts;
        layers_mut(x, self.layer_len(), |k, x| {
            let from = &correction[k / steps[2] * coarse.layer_len()..][..coarse.layer_len()];
            for (j, row) in x.chunks_mut(nx).enumerate() {
                let from = &from[j / steps[1] * cx..][..cx];
                for (block, correction) in row.chunks_mut(steps[0]).zip(from) {
                    block.iter_mut().for_each(|x| *x += correction);
                }
            }
        });
    }
}

impl Links {
    /// Voxels along each axis that make a block.
    fn steps(&self) -> [usize; 3] {
        self.counts.map(|count| if count > 1 { 2 } else { 1 })
    }

    /// The links between blocks.
    fn of_blocks(&self) -> Self {
        let steps = self.steps();
        let counts = [0, 1, 2].map(|axis| self.counts[axis].div_ceil(steps[axis]));
        let across = [0, 1, 2].map(|axis| self.coarse_along(axis, steps, counts));
        Self { counts, wraps: self.wraps, across }
    }

    fn coarse_along(&self, axis: usize, steps: [usize; 3], counts: [usize; 3]) -> Vec<f32> {
        let [nx, ny, nz] = self.counts;
        let [cx, cy, cz] = counts;
        let layers = cz + usize::from(axis == 2);
        let weight = 1.0 / steps[axis] as f32;
        let mut links = vec![0.0; cx * cy * layers];
        // Only the first link of a block leads out of it; the last layer of z is that above the last voxels.
        let range = |a: usize, block: usize, count: usize| {
            let first = (block * steps[a]).min(count);
            if a == axis { first..first + 1 } else { first..count.min(first + steps[a]) }
        };
        layers_mut(&mut links, cx * cy, |layer, links| {
            for (number, link) in links.iter_mut().enumerate() {
                let (i, j) = (number % cx, number / cx);
                let mut sum = 0.0;
                for k in range(2, layer, nz) {
                    for j in range(1, j, ny) {
                        let row = &self.across[axis][(k * ny + j) * nx..][..nx];
                        sum += row[range(0, i, nx)].iter().sum::<f32>();
                    }
                }
                *link = sum * weight;
            }
        });
        links
    }
}
