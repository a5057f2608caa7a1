//! Conjugate gradients, ended by the error of the energy.

use super::multigrid::Multigrid;
use super::network::Network;
use super::stencil::{Real, add, dot, dots, follow};
use crate::error::EffectiveError;
use meso_concrete::parallel;

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

/// A residual below this share of the energy may be rounding alone.
const LEFT: f64 = 1e-6;

/// Energy at the potentials found so far.
#[derive(Clone, Copy)]
pub(crate) struct Energy {
    now: f64,
    /// Errors count over at least this.
    least: f64,
    /// Change by one of an iteration.
    sign: f64,
}

impl Energy {
    /// Energy of a given gradient, `first` without potentials: it falls.
    pub(crate) fn falling(first: f64) -> Self {
        Self { now: first, least: BLOCKED * first, sign: -1.0 }
    }

    /// Energy of a given flux, 0 without potentials: it rises to more than `least`.
    pub(crate) fn rising(least: f64) -> Self {
        Self { now: 0.0, least, sign: 1.0 }
    }
}

/// Symmetric equations with a preconditioner.
pub(crate) trait Equations {
    /// Numbers of residuals and directions.
    type Number: Real;
    /// Numbers that are added up in one sum.
    fn layer_len(&self) -> usize;
    /// `out = A u`; returns `u . A u`.
    fn apply(&self, u: &[Self::Number], out: &mut [Self::Number]) -> f64;
    /// Nearly `A^-1 r`.
    fn correction(&mut self, r: &[Self::Number]) -> &[f32];
    /// The residual after a `step` along a direction whose `product` with `A` is given.
    fn lower(&self, r: &mut [Self::Number], step: f64, product: &[Self::Number], _potential: &[f64]) {
        add(r, -step, product, self.layer_len());
    }
}

/// Potentials of a network.
struct Potentials<'a, N> {
    links: &'a N,
    multigrid: Multigrid<N>,
    rhs: Vec<f64>,
}

impl<N: Network> Equations for Potentials<'_, N> {
    type Number = f32;

    fn layer_len(&self) -> usize {
        self.links.layer_len()
    }

    fn apply(&self, u: &[f32], out: &mut [f32]) -> f64 {
        self.links.apply(u, out)
    }

    fn correction(&mut self, r: &[f32]) -> &[f32] {
        self.multigrid.cycle(self.links, r)
    }

    fn lower(&self, r: &mut [f32], _step: f64, _product: &[f32], potential: &[f64]) {
        self.links.residual(potential, &self.rhs, r);
    }
}

/// The potentials where every unknown gives off as much as it receives from `rhs`.
///
/// # Errors
/// Too many iterations.
pub(crate) fn solve(
    links: &impl Network,
    rhs: Vec<f64>,
    energy: Energy,
    tolerance: f64,
    report: &dyn Fn(usize, f64),
) -> Result<Solution, EffectiveError> {
    let r = parallel::map_short(rhs.len(), |i| rhs[i] as f32);
    solve_equations(&mut Potentials { links, multigrid: Multigrid::new(links), rhs }, r, energy, tolerance, report)
}

/// The solution of `A u = rhs`.
///
/// Each iteration changes the `energy` by `step^2 p . A p`, and `r . z` bounds the rest but for the
/// quality of the preconditioner. Stops at `tolerance` of the energy, after one more step along the last correction.
///
/// # Errors
/// Too many iterations.
pub(crate) fn solve_equations<E: Equations>(
    equations: &mut E,
    rhs: Vec<E::Number>,
    mut energy: Energy,
    tolerance: f64,
    report: &dyn Fn(usize, f64),
) -> Result<Solution, EffectiveError> {
    let len = equations.layer_len();
    let mut r = rhs;
    // Empty before the first step, which only writes: pages that are read first would be mapped twice.
    let (mut potential, mut p, mut product) = (Vec::new(), Vec::new(), Vec::new());
    let (mut curvature, mut iterations) = (0.0, 0);
    loop {
        let z = equations.correction(&r);
        let [rz, pz] = if iterations == 0 { [dot(&r, z, len), 0.0] } else { dots([&r, &product], z, len) };
        let error = rz / energy.now.max(energy.least);
        // A first residual of rounding alone has no step: it may lie where no link leads away.
        if rz <= 0.0 || iterations == 0 && error <= tolerance {
            potential.resize(r.len(), 0.0);
            return Ok(Solution { potential, iterations, error: error.max(0.0) });
        }
        report(iterations, error);
        if iterations == MOST {
            let fix = "raise the size of voxels or elements, or lower the contrast";
            return Err(EffectiveError::Diverged { iterations, reached: error, fix });
        }
        let mut along = rz;
        if iterations == 0 {
            p = parallel::map_short(r.len(), |i| E::Number::from(z[i]));
            product = vec![E::Number::default(); r.len()];
        } else {
            along = follow(&mut p, z, -pz / curvature, &r, len);
        }
        curvature = equations.apply(&p, &mut product);
        // Rounding within parts that no link leaves has no step, nor do numbers that are none.
        let has_step = curvature > 0.0 && along.is_finite();
        if !has_step && error <= LEFT {
            potential.resize(r.len(), 0.0);
            return Ok(Solution { potential, iterations, error });
        }
        if !has_step {
            let fix = "take another size of voxels or elements, or lower the contrast of the phases";
            return Err(EffectiveError::Diverged { iterations, reached: error, fix });
        }
        let step: f64 = E::Number::of(along / curvature).into();
        match iterations {
            0 => potential = parallel::map_short(r.len(), |i| step * p[i].into()),
            _ => add(&mut potential, step, &p, len),
        }
        iterations += 1;
        if error <= tolerance {
            return Ok(Solution { potential, iterations, error });
        }
        equations.lower(&mut r, step, &product, &potential);
        energy.now += energy.sign * step * step * curvature;
    }
}
