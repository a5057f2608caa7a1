//! Lanes as an array, for compilers to turn into registers.

use super::{LANES, Lanes, Octet, Places, Short, Vectors};
use crate::real::Real;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Eight f32.
#[derive(Clone, Copy)]
pub(super) struct Portable([f32; LANES]);

/// Where a comparison holds.
#[derive(Clone, Copy)]
pub(super) struct Mask([bool; LANES]);

impl Portable {
    #[inline(always)]
    fn each(self, of: impl Fn(f32) -> f32) -> Self {
        Self(self.0.map(of))
    }

    #[inline(always)]
    fn with(self, other: Self, of: impl Fn(f32, f32) -> f32) -> Self {
        Self(std::array::from_fn(|lane| of(self.0[lane], other.0[lane])))
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident) => {
        impl $trait for Portable {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.with(other, $trait::$name)
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

impl Neg for Portable {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.each(Neg::neg)
    }
}

macro_rules! logic {
    ($trait:ident, $name:ident) => {
        impl $trait for Mask {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self(std::array::from_fn(|lane| self.0[lane].$name(other.0[lane])))
            }
        }
    };
}
logic!(BitAnd, bitand);
logic!(BitOr, bitor);

impl Not for Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Self(self.0.map(Not::not))
    }
}

impl Real for Portable {
    type Mask = Mask;
    const SINGLE: bool = true;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self([value as f32; LANES])
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(std::array::from_fn(|lane| self.0[lane].mul_add(b.0[lane], c.0[lane])))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.with(other, Real::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.with(other, Real::max)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.each(f32::abs)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.each(f32::sqrt)
    }
    #[inline(always)]
    fn round(self) -> Self {
        self.each(f32::round_ties_even)
    }
    #[inline(always)]
    fn pow2(self) -> Self {
        self.each(Real::pow2)
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        let parts = self.0.map(Real::split);
        (Self(parts.map(|part| part.0)), Self(parts.map(|part| part.1)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask {
        Mask(std::array::from_fn(|lane| self.0[lane] < other.0[lane]))
    }
    #[inline(always)]
    fn select(mask: Mask, a: Self, b: Self) -> Self {
        Self(std::array::from_fn(|lane| if mask.0[lane] { a.0[lane] } else { b.0[lane] }))
    }
    #[inline(always)]
    fn any(mask: Mask) -> bool {
        mask.0.contains(&true)
    }
}

impl Lanes for Portable {
    // On arm64 these lanes become NEON.
    const IS_FALLBACK: bool = cfg!(target_arch = "x86_64");

    #[inline(always)]
    fn load(from: &Octet) -> Self {
        Self(from.0)
    }
    #[inline(always)]
    fn load_short(from: &Short) -> Self {
        Self(from.0.map(f32::from))
    }
    #[inline(always)]
    fn store(self, to: &mut Octet) {
        to.0 = self.0;
    }
    #[inline(always)]
    fn relative(vector: &[f64; 3], origin: &[f64; 4]) -> [f32; 4] {
        [(vector[0] - origin[0]) as f32, (vector[1] - origin[1]) as f32, (vector[2] - origin[2]) as f32, 0.0]
    }
    #[inline(always)]
    fn gather(nodes: &Vectors, at: &Places) -> [Self; 3] {
        let at = at.nodes();
        std::array::from_fn(|axis| Self(at.map(|node| nodes[usize::from(node)][axis])))
    }
    #[inline(always)]
    fn scatter(nodes: &mut Vectors, at: &Places, [x, y, z]: [Self; 3]) {
        for (lane, at) in at.nodes().into_iter().enumerate() {
            let node = &mut nodes[usize::from(at)];
            let vector = [x.0[lane], y.0[lane], z.0[lane], z.0[lane]];
            *node = std::array::from_fn(|i| node[i] + vector[i]);
        }
    }
}
