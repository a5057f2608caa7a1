//! Pressure, Mises stress and principal directions' share of a stress, without an eigenvalue solver.
//!
//! Principal stresses are p + (2/3) q y_i with y_1 = cos(theta), y_3 = -cos(60 deg - theta) and theta from 0 (tensile
//! meridian) to 60 degrees (compressive meridian), where cos(3 theta) = 27 J3 / (2 q^3). A third of an angle is taken by
//! one root and one polynomial, with neither cosine nor its inverse.

use super::Tensor;
use crate::real::{Real, polynomial};

/// A stress as mean, deviator and Mises stress, MPa.
#[derive(Clone, Copy)]
pub(super) struct Invariants<R> {
    /// Mean stress, positive in tension.
    pub(super) mean: R,
    /// The stress less its mean.
    pub(super) deviator: Tensor<R>,
    /// sqrt(3 J2).
    pub(super) mises: R,
}

impl<R: Real> Invariants<R> {
    /// Invariants of a stress.
    #[inline(always)]
    pub(super) fn of(stress: &Tensor<R>) -> Self {
        let [xx, yy, zz, xy, yz, zx] = *stress;
        let mean = (xx + yy + zz) * R::splat(1.0 / 3.0);
        let deviator = [xx - mean, yy - mean, zz - mean, xy, yz, zx];
        let [a, b, c, ..] = deviator;
        let normal = a.mul_add(a, b.mul_add(b, c * c));
        let shear = xy.mul_add(xy, yz.mul_add(yz, zx * zx));
        let mises = R::splat(1.5).mul_add(normal, R::splat(3.0) * shear).sqrt();
        Self { mean, deviator, mises }
    }

    /// y_1 >= y_2 >= y_3: principal deviators over 2 q / 3. Anything that sums to zero where q is zero.
    #[inline(always)]
    pub(super) fn shape(&self) -> [R; 3] {
        let [a, b, c, xy, yz, zx] = self.deviator;
        let over = R::splat(1.0) / self.mises.max(R::splat(1e-8));
        let minor_yz = b.mul_add(c, -(yz * yz));
        let minor_xy = yz.mul_add(zx, -(xy * c));
        let minor_zx = xy.mul_add(yz, -(zx * b));
        let determinant = a.mul_add(minor_yz, xy.mul_add(minor_xy, zx * minor_zx));
        let cosine = (R::splat(13.5) * determinant * over * over * over).between(-1.0, 1.0);
        let half = R::splat(0.5);
        let first = third_cosine(half.mul_add(cosine, half).sqrt());
        let last = -third_cosine((-half).mul_add(cosine, half).sqrt());
        [first, -(first + last), last]
    }
}

/// The product of a tensor with itself.
#[inline(always)]
fn square<R: Real>(tensor: &Tensor<R>) -> Tensor<R> {
    let [a, b, c, xy, yz, zx] = *tensor;
    [
        a.mul_add(a, xy.mul_add(xy, zx * zx)),
        b.mul_add(b, xy.mul_add(xy, yz * yz)),
        c.mul_add(c, yz.mul_add(yz, zx * zx)),
        a.mul_add(xy, xy.mul_add(b, zx * yz)),
        xy.mul_add(zx, b.mul_add(yz, yz * c)),
        a.mul_add(zx, xy.mul_add(yz, zx * c)),
    ]
}

/// `crack` times the tensile and `crush` times the compressive part of the tensor with this mean, deviator and principal
/// deviators: the lone principal stress of one sign is split off by the product of the tensor less the two others.
#[inline(always)]
pub(super) fn split<R: Real>(mean: R, deviator: &Tensor<R>, of: &[R; 3], crack: R, crush: R) -> Tensor<R> {
    let zero = R::splat(0.0);
    let two_pulled = zero.lt(mean + of[1]);
    let pick = |two: R, one: R| R::select(two_pulled, two, one);
    let (lone, far) = (pick(of[2], of[0]), pick(of[0], of[2]));
    let (base, other) = (pick(crack, crush), pick(crush, crack));
    // The lone stress where it has the other sign, 0 else.
    let value = pick((mean + lone).min(zero), (mean + lone).positive());
    let gap = (lone - of[1]) * (lone - far);
    // Where the lone one meets its neighbour, its value is 0, too.
    let weight = (other - base) * value / gap.max(R::splat(1e-12));
    let constant = (of[1] * far).mul_add(weight, base * mean);
    let square = square(deviator);
    let linear = lone.mul_add(weight, base);
    let mut sum = *deviator;
    for i in 0..6 {
        let rest = linear * deviator[i];
        sum[i] = weight.mul_add(square[i], if i < 3 { rest + constant } else { rest });
    }
    sum
}

