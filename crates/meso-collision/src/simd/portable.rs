//! Vector types for machines without their own: arrays, which the compiler turns into the registers it has.
//!
//! On x86-64 they serve machines without AVX2 alone. Operations that branch or call for each lane are functions there:
//! inlined, they were a third of the crate's code.

use super::bits::Bits;
use super::{Lanes, SLOTS, Simd};
use std::ops::{Add, Div, Mul, Sub};

/// The token of every machine.
#[derive(Clone, Copy)]
pub(crate) struct Portable(());

impl Portable {
    pub(super) fn new() -> Self {
        Self(())
    }
}

impl Simd for Portable {
    type F32 = Lane4<f32>;
    type F64 = Lane4<f64>;
}

const LANES: usize = 4;

/// Four numbers.
#[derive(Clone, Copy)]
pub(crate) struct Lane4<T>([T; LANES]);

macro_rules! operator {
    ($trait:ident, $method:ident) => {
        impl<T: Copy + $trait<Output = T>> $trait for Lane4<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(std::array::from_fn(|l| self.0[l].$method(other.0[l])))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

macro_rules! lanes {
    ($t:ty, $bits:ty) => {
        impl Lanes for Lane4<$t> {
            type T = $t;
            type Token = Portable;
            type Mask = Bits;
            type Lane4 = [$t; LANES];
            const LANES: usize = LANES;

            #[inline(always)]
            fn to_array(self) -> [$t; LANES] {
                self.0
            }

            #[inline(always)]
            fn all(_: Portable, value: $t) -> Self {
                Self([value; LANES])
            }

            #[inline(always)]
            fn of_lanes(_: Portable, lane: impl Fn(usize) -> $t) -> Self {
                Self(std::array::from_fn(lane))
            }

            #[cfg_attr(target_arch = "x86_64", inline(never))]
            #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
            fn load(_: Portable, from: &[$t], at: usize) -> Self {
                Self(std::array::from_fn(|l| from[at + l]))
            }

            #[inline(always)]
            fn store(self, to: &mut [$t], at: usize) {
                to[at..at + LANES].copy_from_slice(&self.0);
            }

            #[cfg_attr(target_arch = "x86_64", inline(never))]
            #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
            fn times_plus(self, factor: Self, term: Self) -> Self {
                Self(std::array::from_fn(|l| self.0[l].mul_add(factor.0[l], term.0[l])))
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                Self(self.0.map(<$t>::sqrt))
            }

            #[cfg_attr(target_arch = "x86_64", inline(never))]
            #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
            fn max(self, other: Self) -> Self {
                Self(std::array::from_fn(|l| if self.0[l] > other.0[l] { self.0[l] } else { other.0[l] }))
            }

            #[cfg_attr(target_arch = "x86_64", inline(never))]
            #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
            fn above(self, other: Self) -> Bits {
                Bits((0..LANES).fold(0, |mask, l| mask | u32::from(self.0[l] > other.0[l]) << l))
            }

            #[cfg_attr(target_arch = "x86_64", inline(never))]
            #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
            fn or(self, mask: Bits, other: Self) -> Self {
                Self(std::array::from_fn(|l| if mask.0 >> l & 1 == 1 { other.0[l] } else { self.0[l] }))
            }

            #[cfg_attr(target_arch = "x86_64", inline(never))]
            #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
            fn front(self, mask: u32) -> Self {
                let mut front = self;
                let mut end = 0;
                super::for_each_lane(mask, |l| {
                    front.0[end] = self.0[l];
                    end += 1;
                });
                front
            }

            #[cfg_attr(target_arch = "x86_64", inline(never))]
            #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
            fn keyed(self, at: usize) -> Self {
                let key = |l: usize| self.0[l].to_bits() & !(SLOTS as $bits - 1) | (at + l) as $bits;
                Self(std::array::from_fn(|l| <$t>::from_bits(key(l))))
            }

            #[inline(always)]
            fn largest(self) -> $t {
                let [a, b, c, d] = self.0;
                let (p, q) = (if a > b { a } else { b }, if c > d { c } else { d });
                if p > q { p } else { q }
            }
        }
    };
}
lanes!(f32, u32);
lanes!(f64, u64);
