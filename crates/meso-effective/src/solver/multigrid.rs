//! A multigrid cycle over blocks of 2 x 2 x 2 voxels, in single precision: the preconditioner.
//!
//! A coarse link has the sum of the fine links between two blocks, halved where the blocks' distance has doubled. Potentials
//! are constant within a block, so a gap keeps its links on every level, and closed voxels stay closed. Smoothing is
//! Jacobi's, two sweeps with Chebyshev's weights, mirrored after the correction. Each coarse level takes two steps of
//! conjugate gradients, so the cycle is no fixed matrix: the caller's gradients must be flexible.

use super::stencil::{add, dot, layers_mut};
use crate::links::Links;

/// Chebyshev's weights for the eigenvalues 0.5 to 2 of the scaled matrix.
const WEIGHTS: [f32; 2] = [0.562, 1.392];
/// A level of so few voxels is the last.
const FEW: usize = 64;
/// Sweeps on the last level.
const LAST: usize = 16;

/// The levels under the links that are solved for.
pub(crate) struct Multigrid {
    levels: Vec<Level>,
}

struct Level {
    /// Links of the level below; none of the last one.
    coarse: Option<Links>,
    rhs: Vec<f32>,
    x: Vec<f32>,
    next: Vec<f32>,
}

impl Multigrid {
    pub(crate) fn new(links: &Links) -> Self {
        let mut levels = vec![Level::new(links)];
        while let Some(last) = levels.last().and_then(|level| level.coarse.as_ref()) {
            let level = Level::new(last);
            levels.push(level);
        }
        Self { levels }
    }

    /// One cycle for the residual `r`; returns the correction and its product with `r`.
    pub(crate) fn cycle(&mut self, links: &Links, r: &[f64]) -> (&[f32], f64) {
        let fine = &mut self.levels[0];
        layers_mut(&mut fine.rhs, links.layer_len(), |k, rhs| {
            let r = &r[k * links.layer_len()..][..rhs.len()];
            rhs.iter_mut().zip(r).for_each(|(to, from)| *to = *from as f32);
        });
        cycle(links, &mut self.levels);
        let z = &self.levels[0].x;
        (z, dot(r, z, links.layer_len()))
    }
}

impl Level {
    fn new(links: &Links) -> Self {
        let zeros = || vec![0.0; links.len()];
        let coarse = (links.len() > FEW).then(|| links.coarse());
        Self { coarse, rhs: zeros(), x: zeros(), next: zeros() }
    }

    /// Smooths by one sweep; the first sweep from zero needs no fluxes.
    fn sweep(&mut self, links: &Links, weight: f32, from_zero: bool) {
        let (x, rhs, len) = (&self.x, &self.rhs, links.layer_len());
        layers_mut(&mut self.next, len, |k, next| {
            let (x_layer, rhs) = (&x[k * len..][..len], &rhs[k * len..][..len]);
            links.fluxes(x, k, |at, flux, links| {
                let (start, flux) = if from_zero { (0.0, 0.0) } else { (x_layer[at], flux) };
                let over = if links > 0.0 { weight / links } else { 0.0 };
                next[at] = start + over * (rhs[at] - flux);
            });
        });
        std::mem::swap(&mut self.x, &mut self.next);
    }

    /// Sums of the residual over blocks.
    fn restrict(&self, links: &Links, coarse: &Links, into: &mut [f32]) {
        let [nx, _, nz] = links.counts;
        let (steps, len) = (links.steps(), links.layer_len());
        let [cx, ..] = coarse.counts;
        layers_mut(into, coarse.layer_len(), |layer, into| {
            into.fill(0.0);
            for k in layer * steps[2]..nz.min((layer + 1) * steps[2]) {
                let rhs = &self.rhs[k * len..][..len];
                let mut residual = vec![0.0; len];
                links.fluxes(&self.x, k, |at, flux, _| residual[at] = rhs[at] - flux);
                for (j, row) in residual.chunks(nx).enumerate() {
                    let into = &mut into[j / steps[1] * cx..][..cx];
                    for (sum, block) in into.iter_mut().zip(row.chunks(steps[0])) {
                        *sum += block.iter().sum::<f32>();
                    }
                }
            }
        });
    }

    /// Adds the blocks' corrections.
    fn correct(&mut self, links: &Links, coarse: &Links, correction: &[f32]) {
        let (steps, nx) = (links.steps(), links.counts[0]);
        let [cx, ..] = coarse.counts;
        layers_mut(&mut self.x, links.layer_len(), |k, x| {
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

/// A cycle on the first of `levels`, from zero.
fn cycle(links: &Links, levels: &mut [Level]) {
    let Some((level, lower)) = levels.split_first_mut() else { return };
    let Some(coarse) = level.coarse.take() else {
        (0..LAST).for_each(|sweep| level.sweep(links, WEIGHTS[sweep % 2], sweep == 0));
        (0..LAST).for_each(|sweep| level.sweep(links, WEIGHTS[1 - sweep % 2], false));
        return;
    };
    level.sweep(links, WEIGHTS[0], true);
    level.sweep(links, WEIGHTS[1], false);
    level.restrict(links, &coarse, &mut lower[0].rhs);
    twice(&coarse, lower);
    level.correct(links, &coarse, &lower[0].x);
    level.sweep(links, WEIGHTS[1], false);
    level.sweep(links, WEIGHTS[0], false);
    level.coarse = Some(coarse);
}

/// Two steps of conjugate gradients on the first of `levels`, each with a cycle (Notay, Electron. Trans. Numer. Anal. 37,
/// 2010, 123, algorithm 3.2). The steps scale what the constant blocks get wrong.
fn twice(links: &Links, levels: &mut [Level]) {
    let len = links.layer_len();
    cycle(links, levels);
    let level = &mut levels[0];
    let first = level.x.clone();
    let mut product = vec![0.0; first.len()];
    let rho = links.apply(&first, &mut product);
    let step = if rho > 0.0 { dot(&first, &level.rhs, len) / rho } else { 0.0 };
    add(&mut level.rhs, -step as f32, &product, len);
    cycle(links, levels);
    let level = &mut levels[0];
    let gamma = dot(&level.x, &product, len);
    let alpha = dot(&level.x, &level.rhs, len);
    let rest = links.apply(&level.x, &mut product) - if rho > 0.0 { gamma * gamma / rho } else { 0.0 };
    let second = if rest > 0.0 { alpha / rest } else { 0.0 };
    let first_step = if rho > 0.0 { step - gamma * second / rho } else { 0.0 };
    layers_mut(&mut level.x, len, |k, x| {
        let first = &first[k * len..][..x.len()];
        x.iter_mut().zip(first).for_each(|(x, first)| *x = second as f32 * *x + first_step as f32 * first);
    });
}

impl Links {
    /// Voxels along each axis that make a block.
    fn steps(&self) -> [usize; 3] {
        self.counts.map(|count| if count > 1 { 2 } else { 1 })
    }

    /// The links between blocks.
    fn coarse(&self) -> Self {
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