/// The tensor with the axes of a deviator and the principal values `to` where that has `of`, both in falling order and `to`
/// nowhere steeper: the quadratic polynomial of the deviator through all three, by Newton's form.
#[inline(always)]
pub(super) fn moved<R: Real>(deviator: &Tensor<R>, of: &[R; 3], to: &[R; 3]) -> Tensor<R> {
    // Rounding of stresses, MPa: where two principal values nearly agree, they keep their distance.
    let least = R::splat(if R::SINGLE { 1e-5 } else { 1e-13 });
    let mut slopes = [R::splat(1.0); 2];
    for (i, slope) in slopes.iter_mut().enumerate() {
        *slope = ((to[i] - to[i + 1] + least) / (of[i] - of[i + 1] + least)).min(*slope);
    }
    let [first, second] = slopes;
    let weight = (first - second) / (of[0] - of[2]).max(least);
    let linear = weight.mul_add(of[2], first);
    let constant = (-first).mul_add(of[0], weight.mul_add(of[0] * of[1], to[0]));
    let square = square(deviator);
    let mut sum = *deviator;
    for i in 0..6 {
        let rest = if i < 3 { linear.mul_add(deviator[i], constant) } else { linear * deviator[i] };
        sum[i] = weight.mul_add(square[i], rest);
    }
    sum
}

/// cos(acos(c) / 3) from u = sqrt((1 + c) / 2) = cos(acos(c) / 2): cos(2/3 acos(u)), smooth on all of 0 to 1.
///
/// Within 3e-8 in f32 (before rounding), 3e-17 in f64.
#[inline(always)]
fn third_cosine<R: Real>(u: R) -> R {
    if R::SINGLE { polynomial(u, &THIRD_SINGLE) } else { polynomial(u, &THIRD_DOUBLE) }
}

/// From fits on Chebyshev nodes in 60 decimal digits.
const THIRD_SINGLE: [f64; 9] = [
    0.500000003733184245,
    0.57734966139841111,
    -0.111094492767438346,
    0.053279350849813718,
    -0.0319254121449798519,
    0.0196003209395859883,
    -0.0102375083307082449,
    0.00365411956894458809,
    -0.000626045323463153556,
];
const THIRD_DOUBLE: [f64; 19] = [
    0.500000000000000027,
    0.577350269189606459,
    -0.111111111108779962,
    0.0534583581460655889,
    -0.0329218078294839257,
    0.0228682526569535511,
    -0.0170700956571094259,
    0.0133665757861739198,
    -0.0108192351830443402,
    0.00893690446741923919,
    -0.00739830766976271884,
    0.00595744248052231948,
    -0.00446790654850248911,
    0.00295984766479732905,
    -0.0016347207159981611,
    0.00070630301549445088,
    -0.000220368729183131487,
    0.0000437120525491405165,
    -4.11201771788392315e-6,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_third_of_every_angle_is_met() {
        for step in 0..=3000 {
            let angle = std::f64::consts::PI * f64::from(step) / 3000.0;
            let (u, exact) = ((angle / 2.0).cos(), (angle / 3.0).cos());
            assert!((third_cosine(u) - exact).abs() < 4e-16);
            assert!((f64::from(third_cosine(u as f32)) - exact).abs() < 1.2e-7);
        }
    }

    #[test]
    fn principal_stresses_are_those_of_a_turned_tensor() {
        // Rows of a rotation about (1, 2, 2) / 3 by 90 degrees, which is exact in thirds.
        let turn = [[1.0, -4.0, 8.0], [8.0, 4.0, 1.0], [-4.0, 7.0, 4.0]].map(|row| row.map(|x: f64| x / 9.0));
        for principal in [[3.0, 1.0, -7.0], [0.0, 0.0, -40.0], [2.0, 0.0, 0.0], [-1.0, -1.0, -30.0], [5.0, 5.0, -5.0]] {
            let at = |i: usize, j: usize| (0..3).map(|k| turn[i][k] * principal[k] * turn[j][k]).sum::<f64>();
            let stress = [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)];
            let found = principal_of(&Invariants::of(&stress));
            let coarse = principal_of(&Invariants::of(&stress.map(|x| x as f32))).map(f64::from);
            let size = Invariants::of(&stress).mises;
            for i in 0..3 {
                assert!((found[i] - principal[i]).abs() < 2e-8 * size, "{found:?} for {principal:?}");
                // Where two of them agree, the root of their distance's rounding error.
                assert!((coarse[i] - principal[i]).abs() < 4e-4 * size, "{coarse:?} for {principal:?}");
            }
        }
    }

    fn principal_of<R: Real>(of: &Invariants<R>) -> [R; 3] {
        of.shape().map(|y| of.mean + R::splat(2.0 / 3.0) * of.mises * y)
    }
}
