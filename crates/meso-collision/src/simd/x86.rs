//! Vector types of x86-64: AVX2 with FMA, and AVX-512.

use super::bits::Bits;
use super::slots::{SLOTS_32, SLOTS_64};
use super::{Each, Lanes, Lockstep, MOST_LANES, Mask, Row, SLOTS, Simd, Vectorized};
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
    const LOCKSTEP_PAYS: bool = true;

    #[inline(always)]
    fn columns(self, rows: &[&[f32; 8]; MOST_LANES]) -> [F64x4; 8] {
        // SAFETY: see `operator`; a row is eight floats.
        unsafe {
            let (r0, r1) = (_mm256_loadu_ps(rows[0].as_ptr()), _mm256_loadu_ps(rows[1].as_ptr()));
            let (r2, r3) = (_mm256_loadu_ps(rows[2].as_ptr()), _mm256_loadu_ps(rows[3].as_ptr()));
            let (p0, p1) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
            let (p2, p3) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
            let (q0, q1) = (_mm256_shuffle_ps::<0x44>(p0, p2), _mm256_shuffle_ps::<0xEE>(p0, p2));
            let (q2, q3) = (_mm256_shuffle_ps::<0x44>(p1, p3), _mm256_shuffle_ps::<0xEE>(p1, p3));
            [
                F64x4(_mm256_cvtps_pd(_mm256_castps256_ps128(q0))),
                F64x4(_mm256_cvtps_pd(_mm256_castps256_ps128(q1))),
                F64x4(_mm256_cvtps_pd(_mm256_castps256_ps128(q2))),
                F64x4(_mm256_cvtps_pd(_mm256_castps256_ps128(q3))),
                F64x4(_mm256_cvtps_pd(_mm256_extractf128_ps::<1>(q0))),
                F64x4(_mm256_cvtps_pd(_mm256_extractf128_ps::<1>(q1))),
                F64x4(_mm256_cvtps_pd(_mm256_extractf128_ps::<1>(q2))),
                F64x4(_mm256_cvtps_pd(_mm256_extractf128_ps::<1>(q3))),
            ]
        }
    }

    #[inline(always)]
    fn narrow_columns(self, rows: &[&[f32; 8]; MOST_LANES]) -> [F32x8; 8] {
        let [r0, r1, r2, r3, r4, r5, r6, r7, ..] = *rows;
        // SAFETY: see `operator`.
        unsafe { columns_of_eight([r0, r1, r2, r3, r4, r5, r6, r7]) }.map(F32x8)
    }

    #[inline(always)]
    fn coordinates(self, vectors: &[&[f64; 3]; MOST_LANES]) -> [F64x4; 3] {
        let [v0, v1, v2, v3, ..] = *vectors;
        // SAFETY: see `operator`.
        unsafe { coordinates_of_four([v0, v1, v2, v3]) }.map(F64x4)
    }

    #[inline(always)]
    fn store_rows(self, columns: [F64x4; 7], first: u32, mask: u32, rows: &mut [Row]) -> usize {
        // SAFETY: see `operator`.
        unsafe { store_four_rows(columns.map(|column| _mm256_cvtpd_ps(column.0)), first, mask, rows) }
    }
}

impl Simd for Avx512 {
    type F32 = F32x16;
    type F64 = F64x8;
    const LOCKSTEP_PAYS: bool = true;

