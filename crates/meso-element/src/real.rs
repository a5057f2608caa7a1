//! The numbers of a law: one f64, one f32, or a register of f32.
//!
//! A law is written once over [`Real`]. Tests run it in f64, one point at a time; the solver runs it in f32, as many
//! elements at a time as a register holds. Every operation is exactly rounded or built from ones that are, so all
//! instruction sets give the same bits.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// A number, or a register of numbers.
pub trait Real:
    Copy
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The answer of a comparison, number by number.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask> + Not<Output = Self::Mask>;
    /// Whether the numbers are f32, for which shorter polynomials are enough.
    const SINGLE: bool;

    /// `value` in every lane.
    fn splat(value: f64) -> Self;
    /// `self * b + c`, rounded once.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// The smaller one; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// The nearest integer, the even one of two.
    fn round(self) -> Self;
    /// 2 to the power of an integer from -126 to 127.
    fn pow2(self) -> Self;
    /// (m, n) with `self` = m 2^n, m from sqrt(1/2) to sqrt(2) and n an integer; `self` is positive and normal.
    fn split(self) -> (Self, Self);
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `a` where `mask` holds, else `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Whether `mask` holds anywhere.
    fn any(mask: Self::Mask) -> bool;

    /// e to the power of `self`, which is held between -87 and 88: e^(n ln 2) e^r, |r| <= ln(2) / 2.
    ///
    /// Relative error below 2e-7 in f32 and 1e-15 in f64.
    #[inline(always)]
    fn exp(self) -> Self {
        let x = self.max(Self::splat(-87.0)).min(Self::splat(88.0));
        let n = (x * Self::splat(std::f64::consts::LOG2_E)).round();
        let r = (-n).mul_add(Self::splat(LN2_HIGH), x);
        let r = (-n).mul_add(Self::splat(LN2_LOW), r);
        let power = if Self::SINGLE { polynomial(r, &EXP_SINGLE) } else { polynomial(r, &EXP_DOUBLE) };
        power * n.pow2()
    }

    /// Natural logarithm of a positive, normal number: n ln 2 + 2 atanh(s), s = (m - 1) / (m + 1).
    ///
    /// Error below 2e-7 in f32 and 4e-16 in f64, absolute near 1 and relative elsewhere.
    #[inline(always)]
    fn ln(self) -> Self {
        let (m, n) = self.split();
        let one = Self::splat(1.0);
        let s = (m - one) / (m + one);
        let square = s * s;
        let tail = if Self::SINGLE { polynomial(square, &LN_SINGLE) } else { polynomial(square, &LN_DOUBLE) };
        let near_one = (s * square).mul_add(tail, s + s);
        n.mul_add(Self::splat(LN2_HIGH), n.mul_add(Self::splat(LN2_LOW), near_one))
    }

    /// The positive part, 0 where NaN.
    #[inline(always)]
    fn positive(self) -> Self {
        self.max(Self::splat(0.0))
    }

    /// `self` held between `low` and `high`.
    #[inline(always)]
    fn between(self, low: f64, high: f64) -> Self {
        self.max(Self::splat(low)).min(Self::splat(high))
    }
}

/// ln 2 in two parts; the first has 11 digits, so that its product with n is exact in f32, too.
const LN2_HIGH: f64 = 0.693359375;
const LN2_LOW: f64 = -2.121_944_400_546_905_8e-4;

// Coefficients of rising powers, from fits on Chebyshev nodes in 60 decimal digits.
/// e^x for |x| <= ln(2) / 2, within 2e-9.
const EXP_SINGLE: [f64; 7] = [
    1.0,
    1.00000003794329924,
    0.500000004740139344,
    0.166664145071695612,
    0.0416663516384445757,
    0.00837521020087001641,
    0.00139412131000063345,
];
/// Coefficients of exp in double precision, within 3e-18.
const EXP_DOUBLE: [f64; 12] = [
    0.999999999999999997,
    1.0,
    0.500000000000001857,
    0.166666666666666809,
    0.0416666666664866612,
    0.00833333333331949032,
    0.00138888889526965157,
    0.000198412698406903653,
    0.0000248014850741051167,
    2.75572406046638958e-6,
    2.7632790542117181e-7,
    2.51101536469289314e-8,
];
/// (2 atanh(s) - 2 s) / s^3 over s^2 for |s| <= (sqrt(2) - 1) / (sqrt(2) + 1), within 2e-7 (1e-9 of ln).
const LN_SINGLE: [f64; 3] = [0.666666856032735603, 0.399885509889357573, 0.295903173571603972];
/// Coefficients of ln in double precision, within 2e-18.
const LN_DOUBLE: [f64; 8] = [
    0.666666666666666664,
    0.400000000000009413,
    0.285714285707644501,
    0.222222224005477573,
    0.181817947008977996,
    0.15386290534658992,
    0.132674185964748834,
    0.131007213835034914,
];

/// The polynomial with `coefficients` of rising powers at `x`, its even and its odd powers side by side, so that one need
/// not wait for the other.
#[inline(always)]
pub fn polynomial<R: Real, const N: usize>(x: R, coefficients: &[f64; N]) -> R {
    let square = x * x;
    let mut halves = [R::splat(coefficients[(N - 1) & !1]), R::splat(coefficients[(N - 2) | 1])];
    for power in (0..N - 2).rev() {
        halves[power & 1] = halves[power & 1].mul_add(square, R::splat(coefficients[power]));
    }
    x.mul_add(halves[1], halves[0])
}

macro_rules! scalar {
    ($number:ident, $single:literal, $bits:ident, $signed:ident, $digits:literal, $bias:literal, $root_half:literal) => {
        impl Real for $number {
            type Mask = bool;
            const SINGLE: bool = $single;

            #[inline(always)]
            fn splat(value: f64) -> Self {
                value as $number
            }
            #[inline(always)]
            fn mul_add(self, b: Self, c: Self) -> Self {
                $number::mul_add(self, b, c)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $number::abs(self)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $number::sqrt(self)
            }
            #[inline(always)]
            fn round(self) -> Self {
                self.round_ties_even()
            }
            #[inline(always)]
            fn pow2(self) -> Self {
                $number::from_bits(((self as $signed + $bias) as $bits) << $digits)
            }
            #[inline(always)]
            fn split(self) -> (Self, Self) {
                let exponent = (self.to_bits() as $signed - $root_half) >> $digits;
                let mantissa = self.to_bits() as $signed - (exponent << $digits);
                ($number::from_bits(mantissa as $bits), exponent as $number)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn select(mask: bool, a: Self, b: Self) -> Self {
                if mask { a } else { b }
            }
            #[inline(always)]
            fn any(mask: bool) -> bool {
                mask
            }
        }
    };
}

scalar!(f32, true, u32, i32, 23, 127, 0x3f35_04f3);
scalar!(f64, false, u64, i64, 52, 1023, 0x3fe6_a09e_667f_3bcd);

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest error of `ours` against `theirs`, relative where that is above 1, over points from `low` to `high`.
    fn error<R: Real + Into<f64>>(low: f64, high: f64, ours: fn(R) -> R, theirs: fn(f64) -> f64) -> f64 {
        let mut worst = 0.0_f64;
        for step in 0..=40_000 {
            let x = R::splat(low + (high - low) * f64::from(step) / 40_000.0);
            let exact = theirs(x.into());
            worst = worst.max((ours(x).into() - exact).abs() / exact.abs().max(1.0));
        }
        worst
    }

    #[test]
    fn the_exponential_is_within_its_bound() {
        assert!(error::<f32>(-30.0, 80.0, Real::exp, libm_exp) < 2e-7);
        assert!(error::<f64>(-30.0, 80.0, Real::exp, libm_exp) < 1e-15);
        let below = |x: f64| Real::exp(x as f32) as f64 / x.exp() - 1.0;
        for x in [-80.0, -50.0, -20.5, -3.0] {
            let x = f64::from(x as f32);
            assert!(below(x).abs() < 2e-7, "{x}: {}", below(x));
        }
        assert!(Real::exp(-1e30_f32) > 0.0 && Real::exp(1e30_f32).is_finite());
    }

    #[test]
    fn the_logarithm_is_within_its_bound() {
        assert!(error::<f32>(1e-3, 4.0, Real::ln, f64::ln) < 2e-7);
        assert!(error::<f64>(1e-3, 4.0, Real::ln, f64::ln) < 4e-16);
        assert!(error::<f32>(4.0, 1e20, Real::ln, f64::ln) < 2e-7);
        assert!(error::<f64>(4.0, 1e20, Real::ln, f64::ln) < 4e-16);
    }

    #[test]
    fn polynomials_of_any_degree_are_summed_whole() {
        assert_eq!(polynomial(2.0, &[1.0, 3.0]), 7.0);
        assert_eq!(polynomial(2.0, &[1.0, 3.0, 5.0]), 27.0);
        assert_eq!(polynomial(2.0, &[1.0, 3.0, 5.0, 7.0]), 83.0);
        assert_eq!(polynomial(2.0, &[1.0, 3.0, 5.0, 7.0, 9.0]), 227.0);
    }

    fn libm_exp(x: f64) -> f64 {
        x.exp()
    }
}
