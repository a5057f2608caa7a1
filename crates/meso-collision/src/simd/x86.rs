//! Vector types of x86-64: AVX2 with FMA, and AVX-512.

use super::bits::Bits;
use super::slots::{SLOTS_32, SLOTS_64};
use super::{Lanes, Mask, SLOTS, Simd, Vectorized};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// The token of AVX2 and FMA: made in [`on_avx2`] alone.
#[derive(Clone, Copy)]
pub(crate) struct Avx2(());

/// The token of AVX-512: made in [`on_avx512`] alone.
#[derive(Clone, Copy)]
pub(crate) struct Avx512(());

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn on_avx2<V: Vectorized>(work: V) -> V::Output {
    work.run(Avx2(()))
}

#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(super) fn on_avx512<V: Vectorized>(work: V) -> V::Output {
    work.run(Avx512(()))
}

impl Simd for Avx2 {
    type F32 = F32x8;
    type F64 = F64x4;
}

impl Simd for Avx512 {
    type F32 = F32x16;
    type F64 = F64x8;
}

/// For each mask of eight lanes, a byte per lane: the lane to take so that those of the mask come first.
static TO_FRONT: [u64; 256] = to_front();

/// Permutations like [`TO_FRONT`], for each mask of four lanes of 64 bits: a lane is two of 32.
static PAIRS_TO_FRONT: [u64; 16] = pairs_to_front();

const fn pairs_to_front() -> [u64; 16] {
    let (all, mut pairs, mut mask) = (to_front(), [0; 16], 0);
    while mask < 16 {
        let in_pairs = ((mask & 1) * 3) | ((mask >> 1 & 1) * 12) | ((mask >> 2 & 1) * 48) | ((mask >> 3 & 1) * 192);
        pairs[mask] = all[in_pairs];
        mask += 1;
    }
    pairs
}

const fn to_front() -> [u64; 256] {
    let mut all = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut taken) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                all[mask] |= lane << (8 * taken);
                taken += 1;
            }
            lane += 1;
        }
        mask += 1;
    }
    all
}

macro_rules! operator {
    ($name:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for $name {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: a value is made from a token, which is made where the instructions were detected; so for all
                // operations of this file. Loads and stores assert that the memory is there.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

/// Masks of AVX2: the signs of the lanes.
macro_rules! mask {
    ($name:ident($register:ty), [$and:ident, $or:ident, $andnot:ident, $movemask:ident]) => {
        /// Lanes, chosen.
        #[derive(Clone, Copy)]
        pub(crate) struct $name($register);
        operator!($name, BitAnd, bitand, $and);
        operator!($name, BitOr, bitor, $or);

        impl Mask for $name {
            #[inline(always)]
            fn but_not(self, other: Self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $andnot(other.0, self.0) })
            }

            #[inline(always)]
            fn bits(self) -> u32 {
                // SAFETY: see `operator`.
                unsafe { $movemask(self.0) as u32 }
            }
        }
    };
}
mask! { M32x8(__m256), [_mm256_and_ps, _mm256_or_ps, _mm256_andnot_ps, _mm256_movemask_ps] }
mask! { M64x4(__m256d), [_mm256_and_pd, _mm256_or_pd, _mm256_andnot_pd, _mm256_movemask_pd] }

macro_rules! lanes {
    (
        $name:ident($register:ty), $lanes:literal of $t:ty, with $token:ty, $mask:ty,
        [$add:ident, $sub:ident, $mul:ident, $div:ident, $max:ident, $sqrt:ident, $fmadd:ident],
        [$set1:ident, $setr:ident($($lane:literal)*), $loadu:ident, $storeu:ident],
        $($special:item)*
    ) => {
        /// A register.
        #[derive(Clone, Copy)]
        pub(crate) struct $name($register);
        operator!($name, Add, add, $add);
        operator!($name, Sub, sub, $sub);
        operator!($name, Mul, mul, $mul);
        operator!($name, Div, div, $div);

        impl Lanes for $name {
            type T = $t;
            type Token = $token;
            type Mask = $mask;
            type Lane4 = [$t; $lanes];
            const LANES: usize = $lanes;

            #[inline(always)]
            fn to_array(self) -> [$t; $lanes] {
                let mut array = [0.0; $lanes];
                self.store(&mut array, 0);
                array
            }

            #[inline(always)]
            fn all(_: $token, value: $t) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $set1(value) })
            }

            #[inline(always)]
            fn of_lanes(_: $token, lane: impl Fn(usize) -> $t) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $setr($(lane($lane)),*) })
            }

            #[inline(always)]
            fn load(_: $token, from: &[$t], at: usize) -> Self {
                assert!(at + $lanes <= from.len());
                // SAFETY: the numbers are there.
                Self(unsafe { $loadu(from.as_ptr().add(at).cast()) })
            }

            #[inline(always)]
            fn store(self, to: &mut [$t], at: usize) {
                assert!(at + $lanes <= to.len());
                // SAFETY: there is room.
                unsafe { $storeu(to.as_mut_ptr().add(at).cast(), self.0) };
            }

            #[inline(always)]
            fn times_plus(self, factor: Self, term: Self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $fmadd(self.0, factor.0, term.0) })
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $sqrt(self.0) })
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $max(self.0, other.0) })
            }

            $($special)*
        }
    };
}

