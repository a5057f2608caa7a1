//! Lanes in one AVX register.
#![allow(unsafe_code)]

use super::{Lanes, Octet, Places, Short, Task, Vectors};
use crate::real::Real;
use meso_collision::simd::Isa;
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Eight f32. Values exist only within [`on_avx2`], which has found the instruction set: that is the safety of every
/// intrinsic below.
#[derive(Clone, Copy)]
pub(super) struct Avx(__m256);

/// All bits set where a comparison holds.
#[derive(Clone, Copy)]
pub(super) struct Mask(__m256);

/// Runs `task` with AVX2 and FMA.
///
/// # Panics
/// On a machine without them.
pub(super) fn on_avx2<T: Task>(task: T) -> T::Output {
    #[target_feature(enable = "avx2,fma")]
    fn run<T: Task>(task: T) -> T::Output {
        task.run::<Avx>()
    }
    assert!(Isa::best() >= Isa::Avx2);
    // SAFETY: the features are there.
    unsafe { run(task) }
}

macro_rules! operator {
    ($trait:ident, $name:ident, $intrinsic:ident) => {
        impl $trait for Avx {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: see `Avx`.
                unsafe { Self($intrinsic(self.0, other.0)) }
            }
        }
    };
}
operator!(Add, add, _mm256_add_ps);
operator!(Sub, sub, _mm256_sub_ps);
operator!(Mul, mul, _mm256_mul_ps);
operator!(Div, div, _mm256_div_ps);

impl Neg for Avx {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see `Avx`.
        unsafe { Self(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0))) }
    }
}

impl BitAnd for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        // SAFETY: see `Avx`.
        unsafe { Self(_mm256_and_ps(self.0, other.0)) }
    }
}

impl BitOr for Mask {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        // SAFETY: see `Avx`.
        unsafe { Self(_mm256_or_ps(self.0, other.0)) }
    }
}

impl Not for Mask {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: see `Avx`.
        unsafe { Self(_mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))) }
    }
}

/// Bits of the root of a half, and where the exponent of an f32 begins.
const ROOT_HALF: i32 = 0x3f35_04f3;
const DIGITS: i32 = 23;

impl Real for Avx {
    type Mask = Mask;
    const SINGLE: bool = true;

    #[inline(always)]
    fn splat(value: f64) -> Self {
        // SAFETY: see `Avx`; so in all of this block.
        unsafe { Self(_mm256_set1_ps(value as f32)) }
    }
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_fmadd_ps(self.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        // SAFETY: as above. The instruction is `if self < other { self } else { other }`.
        unsafe { Self(_mm256_min_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // SAFETY: as above. The instruction is `if self > other { self } else { other }`.
        unsafe { Self(_mm256_max_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_sqrt_ps(self.0)) }
    }
    #[inline(always)]
    fn round(self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_round_ps::<{ _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC }>(self.0)) }
    }
    #[inline(always)]
    fn pow2(self) -> Self {
        // SAFETY: as above.
        unsafe {
            let biased = _mm256_add_epi32(_mm256_cvttps_epi32(self.0), _mm256_set1_epi32(127));
            Self(_mm256_castsi256_ps(_mm256_slli_epi32::<DIGITS>(biased)))
        }
    }
    #[inline(always)]
    fn split(self) -> (Self, Self) {
        // SAFETY: as above.
        unsafe {
            let bits = _mm256_castps_si256(self.0);
            let exponent = _mm256_srai_epi32::<DIGITS>(_mm256_sub_epi32(bits, _mm256_set1_epi32(ROOT_HALF)));
            let mantissa = _mm256_sub_epi32(bits, _mm256_slli_epi32::<DIGITS>(exponent));
            (Self(_mm256_castsi256_ps(mantissa)), Self(_mm256_cvtepi32_ps(exponent)))
        }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask {
        // SAFETY: as above.
        unsafe { Mask(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn select(mask: Mask, a: Self, b: Self) -> Self {
        // SAFETY: as above.
        unsafe { Self(_mm256_blendv_ps(b.0, a.0, mask.0)) }
    }
    #[inline(always)]
    fn any(mask: Mask) -> bool {
        // SAFETY: as above.
        unsafe { _mm256_movemask_ps(mask.0) != 0 }
    }
}

impl Lanes for Avx {
    const IS_FALLBACK: bool = false;

    #[inline(always)]
    fn load(from: &Octet) -> Self {
        // SAFETY: as above; the numbers are aligned and as many as the register holds.
        unsafe { Self(_mm256_load_ps(from.0.as_ptr())) }
    }
    #[inline(always)]
    fn load_short(from: &Short) -> Self {
        // SAFETY: as above; the numbers are aligned and as many as half a register holds.
        unsafe { Self(_mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_load_si128(from.0.as_ptr().cast())))) }
    }
    #[inline(always)]
    fn store(self, to: &mut Octet) {
        // SAFETY: as above; the numbers are aligned and as many as the register holds.
        unsafe { _mm256_store_ps(to.0.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn relative(vector: &[f64; 3], origin: &[f64; 4]) -> [f32; 4] {
        // SAFETY: as above; the mask leaves out what lies beyond the vector.
        unsafe {
            let vector = _mm256_maskload_pd(vector.as_ptr(), _mm256_set_epi64x(0, -1, -1, -1));
            let mut relative = [0.0; 4];
            let difference = _mm256_sub_pd(vector, _mm256_loadu_pd(origin.as_ptr()));
            _mm_storeu_ps(relative.as_mut_ptr(), _mm256_cvtpd_ps(difference));
            relative
        }
    }
    #[inline(always)]
    fn gather(nodes: &Vectors, at: &Places) -> [Self; 3] {
        // SAFETY: as above; every node is four numbers, and its place is an even number of pairs of them.
        unsafe {
            let pairs = nodes.as_ptr().cast::<[f32; 2]>();
            let node = |i: usize| _mm_loadu_ps(pairs.add(at.0[i].into()).cast());
            let pair = |i: usize| _mm256_set_m128(node(i + 4), node(i));
            let (a, b, c, d) = (pair(0), pair(1), pair(2), pair(3));
            let (xy0, xy1) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
            let (z0, z1) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
            [
                Self(_mm256_shuffle_ps::<0x44>(xy0, xy1)),
                Self(_mm256_shuffle_ps::<0xEE>(xy0, xy1)),
                Self(_mm256_shuffle_ps::<0x44>(z0, z1)),
            ]
        }
    }
    #[inline(always)]
    fn scatter(nodes: &mut Vectors, at: &Places, [x, y, z]: [Self; 3]) {
        // SAFETY: as for `gather`. The padding gets z again: zeros would take two more instructions.
        unsafe {
            let pairs = nodes.as_mut_ptr().cast::<[f32; 2]>();
            let (xy0, xy1) = (_mm256_unpacklo_ps(x.0, y.0), _mm256_unpackhi_ps(x.0, y.0));
            let vectors = [
                _mm256_shuffle_ps::<0x04>(xy0, z.0),
                _mm256_shuffle_ps::<0x5E>(xy0, z.0),
                _mm256_shuffle_ps::<0xA4>(xy1, z.0),
                _mm256_shuffle_ps::<0xFE>(xy1, z.0),
            ];
            let add = |i: usize, vector: __m128| {
                let node = pairs.add(at.0[i].into()).cast();
                _mm_storeu_ps(node, _mm_add_ps(_mm_loadu_ps(node), vector));
            };
            (0..4).for_each(|i| add(i, _mm256_castps256_ps128(vectors[i])));
            (0..4).for_each(|i| add(i + 4, _mm256_extractf128_ps::<1>(vectors[i])));
        }
    }
}