    #[inline(always)]
    fn columns(self, rows: &[&[f32; 8]; MOST_LANES]) -> [F64x8; 8] {
        // SAFETY: see `operator`; a row is eight floats.
        unsafe {
            let (r0, r1) = (_mm256_loadu_ps(rows[0].as_ptr()), _mm256_loadu_ps(rows[1].as_ptr()));
            let (r2, r3) = (_mm256_loadu_ps(rows[2].as_ptr()), _mm256_loadu_ps(rows[3].as_ptr()));
            let (r4, r5) = (_mm256_loadu_ps(rows[4].as_ptr()), _mm256_loadu_ps(rows[5].as_ptr()));
            let (r6, r7) = (_mm256_loadu_ps(rows[6].as_ptr()), _mm256_loadu_ps(rows[7].as_ptr()));
            let (p0, p1) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
            let (p2, p3) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
            let (p4, p5) = (_mm256_unpacklo_ps(r4, r5), _mm256_unpackhi_ps(r4, r5));
            let (p6, p7) = (_mm256_unpacklo_ps(r6, r7), _mm256_unpackhi_ps(r6, r7));
            let (q0, q1) = (_mm256_shuffle_ps::<0x44>(p0, p2), _mm256_shuffle_ps::<0xEE>(p0, p2));
            let (q2, q3) = (_mm256_shuffle_ps::<0x44>(p1, p3), _mm256_shuffle_ps::<0xEE>(p1, p3));
            let (q4, q5) = (_mm256_shuffle_ps::<0x44>(p4, p6), _mm256_shuffle_ps::<0xEE>(p4, p6));
            let (q6, q7) = (_mm256_shuffle_ps::<0x44>(p5, p7), _mm256_shuffle_ps::<0xEE>(p5, p7));
            [
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q0, q4))),
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q1, q5))),
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q2, q6))),
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x20>(q3, q7))),
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q0, q4))),
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q1, q5))),
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q2, q6))),
                F64x8(_mm512_cvtps_pd(_mm256_permute2f128_ps::<0x31>(q3, q7))),
            ]
        }
    }

    #[inline(always)]
    fn narrow_columns(self, rows: &[&[f32; 8]; MOST_LANES]) -> [F32x16; 8] {
        let [r0, r1, r2, r3, r4, r5, r6, r7, s0, s1, s2, s3, s4, s5, s6, s7] = *rows;
        // SAFETY: see `operator`.
        unsafe {
            let low = columns_of_eight([r0, r1, r2, r3, r4, r5, r6, r7]);
            let high = columns_of_eight([s0, s1, s2, s3, s4, s5, s6, s7]);
            std::array::from_fn(|c| F32x16(_mm512_insertf32x8::<1>(_mm512_castps256_ps512(low[c]), high[c])))
        }
    }

    #[inline(always)]
    fn coordinates(self, vectors: &[&[f64; 3]; MOST_LANES]) -> [F64x8; 3] {
        let [v0, v1, v2, v3, v4, v5, v6, v7, ..] = *vectors;
        // SAFETY: see `operator`.
        unsafe {
            let (low, high) = (coordinates_of_four([v0, v1, v2, v3]), coordinates_of_four([v4, v5, v6, v7]));
            std::array::from_fn(|c| F64x8(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low[c]), high[c])))
        }
    }

    #[inline(always)]
    fn store_rows(self, columns: [F64x8; 7], first: u32, mask: u32, rows: &mut [Row]) -> usize {
        // SAFETY: see `operator`.
        unsafe {
            let narrow = columns.map(|column| _mm512_cvtpd_ps(column.0));
            let low = narrow.map(|column| _mm256_castps256_ps128(column));
            let high = narrow.map(|column| _mm256_extractf128_ps::<1>(column));
            let taken = store_four_rows(low, first, mask, rows);
            taken + store_four_rows(high, first + 4, mask >> 4, &mut rows[taken..])
        }
    }
}

/// The columns of eight rows.
///
/// # Safety
/// On AVX2.
#[inline(always)]
unsafe fn columns_of_eight(rows: [&[f32; 8]; 8]) -> [__m256; 8] {
    // SAFETY: on AVX2; a row is eight floats, of which four are loaded from 0 or 4 on.
    unsafe {
        let pair = |i: usize, at: usize| {
            let (low, high) = (rows[i].as_ptr().add(at), rows[i + 4].as_ptr().add(at));
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(_mm_loadu_ps(low)), _mm_loadu_ps(high))
        };
        let [c0, c1, c2, c3] = transposed([pair(0, 0), pair(1, 0), pair(2, 0), pair(3, 0)]);
        let [c4, c5, c6, c7] = transposed([pair(0, 4), pair(1, 4), pair(2, 4), pair(3, 4)]);
        [c0, c1, c2, c3, c4, c5, c6, c7]
    }
}

