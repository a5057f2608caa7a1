//! Isotropic linear elasticity.

use super::{Law, PointResponse, State, Tensor};
use crate::real::Real;

/// Lame's two constants, MPa.
#[derive(Clone, Copy, Debug)]
pub struct Hooke<R> {
    /// lambda.
    pub(super) lambda: R,
    /// G.
    pub(super) shear: R,
}

impl<R: Real> Hooke<R> {
    /// From Young's modulus and Poisson's ratio.
    pub fn new(values: &meso_mesh::materials::Elastic) -> Self {
        let (e, nu) = (values.youngs_modulus_mpa, values.poisson_ratio);
        let shear = e / (2.0 * (1.0 + nu));
        Self { lambda: R::splat(2.0 * shear * nu / (1.0 - 2.0 * nu)), shear: R::splat(shear) }
    }

    /// Stress of an elastic strain, MPa.
    #[inline(always)]
    pub fn of(&self, strain: &Tensor<R>) -> Tensor<R> {
        let [xx, yy, zz, xy, yz, zx] = *strain;
        let pressure = self.lambda * (xx + yy + zz);
        let twice = self.shear + self.shear;
        [
            twice.mul_add(xx, pressure),
            twice.mul_add(yy, pressure),
            twice.mul_add(zz, pressure),
            self.shear * xy,
            self.shear * yz,
            self.shear * zx,
        ]
    }
}

/// Strain less the plastic strain, with which every history begins.
#[inline(always)]
pub(super) fn elastic_part<R: Real, const N: usize>(strain: &Tensor<R>, history: &[R; N]) -> Tensor<R> {
    let mut part = *strain;
    for i in 0..6 {
        part[i] = part[i] - history[i];
    }
    part
}

/// Adds to the plastic strain `volumetric` along each axis and `per_stress` times a stress deviator.
#[inline(always)]
pub(super) fn flow<R: Real, const N: usize>(history: &mut [R; N], deviator: &Tensor<R>, per_stress: R, volumetric: R) {
    for i in 0..3 {
        history[i] = per_stress.mul_add(deviator[i], history[i] + volumetric);
        history[i + 3] = (per_stress + per_stress).mul_add(deviator[i + 3], history[i + 3]);
    }
}

/// Half of stress times strain, N/mm2.
#[inline(always)]
pub(super) fn energy<R: Real>(stress: &Tensor<R>, strain: &Tensor<R>) -> R {
    let mut sum = stress[0] * strain[0];
    for i in 1..6 {
        sum = stress[i].mul_add(strain[i], sum);
    }
    R::splat(0.5) * sum
}

impl<R: Real> Law<R> for Hooke<R> {
    type History = [R; 0];

    fn virgin() -> [R; 0] {
        []
    }

    #[inline(always)]
    fn stress(&self, strain: &Tensor<R>, _: &mut [R; 0], _: R) -> PointResponse<R> {
        PointResponse { stress: self.of(strain), integrity: R::splat(1.0) }
    }

    #[inline(always)]
    fn state(&self, strain: &Tensor<R>, _: &[R; 0], _: R) -> State<R> {
        let none = R::splat(0.0);
        let stored = energy(&self.of(strain), strain);
        State { tension: none, compression: none, weakened: none, opening: none, stored }
    }

    fn widest_mm(&self) -> [f64; 2] {
        [f64::INFINITY; 2]
    }
}