lanes! {
    F32x8(__m256), 8 of f32, with Avx2, M32x8,
    [_mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps, _mm256_max_ps, _mm256_sqrt_ps, _mm256_fmadd_ps],
    [_mm256_set1_ps, _mm256_setr_ps(0 1 2 3 4 5 6 7), _mm256_loadu_ps, _mm256_storeu_ps],

    #[inline(always)]
    fn above(self, other: Self) -> M32x8 {
        // SAFETY: see `operator`.
        M32x8(unsafe { _mm256_cmp_ps::<_CMP_GT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn or(self, mask: M32x8, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { settled(_mm256_blendv_ps(self.0, other.0, mask.0)) })
    }

    #[inline(always)]
    fn front(self, mask: u32) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm256_permutevar8x32_ps(self.0, permutation(&TO_FRONT, mask)) })
    }

    #[inline(always)]
    fn keyed(self, at: usize) -> Self {
        // SAFETY: see `operator`.
        unsafe {
            let mask = _mm256_castsi256_ps(_mm256_set1_epi32(SLOTS as i32 - 1));
            let slots = _mm256_loadu_ps(SLOTS_32.0[at..at + 8].as_ptr().cast());
            Self(_mm256_or_ps(_mm256_andnot_ps(mask, self.0), slots))
        }
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        // SAFETY: see `operator`.
        unsafe {
            let four = _mm_max_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
            let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
        }
    }

}

/// Returns the register, opaque to the optimiser: else it makes a masked store of a blend that is stored, which takes
/// AMD's machines some 20 cycles.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn settled(mut register: __m256) -> __m256 {
    // SAFETY: nothing is done.
    unsafe { std::arch::asm!("/* {0} */", inout(ymm_reg) register, options(pure, nomem, nostack, preserves_flags)) };
    register
}

#[inline(always)]
unsafe fn permutation<const N: usize>(table: &[u64; N], mask: u32) -> __m256i {
    // SAFETY: called on AVX2.
    unsafe { _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(table[mask as usize & (N - 1)] as i64)) }
}