/// Columns for rows, of four numbers in each 128 bits.
///
/// # Safety
/// On AVX2.
#[inline(always)]
unsafe fn transposed([r0, r1, r2, r3]: [__m256; 4]) -> [__m256; 4] {
    // SAFETY: on AVX2.
    unsafe {
        let (p0, p1) = (_mm256_unpacklo_ps(r0, r1), _mm256_unpackhi_ps(r0, r1));
        let (p2, p3) = (_mm256_unpacklo_ps(r2, r3), _mm256_unpackhi_ps(r2, r3));
        [
            _mm256_shuffle_ps::<0x44>(p0, p2),
            _mm256_shuffle_ps::<0xEE>(p0, p2),
            _mm256_shuffle_ps::<0x44>(p1, p3),
            _mm256_shuffle_ps::<0xEE>(p1, p3),
        ]
    }
}

/// The coordinates of four vectors.
///
/// # Safety
/// On AVX2.
#[inline(always)]
unsafe fn coordinates_of_four([v0, v1, v2, v3]: [&[f64; 3]; 4]) -> [__m256d; 3] {
    // SAFETY: on AVX2; of the three numbers of a vector two are loaded from 0 on.
    unsafe {
        let pair = |low: &[f64; 3], high: &[f64; 3]| {
            let low = _mm256_castpd128_pd256(_mm_loadu_pd(low.as_ptr()));
            _mm256_insertf128_pd::<1>(low, _mm_loadu_pd(high.as_ptr()))
        };
        let (even, odd) = (pair(v0, v2), pair(v1, v3));
        let z = _mm256_setr_pd(v0[2], v1[2], v2[2], v3[2]);
        [_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd), z]
    }
}

/// See [`Simd::store_rows`].
///
/// # Safety
/// On AVX2.
#[inline(always)]
unsafe fn store_four_rows(columns: [__m128; 7], first: u32, mask: u32, rows: &mut [Row]) -> usize {
    let rows = &mut rows[..4];
    let [c0, c1, c2, c3, c4, c5, c6] = columns;
    // SAFETY: on AVX2; there is room for four rows, and no more than three are taken before the last.
    unsafe {
        let both = |low, high| _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high);
        let question = _mm_castsi128_ps(_mm_add_epi32(_mm_set1_epi32(first as i32), _mm_setr_epi32(0, 1, 2, 3)));
        let mut taken = 0;
        for (l, row) in
            transposed([both(c0, c4), both(c1, c5), both(c2, c6), both(c3, question)]).into_iter().enumerate()
        {
            _mm256_store_ps(rows.as_mut_ptr().add(taken).cast(), row);
            taken += (mask >> l & 1) as usize;
        }
        taken
    }
}

/// For each mask of eight lanes, a byte per lane: the lane to take so that those of the mask come first.
static TO_FRONT: [u64; 256] = permutations(true);
/// The lane to take so that the first ones come to those of the mask.
static FROM_FRONT: [u64; 256] = permutations(false);

/// Permutations like [`TO_FRONT`], for each mask of four lanes of 64 bits: a lane is two of 32.
static PAIRS_TO_FRONT: [u64; 16] = pairs_to_front();

const fn pairs_to_front() -> [u64; 16] {
    let (all, mut pairs, mut mask) = (permutations(true), [0; 16], 0);
    while mask < 16 {
        let in_pairs = ((mask & 1) * 3) | ((mask >> 1 & 1) * 12) | ((mask >> 2 & 1) * 48) | ((mask >> 3 & 1) * 192);
        pairs[mask] = all[in_pairs];
        mask += 1;
    }
    pairs
}

