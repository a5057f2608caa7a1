//! What a law computes with: one f64, or a register of f32.
//!
//! A law is written once over [`Real`]. Tests run it in f64, one point at a time; the solver runs it in f32, as many
//! elements at a time as a register holds. Every operation is exactly rounded or built from ones that are, so all
//! instruction sets give the same bits.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// A number, or a register of numbers.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The answer of a comparison, number by number.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    /// The same value in every place.
    fn splat(value: f64) -> Self;
    /// `self * b + c`, rounded once.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// The smaller one; `other` where `self` is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger one; `other` where `self` is NaN.
    fn max(self, other: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// e to the power of `self`.
    fn exp(self) -> Self;
    /// Natural logarithm of a positive number.
    fn ln(self) -> Self;
    /// Cosine of an angle from 0 to pi.
    fn cos(self) -> Self;
    /// Angle from 0 to pi of a cosine from -1 to 1.
    fn acos(self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `a` where `mask` holds, else `b`.
    fn select(mask: Self::Mask, a: Self, b: Self) -> Self;
    /// Whether `mask` holds anywhere.
    fn any(mask: Self::Mask) -> bool;
}
