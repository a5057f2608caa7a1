//! Exact arithmetic on coordinates: integers of any size in a common unit, a power of two.

use crate::math::Vec3;
use num_bigint::BigInt;
use num_traits::{Signed, ToPrimitive};

/// A vector of integers.
pub(crate) type Int3 = [BigInt; 3];

/// The exponent of the lowest bit that is set in any of the finite numbers; 0 where all are 0.
pub(crate) fn unit_exponent(numbers: impl IntoIterator<Item = f64>) -> i32 {
    let lowest = |x: f64| {
        let (mantissa, exponent) = decompose(x);
        exponent + mantissa.trailing_zeros() as i32
    };
    numbers.into_iter().filter(|x| *x != 0.0).map(lowest).min().unwrap_or(0)
}

/// `x` in units of 2^`unit`, which must divide it.
pub(crate) fn to_integer(x: f64, unit: i32) -> BigInt {
    if x == 0.0 {
        return BigInt::ZERO;
    }
    let (mantissa, exponent) = decompose(x);
    let zeros = mantissa.trailing_zeros();
    let magnitude = BigInt::from(mantissa >> zeros) << (exponent + zeros as i32 - unit);
    if x < 0.0 { -magnitude } else { magnitude }
}

pub(crate) fn to_integers(v: &Vec3, unit: i32) -> Int3 {
    [v.x, v.y, v.z].map(|x| to_integer(x, unit))
}

/// numerator / denominator 2^`exponent`, to within two units in the last place.
pub(crate) fn quotient(numerator: &BigInt, denominator: &BigInt, exponent: i32) -> f64 {
    let shift = 64 + denominator.bits() as i64 - numerator.bits() as i64;
    let scaled = if shift >= 0 { numerator << shift } else { numerator >> -shift };
    let quotient = (scaled / denominator).to_f64().unwrap_or(f64::NAN);
    libm::scalbn(quotient, (i64::from(exponent) - shift) as i32)
}

pub(crate) fn minus(a: &Int3, b: &Int3) -> Int3 {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub(crate) fn cross(a: &Int3, b: &Int3) -> Int3 {
    [(1, 2), (2, 0), (0, 1)].map(|(j, k)| &a[j] * &b[k] - &a[k] * &b[j])
}

pub(crate) fn dot(a: &Int3, b: &Int3) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// The largest number of bits of any magnitude.
pub(crate) fn bits<'a>(numbers: impl IntoIterator<Item = &'a BigInt>) -> u64 {
    numbers.into_iter().map(|n| n.abs().bits()).max().unwrap_or(0)
}

/// |x| = mantissa 2^exponent.
fn decompose(x: f64) -> (u64, i32) {
    let bits = x.abs().to_bits();
    let (exponent, fraction) = ((bits >> 52) as i32, bits & ((1 << 52) - 1));
    if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) }
}