const fn permutations(to_front: bool) -> [u64; 256] {
    let mut all = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let (mut lane, mut taken) = (0, 0);
        while lane < 8 {
            if mask >> lane & 1 == 1 {
                let (from, to) = if to_front { (lane, taken) } else { (taken, lane) };
                all[mask] |= from << (8 * to);
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
        [$add:ident, $sub:ident, $mul:ident, $div:ident, $max:ident, $sqrt:ident, $fmadd:ident, $fmsub:ident],
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
            type Array = [$t; $lanes];
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
            fn times_minus(self, factor: Self, term: Self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $fmsub(self.0, factor.0, term.0) })
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
    [_mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps, _mm256_max_ps, _mm256_sqrt_ps, _mm256_fmadd_ps, _mm256_fmsub_ps],
    [_mm256_set1_ps, _mm256_setr_ps(0 1 2 3 4 5 6 7), _mm256_loadu_ps, _mm256_storeu_ps],

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }

    #[inline(always)]
    fn mask(_: Avx2, bits: u32) -> M32x8 {
        // SAFETY: see `operator`. The sign of each lane tells.
        unsafe {
            let signs = _mm256_sllv_epi32(_mm256_set1_epi32(bits as i32), _mm256_set_epi32(24, 25, 26, 27, 28, 29, 30, 31));
            M32x8(_mm256_castsi256_ps(signs))
        }
    }

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

    #[inline(always)]
    fn largest_of_each<E: Each<Self>>(k: &E) -> Self {
        let u0 = k.register(0).four([k.register(1), k.register(2), k.register(3)]);
        let u1 = k.register(4).four([k.register(5), k.register(6), k.register(7)]);
        // SAFETY: see `operator`.
        Self(unsafe {
            let (low, high) = (_mm256_permute2f128_ps::<0x20>(u0.0, u1.0), _mm256_permute2f128_ps::<0x31>(u0.0, u1.0));
            _mm256_max_ps(low, high)
        })
    }
}

impl Lockstep for F32x8 {
    #[inline(always)]
    fn refilled(self, mask: u32, from: &[f32], at: usize) -> Self {
        assert!(at + 8 <= from.len());
        // SAFETY: the numbers are there.
        let spread = unsafe {
            let from = _mm256_loadu_ps(from.as_ptr().add(at));
            Self(_mm256_permutevar8x32_ps(from, permutation(&FROM_FRONT, mask)))
        };
        self.or(Self::mask(Avx2(()), mask), spread)
    }
}

impl F32x8 {
    /// Per 128 bits: the largest of this register's four numbers, and of three others'.
    #[inline(always)]
    fn four(self, [b, c, d]: [Self; 3]) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe {
            let p = _mm256_max_ps(_mm256_unpacklo_ps(self.0, b.0), _mm256_unpackhi_ps(self.0, b.0));
            let q = _mm256_max_ps(_mm256_unpacklo_ps(c.0, d.0), _mm256_unpackhi_ps(c.0, d.0));
            _mm256_max_ps(_mm256_shuffle_ps::<0x44>(p, q), _mm256_shuffle_ps::<0xEE>(p, q))
        })
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
    [_mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd, _mm256_max_pd, _mm256_sqrt_pd, _mm256_fmadd_pd, _mm256_fmsub_pd],
    [_mm256_set1_pd, _mm256_setr_pd(0 1 2 3), _mm256_loadu_pd, _mm256_storeu_pd],

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn mask(_: Avx2, bits: u32) -> M64x4 {
        // SAFETY: see `operator`. The sign of each lane tells.
        unsafe {
            let signs = _mm256_sllv_epi64(_mm256_set1_epi64x(i64::from(bits)), _mm256_set_epi64x(60, 61, 62, 63));
            M64x4(_mm256_castsi256_pd(signs))
        }
    }

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

    #[inline(always)]
    fn largest_of_each<E: Each<Self>>(k: &E) -> Self {
        let (u0, u1) = (k.register(0).two(k.register(1)), k.register(2).two(k.register(3)));
        // SAFETY: see `operator`.
        Self(unsafe {
            let (low, high) = (_mm256_permute2f128_pd::<0x20>(u0.0, u1.0), _mm256_permute2f128_pd::<0x31>(u0.0, u1.0));
            _mm256_max_pd(low, high)
        })
    }
}

impl F64x4 {
    /// Per 128 bits: the larger of this register's two numbers, and of another's.
    #[inline(always)]
    fn two(self, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm256_max_pd(_mm256_unpacklo_pd(self.0, other.0), _mm256_unpackhi_pd(self.0, other.0)) })
    }
}

