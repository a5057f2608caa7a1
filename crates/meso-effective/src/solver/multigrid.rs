//! A multigrid cycle over groups of unknowns, in single precision: the preconditioner.
//!
//! Potentials are constant within a group. Smoothing is Jacobi's, two sweeps with Chebyshev's weights, mirrored after the
//! correction. Each coarse level takes two steps of conjugate gradients, so the cycle is no fixed matrix: the caller's
//! gradients must be flexible.

use super::network::Network;
use super::stencil::{add, dot, dots, layers_mut};

/// Chebyshev's weights for the eigenvalues 0.5 to 2 of the scaled matrix.
const WEIGHTS: [f32; 2] = [0.562, 1.392];
/// A second step with less of its energy off the first one's direction is rounding.
const PARALLEL: f64 = 1e-6;
/// Sweeps on the last level.
const LAST: usize = 16;

/// The levels under the links that are solved for.
pub(crate) struct Multigrid<N> {
    levels: Vec<GridLevel<N>>,
}

struct GridLevel<N> {
    /// Links of the level below; none of the last one.
    coarse: Option<N>,
    /// One over the scales.
    over: Vec<f32>,
    x: Vec<f32>,
    next: Vec<f32>,
    /// Vectors of the two steps; the first level has none.
    steps: Steps,
}

#[derive(Default)]
struct Steps {
    rhs: Vec<f32>,
    first: Vec<f32>,
    product: Vec<f32>,
}

impl<N: Network> Multigrid<N> {
    pub(crate) fn new(links: &N) -> Self {
        let mut levels = vec![GridLevel::new(links, 0)];
        while let Some(last) = levels.last().and_then(|level| level.coarse.as_ref()) {
            let level = GridLevel::new(last, last.len());
            levels.push(level);
        }
        Self { levels }
    }

    /// The correction of one cycle for the residual `r`.
    pub(crate) fn cycle(&mut self, links: &N, r: &[f32]) -> &[f32] {
        cycle(links, r, &mut self.levels);
        &self.levels[0].x
    }
}

impl<N: Network> GridLevel<N> {
    fn new(links: &N, stepped: usize) -> Self {
        let zeros = |len: usize| vec![0.0; len];
        let steps = Steps { rhs: zeros(stepped), first: zeros(stepped), product: zeros(stepped) };
        let (coarse, over) = (links.coarse(), links.over_scales());
        Self { coarse, over, x: zeros(links.len()), next: zeros(links.len()), steps }
    }

    /// A sweep from zero, which needs no fluxes.
    fn first_sweep(&mut self, rhs: &[f32], weight: f32, len: usize) {
        let over = &self.over;
        layers_mut(&mut self.x, len, |k, x| {
            let given = rhs[k * len..].iter().zip(&over[k * len..]);
            x.iter_mut().zip(given).for_each(|(x, (rhs, over))| *x = weight * over * rhs);
        });
    }

    fn sweep(&mut self, links: &N, rhs: &[f32], weight: f32) {
        links.sweep(&self.x, rhs, &self.over, weight, &mut self.next);
        std::mem::swap(&mut self.x, &mut self.next);
    }
}

/// A cycle on the first of `levels`, from zero.
fn cycle<N: Network>(links: &N, rhs: &[f32], levels: &mut [GridLevel<N>]) {
    let Some((level, lower)) = levels.split_first_mut() else { return };
    level.first_sweep(rhs, WEIGHTS[0], links.layer_len());
    let Some(coarse) = level.coarse.take() else {
        (1..LAST).for_each(|sweep| level.sweep(links, rhs, WEIGHTS[sweep % 2]));
        (0..LAST).for_each(|sweep| level.sweep(links, rhs, WEIGHTS[1 - sweep % 2]));
        return;
    };
    level.sweep(links, rhs, WEIGHTS[1]);
    links.restrict(&coarse, &level.x, rhs, &mut lower[0].steps.rhs);
    twice(&coarse, lower);
    links.correct(&coarse, &mut level.x, &lower[0].x);
    level.sweep(links, rhs, WEIGHTS[1]);
    level.sweep(links, rhs, WEIGHTS[0]);
    level.coarse = Some(coarse);
}

/// Two steps of conjugate gradients on the first of `levels`, each with a cycle (Notay, Electron. Trans. Numer. Anal. 37,
/// 2010, 123, algorithm 3.2). The steps scale what the constant groups get wrong.
fn twice<N: Network>(links: &N, levels: &mut [GridLevel<N>]) {
    let len = links.layer_len();
    let Steps { mut rhs, mut first, mut product } = std::mem::take(&mut levels[0].steps);
    cycle(links, &rhs, levels);
    std::mem::swap(&mut first, &mut levels[0].x);
    let rho = links.apply(&first, &mut product);
    let step = if rho > 0.0 { dot(&first, &rhs, len) / rho } else { 0.0 };
    add(&mut rhs, -step, &product, len);
    cycle(links, &rhs, levels);
    let GridLevel { x, next, .. } = &mut levels[0];
    let [gamma, alpha] = dots([&product, &rhs], x, len);
    let own = links.apply(x, next);
    let rest = own - if rho > 0.0 { gamma * gamma / rho } else { 0.0 };
    let second = if rest > PARALLEL * own { alpha / rest } else { 0.0 };
    let first_step = if rho > 0.0 { step - gamma * second / rho } else { 0.0 };
    layers_mut(x, len, |k, x| {
        let first = &first[k * len..][..x.len()];
        x.iter_mut().zip(first).for_each(|(x, first)| *x = second as f32 * *x + first_step as f32 * first);
    });
    levels[0].steps = Steps { rhs, first, product };
}
