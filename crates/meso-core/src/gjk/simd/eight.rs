//! Eight numbers side by side in one AVX-512 register, and eight vectors in three.
//!
//! Made only where AVX-512 was detected: by `glance` and `lockstep`, which are reached through `simd` alone.

use crate::math::Vec3;
use std::arch::x86_64::*;

pub(super) const LANES: usize = 8;

/// One number for each of eight pairs.
#[derive(Clone, Copy)]
pub(super) struct Eight(pub(super) __m512d);

/// One vector for each of eight pairs.
#[derive(Clone, Copy)]
pub(super) struct Vectors {
    pub(super) x: Eight,
    pub(super) y: Eight,
    pub(super) z: Eight,
}

macro_rules! operator {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl std::ops::$trait for Eight {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: made only where AVX-512 was detected; so for all of this file.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}
operator!(Add, add, _mm512_add_pd);
operator!(Sub, sub, _mm512_sub_pd);
operator!(Mul, mul, _mm512_mul_pd);
operator!(Div, div, _mm512_div_pd);

impl Eight {
    #[inline(always)]
    pub(super) fn all(value: f64) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_set1_pd(value) })
    }

    /// Bit mask of the lanes where `self` is larger; false for NaN.
    #[inline(always)]
    pub(super) fn above(self, other: Self) -> u8 {
        // SAFETY: see `operator`.
        unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    pub(super) fn abs(self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    /// `other` in the lanes of the mask.
    #[inline(always)]
    pub(super) fn or(self, mask: u8, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_mask_mov_pd(self.0, mask, other.0) })
    }

    #[inline(always)]
    pub(super) fn load(from: &[f64], at: usize) -> Self {
        assert!(at + LANES <= from.len());
        // SAFETY: eight numbers are there.
        Self(unsafe { _mm512_loadu_pd(from.as_ptr().add(at)) })
    }

    #[inline(always)]
    pub(super) fn store(self, to: &mut [f64], at: usize) {
        assert!(at + LANES <= to.len());
        // SAFETY: there is room for eight numbers.
        unsafe { _mm512_storeu_pd(to.as_mut_ptr().add(at), self.0) };
    }

    /// self * factor + term, rounded once.
    #[inline(always)]
    pub(super) fn times_plus(self, factor: Self, term: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_fmadd_pd(self.0, factor.0, term.0) })
    }

    /// self * factor - term, rounded once.
    #[inline(always)]
    pub(super) fn times_minus(self, factor: Self, term: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_fmsub_pd(self.0, factor.0, term.0) })
    }

    /// The number `of` gives for each lane.
    #[inline(always)]
    pub(super) fn from_lanes(of: impl Fn(usize) -> f64) -> Self {
        let [a, b, c, d] = [of(0), of(1), of(2), of(3)];
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_set_pd(of(7), of(6), of(5), of(4), d, c, b, a) })
    }

    #[inline(always)]
    pub(super) fn sqrt(self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }

    /// The lanes of the mask filled, from the first on, with what lies at `at`.
    #[inline(always)]
    pub(super) fn refilled(self, mask: u8, from: &[f64], at: usize) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_mask_expand_pd(self.0, mask, Self::load(from, at).0) })
    }

    /// The lanes of the mask, moved to the front.
    #[inline(always)]
    pub(super) fn front(self, mask: u8) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_maskz_compress_pd(mask, self.0) })
    }
}

impl std::ops::Sub for Vectors {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl std::ops::Add for Vectors {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl std::ops::Neg for Vectors {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let zero = Eight::all(0.0);
        Self { x: zero - self.x, y: zero - self.y, z: zero - self.z }
    }
}

impl Vectors {
    /// The vector `of` gives for each lane.
    #[inline(always)]
    pub(super) fn from_lanes<'a>(of: impl Fn(usize) -> &'a Vec3) -> Self {
        Self { x: Eight::from_lanes(|l| of(l).x), y: Eight::from_lanes(|l| of(l).y), z: Eight::from_lanes(|l| of(l).z) }
    }

    /// Its three columns in memory.
    #[inline(always)]
    pub(super) fn columns(self) -> [[f64; LANES]; 3] {
        let mut columns = [[0.0; LANES]; 3];
        self.x.store(&mut columns[0], 0);
        self.y.store(&mut columns[1], 0);
        self.z.store(&mut columns[2], 0);
        columns
    }

    /// The lanes of the mask filled from three columns, as [`Eight::refilled`].
    #[inline(always)]
    pub(super) fn refilled<const N: usize>(self, mask: u8, from: &[[f64; N]], column: usize, at: usize) -> Self {
        Self {
            x: self.x.refilled(mask, &from[column], at),
            y: self.y.refilled(mask, &from[column + 1], at),
            z: self.z.refilled(mask, &from[column + 2], at),
        }
    }

    /// |x| + |y| + |z|.
    #[inline(always)]
    pub(super) fn norm1(self) -> Eight {
        self.x.abs() + self.y.abs() + self.z.abs()
    }

    /// Fused: a rounding less than the bounds of `certificate` allow for.
    #[inline(always)]
    pub(super) fn dot(self, o: Self) -> Eight {
        self.x.times_plus(o.x, self.y.times_plus(o.y, self.z * o.z))
    }

    #[inline(always)]
    pub(super) fn cross(self, o: Self) -> Self {
        Self {
            x: self.y.times_minus(o.z, self.z * o.y),
            y: self.z.times_minus(o.x, self.x * o.z),
            z: self.x.times_minus(o.y, self.y * o.x),
        }
    }

    #[inline(always)]
    pub(super) fn or(self, mask: u8, o: Self) -> Self {
        Self { x: self.x.or(mask, o.x), y: self.y.or(mask, o.y), z: self.z.or(mask, o.z) }
    }
}
