//! Points with integer coordinates of any size, and the way from doubles and back.

use crate::math::Vec3;
use num_bigint::{BigInt, Sign};
use num_traits::Zero;

/// A point or a direction with integer coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point([BigInt; 3]);

impl Point {
    /// `p` in units of 2^`exponent`, which must divide it.
    pub(crate) fn new(p: &Vec3, exponent: i32) -> Self {
        Self([p.x, p.y, p.z].map(|value| {
            let (mantissa, own) = decode(value);
            let shift = own - exponent;
            if shift >= 0 { BigInt::from(mantissa) << shift } else { BigInt::from(mantissa >> -shift.max(-63)) }
        }))
    }

    /// `p` times `factor` in units of 2^`exponent`, which must divide the product.
    pub(crate) fn product(p: &Vec3, factor: f64, exponent: i32) -> Self {
        let (factor, power) = decode(factor);
        Self([p.x, p.y, p.z].map(|value| {
            let (mantissa, own) = decode(value);
            let (product, shift) = (BigInt::from(mantissa) * factor, own + power - exponent);
            if shift >= 0 { product << shift } else { product >> -shift }
        }))
    }

    pub(crate) fn zero() -> Self {
        Self(std::array::from_fn(|_| BigInt::zero()))
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.0.iter().all(Zero::is_zero)
    }

    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| &self.0[i] - &other.0[i]))
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|i| &self.0[i] + &other.0[i]))
    }

    pub(crate) fn negated(&self) -> Self {
        Self(std::array::from_fn(|i| -&self.0[i]))
    }

    pub(crate) fn times(&self, factor: &BigInt) -> Self {
        Self(std::array::from_fn(|i| &self.0[i] * factor))
    }

    pub(crate) fn dot(&self, other: &Self) -> BigInt {
        let [x, y, z] = std::array::from_fn(|i| &self.0[i] * &other.0[i]);
        x + y + z
    }

    pub(crate) fn cross(&self, other: &Self) -> Self {
        let (p, q) = (&self.0, &other.0);
        Self(std::array::from_fn(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            &p[j] * &q[k] - &p[k] * &q[j]
        }))
    }

    /// The point over a positive number, in units of 2^`exponent`: rounded once.
    pub(crate) fn over(&self, denominator: &BigInt, exponent: i64) -> Vec3 {
        let [x, y, z] = std::array::from_fn(|i| {
            let shift = 66 + denominator.bits().saturating_sub(self.0[i].bits());
            to_double(&((&self.0[i] << shift) / denominator), exponent - shift as i64)
        });
        Vec3::new(x, y, z)
    }

    /// The direction in doubles, the largest component between 1/2 and 1; components below 2^-900 of it become 0.
    pub(crate) fn direction(&self) -> Vec3 {
        let bits = self.0.iter().map(BigInt::bits).max().unwrap_or(0) as i64;
        let [x, y, z] = std::array::from_fn(|i| {
            let small = bits - self.0[i].bits() as i64 > 900;
            if small { 0.0 } else { to_double(&self.0[i], -bits) }
        });
        Vec3::new(x, y, z)
    }
}

/// value = mantissa 2^exponent, exactly; the value must be finite.
pub(crate) fn decode(value: f64) -> (i64, i32) {
    let bits = value.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, (bits & ((1 << 52) - 1)) as i64);
    let mantissa = if field == 0 { fraction } else { fraction | 1 << 52 };
    (if value < 0.0 { -mantissa } else { mantissa }, field.max(1) - 1075)
}

/// value 2^exponent, correctly rounded up to a second rounding of at most 2^-10 ulp.
pub(crate) fn to_double(value: &BigInt, exponent: i64) -> f64 {
    let surplus = value.bits().saturating_sub(64);
    let shifted = value.magnitude() >> surplus;
    let mut head = shifted.iter_u64_digits().next().unwrap_or(0);
    if surplus > 0 && value.trailing_zeros().is_some_and(|zeros| zeros < surplus) {
        head |= 1; // sticky: what was cut off is not nothing
    }
    let magnitude = scaled(head as f64, exponent + surplus as i64);
    if value.sign() == Sign::Minus { -magnitude } else { magnitude }
}

/// value 2^exponent in steps that neither overflow nor lose digits before the last.
fn scaled(mut value: f64, mut exponent: i64) -> f64 {
    let power = |e: i64| f64::from_bits(((1023 + e) as u64) << 52);
    while exponent > 1000 {
        value *= power(1000);
        exponent -= 1000;
    }
    while exponent < -1000 {
        value *= power(-1000);
        exponent += 1000;
    }
    value * power(exponent)
}
