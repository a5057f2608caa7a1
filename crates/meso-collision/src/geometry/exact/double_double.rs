//! Numbers of twice f64's precision: an unevaluated sum of two f64 (Dekker 1971; Joldes, Muller, Popescu 2017).
//!
//! A sum, product, quotient or square root errs by at most 2^-100 of its value as long as nothing over- or underflows.
//! Products are split rather than fused: `mul_add` is a slow library call where the processor has none. All is inlined, for
//! loops that the compiler turns into vector instructions.

use std::ops::{Add, Mul, Neg, Sub};

/// The sum `hi + lo`, |lo| at most half an ulp of `hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dd {
    hi: f64,
    lo: f64,
}

/// Relative error of one operation.
pub(crate) const DD_EPSILON: f64 = 1.0 / (1_u128 << 100) as f64;

impl Dd {
    pub(crate) const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    /// a - b, exactly.
    #[inline(always)]
    pub(crate) fn difference(a: f64, b: f64) -> Self {
        two_sum(a, -b)
    }

    /// The nearest f64.
    #[inline(always)]
    pub(crate) fn value(self) -> f64 {
        self.hi
    }

    #[inline(always)]
    pub(crate) fn recip(self) -> Self {
        let q = 1.0 / self.hi;
        // One step of Newton: q (2 - self q).
        let error = Self::from(1.0) - self * q;
        quick_two_sum(q, error.hi * q)
    }

    /// NaN unless above 0.
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        let error = self - two_product(root, root);
        quick_two_sum(root, error.hi / (2.0 * root))
    }
}

impl From<f64> for Dd {
    #[inline(always)]
    fn from(x: f64) -> Self {
        Self { hi: x, lo: 0.0 }
    }
}

impl Add for Dd {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let sum = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(sum.hi, sum.lo + low.lo)
    }
}

impl Neg for Dd {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl Sub for Dd {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Dd {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let product = two_product(self.hi, other.hi);
        quick_two_sum(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl Mul<f64> for Dd {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        let product = two_product(self.hi, other);
        quick_two_sum(product.hi, product.lo + self.lo * other)
    }
}

/// A vector of such numbers.
pub(crate) type Dd3 = [Dd; 3];

#[inline(always)]
pub(crate) fn cross(a: &Dd3, b: &Dd3) -> Dd3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(crate) fn dot(a: &Dd3, b: &Dd3) -> Dd {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a + b, exactly (Knuth).
#[inline(always)]
fn two_sum(a: f64, b: f64) -> Dd {
    let hi = a + b;
    let of_b = hi - a;
    Dd { hi, lo: (a - (hi - of_b)) + (b - of_b) }
}

/// a + b, exactly, where |a| >= |b|.
#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> Dd {
    let hi = a + b;
    Dd { hi, lo: b - (hi - a) }
}

/// a b, exactly (Dekker).
#[inline(always)]
fn two_product(a: f64, b: f64) -> Dd {
    let hi = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    Dd { hi, lo: a_low * b_low - (((hi - a_high * b_high) - a_low * b_high) - a_high * b_low) }
}

/// Two halves of 26 bits (Veltkamp).
#[inline(always)]
fn split(a: f64) -> (f64, f64) {
    let scaled = a * 134_217_729.0;
    let high = scaled - (scaled - a);
    (high, a - high)
}
