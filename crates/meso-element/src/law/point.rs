//! One point of a material under test: a law alone, without mesh and inertia.
//!
//! The strain along x is prescribed; free directions follow so that their stress is held.

use crate::law::{Law, Tensor};
use crate::real::Real;

/// The directions that are held while the strain along x is prescribed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeldStress {
    /// Both lateral stresses, at this value, MPa (tension positive): 0 is the uniaxial test.
    Lateral(f64),
    /// The stress along z, at this value, MPa, while y is strained as x: 0 is the equibiaxial test.
    Third(f64),
}

/// One row of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Strain along x.
    pub strain: f64,
    /// Strain of the directions whose stress is held.
    pub lateral_strain: f64,
    /// Stress along x, MPa.
    pub stress: f64,
    /// Damage in tension and compression, 0 to 1.
    pub damage: [f64; 2],
    /// Energy per volume that unloading would give back, N/mm2.
    pub stored: f64,
}

/// Curve of a point that follows `strains` along x, one sample each, in a crack band `width_mm` wide.
///
/// The held stress is first raised from 0 while x is strained to the first of `strains`, in as many steps as there are
/// samples in twenty.
pub fn curve<R: Real + Into<f64>, L: Law<R>>(
    law: &L,
    width_mm: f64,
    held: HeldStress,
    strains: &[f64],
) -> Vec<Reading> {
    let Some(&first) = strains.first() else { return Vec::new() };
    let mut point = Point { law, width: R::splat(width_mm), history: L::virgin(), lateral: 0.0, held };
    let steps = strains.len().div_ceil(20);
    for step in 1..steps {
        let share = step as f64 / steps as f64;
        point.go_to(share * first, share);
    }
    strains.iter().map(|&strain| point.go_to(strain, 1.0)).collect()
}

/// `steps` equal steps `from` one strain `to` another, without the first and with the last.
pub fn ramp(from: f64, to: f64, steps: usize) -> impl Iterator<Item = f64> {
    (1..=steps).map(move |step| from + (to - from) * step as f64 / steps as f64)
}

/// Area under the curve, stress over strain, N/mm2.
pub fn work(curve: &[Reading]) -> f64 {
    curve.windows(2).map(|w| (w[0].stress + w[1].stress) / 2.0 * (w[1].strain - w[0].strain)).sum()
}

struct Point<'a, R: Real, L: Law<R>> {
    law: &'a L,
    width: R,
    history: L::History,
    lateral: f64,
    held: HeldStress,
}

/// Halvings of the bracket about the free strain: of 1e-7, down to the last digit of a strain of 1e-3 in f64.
const HALVINGS: usize = 40;

impl<R: Real + Into<f64>, L: Law<R>> Point<'_, R, L> {
    fn strains(&self, axial: f64, free: f64) -> Tensor<R> {
        let second = if let HeldStress::Lateral(_) = self.held { free } else { axial };
        [axial, second, free, 0.0, 0.0, 0.0].map(R::splat)
    }

    /// Stress in the free direction less the held one, MPa.
    fn excess(&self, axial: f64, free: f64, target: f64) -> f64 {
        let mut history = self.history;
        let stress = self.law.stress(&self.strains(axial, free), &mut history, self.width).stress;
        stress[2].into() - target
    }

    fn go_to(&mut self, axial: f64, share: f64) -> Reading {
        let (HeldStress::Lateral(held) | HeldStress::Third(held)) = self.held;
        self.lateral = self.free_strain(axial, share * held);
        let strains = self.strains(axial, self.lateral);
        let stress = self.law.stress(&strains, &mut self.history, self.width).stress;
        let state = self.law.state(&strains, &self.history, self.width);
        Reading {
            strain: axial,
            lateral_strain: self.lateral,
            stress: stress[0].into(),
            damage: [state.tension.into(), state.compression.into()],
            stored: state.stored.into(),
        }
    }

    /// Free strain at which its stress is `target`: a bracket grown about the last one, then halved.
    fn free_strain(&self, axial: f64, target: f64) -> f64 {
        let (mut low, mut high, mut reach) = (self.lateral, self.lateral, 1e-7);
        while self.excess(axial, low, target) > 0.0 && reach < 1.0 {
            low -= reach;
            reach *= 2.0;
        }
        reach = 1e-7;
        while self.excess(axial, high, target) < 0.0 && reach < 1.0 {
            high += reach;
            reach *= 2.0;
        }
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if self.excess(axial, middle, target) < 0.0 { low = middle } else { high = middle }
        }
        f64::midpoint(low, high)
    }
}
