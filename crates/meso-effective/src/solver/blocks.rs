//! Blocks of 2 x 2 x 2 voxels as the groups of a coarse level.
//!
//! A coarse link has the sum of the fine links between two blocks, over the growth of the distance: half of it but at the last
//! block of an odd count, which is narrow. A gap keeps its links on every level, and closed voxels stay closed. Sweeps and
//! coarse levels ignore the coupling of links.

use super::network::{Network, over};
use super::stencil::{Layer, layers_mut, layers_mut_sum, product};
use crate::links::Links;
use meso_collision::simd::widest;
use std::borrow::Cow;

/// A level of so few voxels is the last.
const FEWEST: usize = 64;

impl Network for Links {
    fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn layer_len(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    fn apply(&self, u: &[f32], out: &mut [f32]) -> f64 {
        let len = self.layer_len();
        let [sum] = layers_mut_sum(out, len, |number, out| {
            let own = &u[number * len..][..len];
            widest(Layer { links: self, number, u, given: [], out: &mut *out, of: |_, _: [f32; 0], flux| flux });
            self.add_coupled(number, u, |at, flux| out[at] += flux);
            [product(own, out)]
        });
        sum
    }

    fn residual(&self, u: &[f64], rhs: &[f64], out: &mut [f32]) {
        let len = self.layer_len();
        layers_mut(out, len, |number, out| {
            let mut rhs = Cow::Borrowed(&rhs[number * len..][..len]);
            if self.is_coupled(number) {
                let rhs = rhs.to_mut();
                self.add_coupled(number, u, |at, flux| rhs[at] -= flux);
            }
            let given = [&rhs[..]];
            widest(Layer { links: self, number, u, given, out, of: |_, [rhs]: [f64; 1], flux| (rhs - flux) as f32 });
        });
    }

    fn over_scales(&self) -> Vec<f32> {
        let mut scales = vec![0.0; self.len()];
        layers_mut(&mut scales, self.layer_len(), |k, scales| {
            for (j, row) in scales.chunks_exact_mut(self.counts[0]).enumerate() {
                self.scales(j, k, row);
                row.iter_mut().for_each(|scale| *scale = over(*scale));
            }
        });
        scales
    }

    fn sweep(&self, x: &[f32], rhs: &[f32], over: &[f32], weight: f32, next: &mut [f32]) {
        let len = self.layer_len();
        layers_mut(next, len, |number, out| {
            let given = [rhs, over].map(|given| &given[number * len..][..len]);
            let of = |own, [rhs, over]: [f32; 2], flux| own + weight * over * (rhs - flux);
            widest(Layer { links: self, number, u: x, given, out, of });
        });
    }

    fn coarse(&self) -> Option<Self> {
        (self.len() > FEWEST).then(|| self.of_blocks())
    }

    fn restrict(&self, coarse: &Self, x: &[f32], rhs: &[f32], into: &mut [f32]) {
        let [nx, _, nz] = self.counts;
        let (steps, len, cx) = (self.steps(), self.layer_len(), coarse.counts[0]);
        layers_mut(into, coarse.layer_len(), |layer, into| {
            into.fill(0.0);
            let mut residual = vec![0.0; len];
            for number in layer * steps[2]..nz.min((layer + 1) * steps[2]) {
                let (given, out) = ([&rhs[number * len..][..len]], &mut residual[..]);
                widest(Layer { links: self, number, u: x, given, out, of: |_, [rhs]: [f32; 1], flux| rhs - flux });
                for (j, row) in residual.chunks_exact(nx).enumerate() {
                    let into = &mut into[j / steps[1] * cx..][..cx];
                    let (pairs, last) = row.as_chunks::<2>();
                    into.iter_mut().zip(pairs).for_each(|(sum, [a, b])| *sum += a + b);
                    into.last_mut().into_iter().zip(last).for_each(|(sum, last)| *sum += last);
                }
            }
        });
    }

    fn correct(&self, coarse: &Self, x: &mut [f32], correction: &[f32]) {
        let (steps, nx, cx) = (self.steps(), self.counts[0], coarse.counts[0]);
        layers_mut(x, self.layer_len(), |k, x| {
            let from = &correction[k / steps[2] * coarse.layer_len()..][..coarse.layer_len()];
            for (j, row) in x.chunks_exact_mut(nx).enumerate() {
                let from = &from[j / steps[1] * cx..][..cx];
                let (pairs, last) = row.as_chunks_mut::<2>();
                pairs.iter_mut().zip(from).for_each(|(pair, from)| *pair = pair.map(|x| x + from));
                last.iter_mut().zip(from.last()).for_each(|(x, from)| *x += from);
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
        let last = |axis: usize| match self.counts[axis] {
            1 => self.last[axis],
            count if count % 2 == 0 => (1.0 + self.last[axis]) / 2.0,
            _ => self.last[axis] / 2.0,
        };
        let counts = [0, 1, 2].map(|axis| self.counts[axis].div_ceil(steps[axis]));
        let mut coarse = Self { last: [0, 1, 2].map(last), ..Self::of(counts, self.wraps, Default::default()) };
        coarse.across = [0, 1, 2].map(|axis| self.coarse_along(axis, steps, &coarse));
        coarse
    }

    /// Length of the link below voxel `number` along an axis, over the width of all voxels but the last.
    fn length(&self, axis: usize, number: usize) -> f32 {
        let count = self.counts[axis];
        let width = |number: usize| if number + 1 == count { self.last[axis] } else { 1.0 };
        if axis == 2 && !self.wraps && number.is_multiple_of(count) {
            return width(number.min(count - 1)) / 2.0;
        }
        let number = number % count;
        let before = if number == 0 { count - 1 } else { number - 1 };
        (width(before) + width(number)) / 2.0
    }

    fn coarse_along(&self, axis: usize, steps: [usize; 3], coarse: &Self) -> Vec<f32> {
        let [nx, ny, nz] = self.counts;
        let [cx, cy, cz] = coarse.counts;
        // Lengths count in voxels of each level.
        let shorter = |block: usize| {
            let fine = self.length(axis, (block * steps[axis]).min(self.counts[axis]));
            fine / (steps[axis] as f32 * coarse.length(axis, block))
        };
        let shorter: Vec<f32> = (0..=coarse.counts[axis]).map(shorter).collect();
        let layers = cz + usize::from(axis == 2);
        let mut links = vec![0.0; cx * cy * layers];
        // Only the first link of a block leads out of it; the last layer of z is that above the last voxels.
        let range = |a: usize, block: usize, count: usize| {
            let first = (block * steps[a]).min(count);
            if a == axis { first..first + 1 } else { first..count.min(first + steps[a]) }
        };
        layers_mut(&mut links, cx * cy, |layer, links| {
            let mut sums = vec![0.0_f32; nx];
            for (j, links) in links.chunks_mut(cx).enumerate() {
                sums.fill(0.0);
                for k in range(2, layer, nz) {
                    for j in range(1, j, ny) {
                        let row = &self.across[axis][(k * ny + j) * nx..][..nx];
                        sums.iter_mut().zip(row).for_each(|(sum, link)| *sum += link);
                    }
                }
                let blocks = sums.chunks(steps[0]).enumerate();
                for (link, (i, block)) in links.iter_mut().zip(blocks) {
                    let sum = if axis == 0 { block[0] } else { block.iter().sum() };
                    *link = shorter[[i, j, layer][axis]] * sum;
                }
            }
        });
        links
    }
}