lanes! {
    F64x4(__m256d), 4 of f64, with Avx2, M64x4,
    [_mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd, _mm256_max_pd, _mm256_sqrt_pd, _mm256_fmadd_pd],
    [_mm256_set1_pd, _mm256_setr_pd(0 1 2 3), _mm256_loadu_pd, _mm256_storeu_pd],

    #[inline(always)]
    fn above(self, other: Self) -> M64x4 {
        // SAFETY: see `operator`.
        M64x4(unsafe { _mm256_cmp_pd::<_CMP_GT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn or(self, mask: M64x4, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm256_blendv_pd(self.0, other.0, mask.0) })
    }

    #[inline(always)]
    fn front(self, mask: u32) -> Self {
        // SAFETY: see `operator`.
        unsafe {
            let halves = _mm256_permutevar8x32_ps(_mm256_castpd_ps(self.0), permutation(&PAIRS_TO_FRONT, mask));
            Self(_mm256_castps_pd(halves))
        }
    }

    #[inline(always)]
    fn keyed(self, at: usize) -> Self {
        // SAFETY: see `operator`.
        unsafe {
            let mask = _mm256_castsi256_pd(_mm256_set1_epi64x(SLOTS as i64 - 1));
            let slots = _mm256_loadu_pd(SLOTS_64.0[at..at + 4].as_ptr().cast());
            Self(_mm256_or_pd(_mm256_andnot_pd(mask, self.0), slots))
        }
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        // SAFETY: see `operator`.
        unsafe {
            let two = _mm_max_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
            _mm_cvtsd_f64(_mm_max_sd(two, _mm_unpackhi_pd(two, two)))
        }
    }

}

lanes! {
    F32x16(__m512), 16 of f32, with Avx512, Bits,
    [_mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_div_ps, _mm512_max_ps, _mm512_sqrt_ps, _mm512_fmadd_ps],
    [_mm512_set1_ps, _mm512_setr_ps(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15), _mm512_loadu_ps, _mm512_storeu_ps],

    #[inline(always)]
    fn above(self, other: Self) -> Bits {
        // SAFETY: see `operator`.
        Bits(unsafe { u32::from(_mm512_cmp_ps_mask::<_CMP_GT_OQ>(self.0, other.0)) })
    }

    #[inline(always)]
    fn or(self, mask: Bits, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_mask_mov_ps(self.0, mask.0 as u16, other.0) })
    }

    #[inline(always)]
    fn front(self, mask: u32) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_maskz_compress_ps(mask as u16, self.0) })
    }

    #[inline(always)]
    fn keyed(self, at: usize) -> Self {
        // SAFETY: see `operator`. Bits of the slot where the mask is set, of the height elsewhere.
        unsafe {
            let (mask, slots) =
                (_mm512_set1_epi32(SLOTS as i32 - 1), _mm512_loadu_si512(SLOTS_32.0[at..at + 16].as_ptr().cast()));
            let key = _mm512_ternarylogic_epi32::<0xCA>(mask, slots, _mm512_castps_si512(self.0));
            Self(_mm512_castsi512_ps(key))
        }
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        // SAFETY: see `operator`.
        unsafe {
            let eight = _mm256_max_ps(_mm512_castps512_ps256(self.0), _mm512_extractf32x8_ps::<1>(self.0));
            let four = _mm_max_ps(_mm256_castps256_ps128(eight), _mm256_extractf128_ps::<1>(eight));
            let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
            _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
        }
    }

}

lanes! {
    F64x8(__m512d), 8 of f64, with Avx512, Bits,
    [_mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd, _mm512_max_pd, _mm512_sqrt_pd, _mm512_fmadd_pd],
    [_mm512_set1_pd, _mm512_setr_pd(0 1 2 3 4 5 6 7), _mm512_loadu_pd, _mm512_storeu_pd],

    #[inline(always)]
    fn above(self, other: Self) -> Bits {
        // SAFETY: see `operator`.
        Bits(unsafe { u32::from(_mm512_cmp_pd_mask::<_CMP_GT_OQ>(self.0, other.0)) })
    }

    #[inline(always)]
    fn or(self, mask: Bits, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_mask_mov_pd(self.0, mask.0 as u8, other.0) })
    }

    #[inline(always)]
    fn front(self, mask: u32) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_maskz_compress_pd(mask as u8, self.0) })
    }

    #[inline(always)]
    fn keyed(self, at: usize) -> Self {
        // SAFETY: see `operator`. Bits of the slot where the mask is set, of the height elsewhere.
        unsafe {
            let (mask, slots) =
                (_mm512_set1_epi64(SLOTS as i64 - 1), _mm512_loadu_si512(SLOTS_64.0[at..at + 8].as_ptr().cast()));
            let key = _mm512_ternarylogic_epi64::<0xCA>(mask, slots, _mm512_castpd_si512(self.0));
            Self(_mm512_castsi512_pd(key))
        }
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        // SAFETY: see `operator`.
        unsafe { _mm512_reduce_max_pd(self.0) }
    }

}
