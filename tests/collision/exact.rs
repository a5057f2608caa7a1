//! Exact integer vectors for reference computations: coordinates in units of 2^-300.

use meso_collision::math::Vec3;
use num_bigint::BigInt;
use num_traits::ToPrimitive;

pub(crate) type Big3 = [BigInt; 3];

/// A whole number and an exponent: `x` is the number times 2 to the exponent.
pub(crate) fn parts(x: f64) -> (i64, i32) {
    let bits = x.abs().to_bits();
    let (field, fraction) = ((bits >> 52) as i32, bits & ((1 << 52) - 1));
    let mantissa = if field == 0 { fraction } else { fraction | (1 << 52) } as i64;
    (if x < 0.0 { -mantissa } else { mantissa }, field.max(1) - 1075)
}

/// `x` in units of 2^-`unit`, rounded down in magnitude.
pub(crate) fn in_units(x: f64, unit: i32) -> BigInt {
    let (mantissa, exponent) = parts(x);
    let (magnitude, shift) = (BigInt::from(mantissa.abs()), exponent + unit);
    let magnitude = if shift >= 0 { magnitude << shift } else { magnitude >> -shift };
    if mantissa < 0 { -magnitude } else { magnitude }
}

pub(crate) fn exact(points: &[Vec3]) -> Vec<Big3> {
    points.iter().map(|p| [p.x, p.y, p.z].map(|x| in_units(x, 300))).collect()
}

pub(crate) fn minus(a: &Big3, b: &Big3) -> Big3 {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub(crate) fn cross(a: &Big3, b: &Big3) -> Big3 {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

pub(crate) fn dot(a: &Big3, b: &Big3) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

pub(crate) fn is_zero(v: &Big3) -> bool {
    v.iter().all(|x| *x == BigInt::ZERO)
}

/// a / b - 1, for messages; `b` is not 0.
pub(crate) fn ratio(a: &BigInt, b: &BigInt) -> f64 {
    let difference: BigInt = (a - b) << 100_u32;
    (difference / b).to_f64().unwrap_or(f64::NAN) / (1_u128 << 100) as f64
}
