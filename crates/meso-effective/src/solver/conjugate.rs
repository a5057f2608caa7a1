//! Conjugate gradients, ended by the error of the energy.

use super::multigrid::Multigrid;
use super::network::Network;
use super::stencil::{add, dot, layers_mut};
use crate::error::EffectiveError;

/// Potentials of a network, and the way to them.
pub(crate) struct Solution {
    pub(crate) potential: Vec<f64>,
    pub(crate) iterations: usize,
    /// Estimated error of the energy, over the energy.
    pub(crate) error: f64,
}

/// Most iterations; an ordinary packing takes 10 to 25.
const MOST: usize = 500;
/// A result below this share of the energy without equilibrium is zero.
const BLOCKED: f64 = 1e-9;

/// Symmetric equations with a preconditioner.
pub(crate) trait Equations {
    /// Numbers that are added up in one sum.
    fn layer_len(&self) -> usize;
    /// `out = A u`; returns `u . A u`.
    fn apply(&self, u: &[f64], out: &mut [f64]) -> f64;
    /// Nearly `A^-1 r`, and its product with `r`.
    fn correction(&mut self, r: &[f64]) -> (&[f32], f64);
}

/// Potentials of a network.
struct Potentials<'a, N> {
    links: &'a N,
    multigrid: Multigrid<N>,
}

impl<N: Network> Equations for Potentials<'_, N> {
    fn layer_len(&self) -> usize {
        self.links.layer_len()
    }

    fn apply(&self, u: &[f64], out: &mut [f64]) -> f64 {
        self.links.apply(u, out)
    }

    fn correction(&mut self, r: &[f64]) -> (&[f32], f64) {
        self.multigrid.cycle(self.links, r)
    }
}

/// The potentials where every unknown gives off as much as it receives from `rhs`.
///
/// # Errors
/// Too many iterations.
pub(crate) fn solve(
    links: &impl Network,
    rhs: Vec<f64>,
    energy: f64,
    accuracy: f64,
    report: &dyn Fn(usize, f64),
) -> Result<Solution, EffectiveError> {
    solve_equations(&mut Potentials { links, multigrid: Multigrid::new(links) }, rhs, energy, accuracy, report)
}

/// The solution of `A u = rhs`.
///
/// `energy` is that of `u = 0`. Each iteration lowers it by `step^2 p . A p`, and `r . z` bounds the rest but for the
/// quality of the preconditioner. Stops at `accuracy` of the energy.
///
/// # Errors
/// Too many iterations.
pub(crate) fn solve_equations(
    equations: &mut impl Equations,
    rhs: Vec<f64>,
    energy: f64,
    accuracy: f64,
    report: &dyn Fn(usize, f64),
) -> Result<Solution, EffectiveError> {
    let len = equations.layer_len();
    let mut potential = vec![0.0; rhs.len()];
    let mut r = rhs;
    let mut product = vec![0.0; r.len()];
    let (z, mut rz) = equations.correction(&r);
    let mut p: Vec<f64> = z.iter().map(|z| f64::from(*z)).collect();
    let (mut left, mut iterations) = (energy, 0);
    while rz > accuracy * left.max(BLOCKED * energy) {
        report(iterations, rz / left);
        if iterations == MOST {
            let fix = "raise the size of voxels or elements, or lower the contrast";
            return Err(EffectiveError::Diverged { iterations, reached: rz / left, fix });
        }
        let curvature = equations.apply(&p, &mut product);
        let step = dot(&p, &r, len) / curvature;
        add(&mut potential, step, &p, len);
        add(&mut r, -step, &product, len);
        left -= step * step * curvature;
        let (z, next) = equations.correction(&r);
        let ratio = -dot(&product, z, len) / curvature;
        layers_mut(&mut p, len, |k, p| {
            let z = &z[k * len..][..p.len()];
            p.iter_mut().zip(z).for_each(|(p, z)| *p = f64::from(*z) + ratio * *p);
        });
        rz = next;
        iterations += 1;
    }
    let left = left.max(BLOCKED * energy);
    Ok(Solution { potential, iterations, error: if left > 0.0 { rz / left } else { 0.0 } })
}
