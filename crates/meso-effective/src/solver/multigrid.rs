//! A multigrid cycle over groups of unknowns, in single precision: the preconditioner.
//!
//! Potentials are constant within a group. Smoothing is Jacobi's, two sweeps with Chebyshev's weights, mirrored after the
//! correction. Each coarse level takes two steps of conjugate gradients, so the cycle is no fixed matrix: the caller's
//! gradients must be flexible.

use super::network::Network;
use super::stencil::{add, dot, layers_mut};

/// Chebyshev's weights for the eigenvalues 0.5 to 2 of the scaled matrix.
const WEIGHTS: [f32; 2] = [0.562, 1.392];
/// A second step with less of its energy off the first one's direction is rounding.
const PARALLEL: f64 = 1e-6;
/// Sweeps on the last level.
const LAST: usize = 16;

/// The levels under the links that are solved for.
pub(crate) struct Multigrid<N> {
    levels: Vec<Level<N>>,
}

struct Level<N> {
    /// Links of the level below; none of the last one.
    coarse: Option<N>,
    rhs: Vec<f32>,
    x: Vec<f32>,
    next: Vec<f32>,
}

impl<N: Network> Multigrid<N> {
    pub(crate) fn new(links: &N) -> Self {
        let mut levels = vec![Level::new(links)];
        while let Some(last) = levels.last().and_then(|level| level.coarse.as_ref()) {
            let level = Level::new(last);
            levels.push(level);
        }
        Self { levels }
    }

    /// One cycle for the residual `r`; returns the correction and its product with `r`.
    pub(crate) fn cycle(&mut self, links: &N, r: &[f64]) -> (&[f32], f64) {
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

impl<N: Network> Level<N> {
    fn new(links: &N) -> Self {
        let zeros = || vec![0.0; links.len()];
        let coarse = links.coarse();
        Self { coarse, rhs: zeros(), x: zeros(), next: zeros() }
    }

    /// Smooths by one sweep; the first sweep from zero needs no fluxes.
    fn sweep(&mut self, links: &N, weight: f32, from_zero: bool) {
        let (x, rhs, len) = (&self.x, &self.rhs, links.layer_len());
        layers_mut(&mut self.next, len, |k, next| {
            let (x_layer, rhs) = (&x[k * len..][..next.len()], &rhs[k * len..][..next.len()]);
            links.fluxes(x, k, |at, flux, links| {
                let (start, flux) = if from_zero { (0.0, 0.0) } else { (x_layer[at], flux) };
                let over = if links > 0.0 { weight / links } else { 0.0 };
                next[at] = start + over * (rhs[at] - flux);
            });
        });
        std::mem::swap(&mut self.x, &mut self.next);
    }
}

/// A cycle on the first of `levels`, from zero.
fn cycle<N: Network>(links: &N, levels: &mut [Level<N>]) {
    let Some((level, lower)) = levels.split_first_mut() else { return };
    let Some(coarse) = level.coarse.take() else {
        (0..LAST).for_each(|sweep| level.sweep(links, WEIGHTS[sweep % 2], sweep == 0));
        (0..LAST).for_each(|sweep| level.sweep(links, WEIGHTS[1 - sweep % 2], false));
        return;
    };
    level.sweep(links, WEIGHTS[0], true);
    level.sweep(links, WEIGHTS[1], false);
    links.restrict(&coarse, &level.x, &level.rhs, &mut lower[0].rhs);
    twice(&coarse, lower);
    links.correct(&coarse, &mut level.x, &lower[0].x);
    level.sweep(links, WEIGHTS[1], false);
    level.sweep(links, WEIGHTS[0], false);
    level.coarse = Some(coarse);
}

/// Two steps of conjugate gradients on the first of `levels`, each with a cycle (Notay, Electron. Trans. Numer. Anal. 37,
/// 2010, 123, algorithm 3.2). The steps scale what the constant groups get wrong.
fn twice<N: Network>(links: &N, levels: &mut [Level<N>]) {
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
    let own = links.apply(&level.x, &mut product);
    let rest = own - if rho > 0.0 { gamma * gamma / rho } else { 0.0 };
    let second = if rest > PARALLEL * own { alpha / rest } else { 0.0 };
    let first_step = if rho > 0.0 { step - gamma * second / rho } else { 0.0 };
    layers_mut(&mut level.x, len, |k, x| {
        let first = &first[k * len..][..x.len()];
        x.iter_mut().zip(first).for_each(|(x, first)| *x = second as f32 * *x + first_step as f32 * first);
    });
}