lanes! {
    F32x16(__m512), 16 of f32, with Avx512, Bits,
    [_mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_div_ps, _mm512_max_ps, _mm512_sqrt_ps, _mm512_fmadd_ps, _mm512_fmsub_ps],
    [_mm512_set1_ps, _mm512_setr_ps(0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15), _mm512_loadu_ps, _mm512_storeu_ps],

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_abs_ps(self.0) })
    }

    #[inline(always)]
    fn mask(_: Avx512, bits: u32) -> Bits {
        Bits(bits)
    }

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

    #[inline(always)]
    fn largest_of_each<E: Each<Self>>(k: &E) -> Self {
        let u0 = k.register(0).four([k.register(1), k.register(2), k.register(3)]);
        let u1 = k.register(4).four([k.register(5), k.register(6), k.register(7)]);
        let u2 = k.register(8).four([k.register(9), k.register(10), k.register(11)]);
        let u3 = k.register(12).four([k.register(13), k.register(14), k.register(15)]);
        u0.blocks(u1).blocks(u2.blocks(u3))
    }
}

impl Lockstep for F32x16 {
    #[inline(always)]
    fn refilled(self, mask: u32, from: &[f32], at: usize) -> Self {
        assert!(at + 16 <= from.len());
        // SAFETY: the numbers are there.
        Self(unsafe { _mm512_mask_expand_ps(self.0, mask as u16, _mm512_loadu_ps(from.as_ptr().add(at))) })
    }
}

impl F32x16 {
    /// Per 128 bits: the largest of this register's four numbers, and of three others'.
    #[inline(always)]
    fn four(self, [b, c, d]: [Self; 3]) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe {
            let p = _mm512_max_ps(_mm512_unpacklo_ps(self.0, b.0), _mm512_unpackhi_ps(self.0, b.0));
            let q = _mm512_max_ps(_mm512_unpacklo_ps(c.0, d.0), _mm512_unpackhi_ps(c.0, d.0));
            _mm512_max_ps(_mm512_shuffle_ps::<0x44>(p, q), _mm512_shuffle_ps::<0xEE>(p, q))
        })
    }

    /// The larger of neighbouring blocks of 128 bits, of this register and then of the other.
    #[inline(always)]
    fn blocks(self, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe {
            let even = _mm512_shuffle_f32x4::<0b10_00_10_00>(self.0, other.0);
            _mm512_max_ps(even, _mm512_shuffle_f32x4::<0b11_01_11_01>(self.0, other.0))
        })
    }
}

lanes! {
    F64x8(__m512d), 8 of f64, with Avx512, Bits,
    [_mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd, _mm512_max_pd, _mm512_sqrt_pd, _mm512_fmadd_pd, _mm512_fmsub_pd],
    [_mm512_set1_pd, _mm512_setr_pd(0 1 2 3 4 5 6 7), _mm512_loadu_pd, _mm512_storeu_pd],

    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn mask(_: Avx512, bits: u32) -> Bits {
        Bits(bits)
    }

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

    #[inline(always)]
    fn largest_of_each<E: Each<Self>>(k: &E) -> Self {
        let u0 = k.register(0).two(k.register(1)).blocks(k.register(2).two(k.register(3)));
        let u1 = k.register(4).two(k.register(5)).blocks(k.register(6).two(k.register(7)));
        u0.blocks(u1)
    }
}

impl F64x8 {
    /// Per 128 bits: the larger of this register's two numbers, and of another's.
    #[inline(always)]
    fn two(self, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { _mm512_max_pd(_mm512_unpacklo_pd(self.0, other.0), _mm512_unpackhi_pd(self.0, other.0)) })
    }

    /// The larger of neighbouring blocks of 128 bits, of this register and then of the other.
    #[inline(always)]
    fn blocks(self, other: Self) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe {
            let even = _mm512_shuffle_f64x2::<0b10_00_10_00>(self.0, other.0);
            _mm512_max_pd(even, _mm512_shuffle_f64x2::<0b11_01_11_01>(self.0, other.0))
        })
    }
}
