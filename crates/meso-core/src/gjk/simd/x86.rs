//! The kernels of x86-64: one for AVX-512, one for AVX2.

use super::{Body, Extremes, GROUP, Group, INDEX, Kernel, Search};
use crate::math::Vec3;
use std::arch::x86_64::*;

#[target_feature(enable = "avx512f,fma")]
pub(super) fn on_avx512<S: Search>(search: S) -> S::Output {
    search.run(Avx512)
}

#[target_feature(enable = "avx2,fma")]
pub(super) fn on_avx2<S: Search>(search: S) -> S::Output {
    search.run(Avx2)
}

/// Eight points per register. Made only inside [`on_avx512`].
#[derive(Clone, Copy)]
struct Avx512;

impl Kernel for Avx512 {
    #[inline(always)]
    fn extremes(self, a: &Body, b: &Body, v: &Vec3) -> Extremes {
        // SAFETY: this type is made only where AVX-512 was detected.
        unsafe {
            let (keys_a, keys_b) = (keys512(afresh(a.first_group()), v), keys512(afresh(b.first_group()), &-v));
            if a.more_groups().is_empty() && b.more_groups().is_empty() {
                let (top_a, top_b) = (_mm512_reduce_max_pd(keys_a), _mm512_reduce_max_pd(keys_b));
                return found((0, top_a), (0, top_b));
            }
            found(more512(a, v, keys_a), more512(b, &-v, keys_b))
        }
    }
}

/// The same group, of which the compiler knows nothing.
///
/// Else it loads the points once for all supports of a search: into registers that it does not have, hence onto the
/// stack, where a first support took twice its time.
#[inline(always)]
#[allow(clippy::pointers_in_nomem_asm_block, reason = "what it points to is not touched")]
fn afresh(group: &Group) -> &Group {
    let mut at: *const Group = group;
    // SAFETY: nothing is done, so the pointer is what it was.
    unsafe {
        std::arch::asm!("/* {0} */", inout(reg) at, options(nomem, nostack, preserves_flags));
        &*at
    }
}

#[inline(always)]
fn found((first_a, top_a): (u32, f64), (first_b, top_b): (u32, f64)) -> Extremes {
    let index = |key: f64| (key.to_bits() & INDEX) as u32;
    Extremes { a: first_a + index(top_a), b: first_b + index(top_b), top_of_a: top_a, bottom_of_b: -top_b }
}

/// Largest key per lane of a group.
#[inline(always)]
pub(super) unsafe fn keys512(group: &Group, v: &Vec3) -> __m512d {
    // SAFETY: AVX-512 is there (see `Avx512`).
    unsafe {
        let v = [_mm512_set1_pd(v.x), _mm512_set1_pd(v.y), _mm512_set1_pd(v.z)];
        let [k0, k1] = [eight512::<0>(group, v), eight512::<8>(group, v)];
        let [k2, k3] = [eight512::<16>(group, v), eight512::<24>(group, v)];
        _mm512_max_pd(_mm512_max_pd(k0, k1), _mm512_max_pd(k2, k3))
    }
}

/// Heights of the eight points from slot `I`, with their slots in the low bits. (No closures: those do not inherit
/// the instruction set, and every intrinsic in them becomes a call.)
#[inline(always)]
unsafe fn eight512<const I: usize>(Group([x, y, z]): &Group, [vx, vy, vz]: [__m512d; 3]) -> __m512d {
    // SAFETY: AVX-512 is there (see `Avx512`); groups are 64-byte aligned, and I is 0, 8, 16 or 24.
    unsafe {
        let height = _mm512_mul_pd(_mm512_load_pd(x.as_ptr().add(I)), vx);
        let height = _mm512_fmadd_pd(_mm512_load_pd(y.as_ptr().add(I)), vy, height);
        let height = _mm512_fmadd_pd(_mm512_load_pd(z.as_ptr().add(I)), vz, height);
        let index = _mm512_add_epi64(_mm512_set_epi64(7, 6, 5, 4, 3, 2, 1, 0), _mm512_set1_epi64(I as i64));
        // Bits of the index where the mask is set, of the height elsewhere.
        let mask = _mm512_set1_epi64(INDEX as i64);
        _mm512_castsi512_pd(_mm512_ternarylogic_epi64::<0xCA>(mask, index, _mm512_castpd_si512(height)))
    }
}

/// A body of any number of points, after its first group: first slot of the best group, and the best key.
#[inline(never)]
#[target_feature(enable = "avx512f,fma")]
fn more512(body: &Body, v: &Vec3, first: __m512d) -> (u32, f64) {
    let mut best = first;
    let mut group_of_best = _mm512_setzero_si512();
    for (i, group) in body.more_groups().iter().enumerate() {
        // SAFETY: AVX-512 is there, this function asks for it.
        let keys = unsafe { keys512(group, v) };
        let better = _mm512_cmp_pd_mask::<_CMP_GT_OQ>(keys, best);
        best = _mm512_mask_mov_pd(best, better, keys);
        group_of_best = _mm512_mask_set1_epi64(group_of_best, better, i as i64 + 1);
    }
    let top = _mm512_reduce_max_pd(best);
    let mut groups = [0i64; 8];
    // SAFETY: the array holds eight integers.
    unsafe { _mm512_storeu_si512(groups.as_mut_ptr().cast(), group_of_best) };
    let lane = (top.to_bits() & INDEX) as usize % 8;
    (groups[lane] as u32 * GROUP as u32, top)
}

/// Four points per register. Made only inside [`on_avx2`].
#[derive(Clone, Copy)]
struct Avx2;

impl Kernel for Avx2 {
    #[inline(always)]
    fn extremes(self, a: &Body, b: &Body, v: &Vec3) -> Extremes {
        // SAFETY: this type is made only where AVX2 and FMA were detected.
        unsafe { found(top256(a, v), top256(b, &-v)) }
    }
}

#[inline(always)]
unsafe fn top256(body: &Body, v: &Vec3) -> (u32, f64) {
    // SAFETY: AVX2 is there (see `Avx2`).
    unsafe {
        let mut best = (0, reduce256(keys256(afresh(body.first_group()), v)));
        for (i, group) in body.more_groups().iter().enumerate() {
            let key = reduce256(keys256(group, v));
            if key > best.1 {
                best = ((i as u32 + 1) * GROUP as u32, key);
            }
        }
        best
    }
}

/// Largest key per lane of a group.
#[inline(always)]
unsafe fn keys256(group: &Group, v: &Vec3) -> __m256d {
    // SAFETY: AVX2 is there (see `Avx2`).
    unsafe {
        let v = [_mm256_set1_pd(v.x), _mm256_set1_pd(v.y), _mm256_set1_pd(v.z)];
        let [k0, k1] = [eight256::<0>(group, v), eight256::<8>(group, v)];
        let [k2, k3] = [eight256::<16>(group, v), eight256::<24>(group, v)];
        _mm256_max_pd(_mm256_max_pd(k0, k1), _mm256_max_pd(k2, k3))
    }
}

/// The larger keys of slots `I` to `I` + 3 and the next four.
#[inline(always)]
unsafe fn eight256<const I: usize>(group: &Group, v: [__m256d; 3]) -> __m256d {
    // SAFETY: AVX2 is there (see `Avx2`).
    unsafe { _mm256_max_pd(four256(group, I, v), four256(group, I + 4, v)) }
}

#[inline(always)]
unsafe fn four256(Group([x, y, z]): &Group, at: usize, [vx, vy, vz]: [__m256d; 3]) -> __m256d {
    // SAFETY: AVX2 is there (see `Avx2`); `at` is a multiple of four below 32.
    unsafe {
        let height = _mm256_mul_pd(_mm256_load_pd(x.as_ptr().add(at)), vx);
        let height = _mm256_fmadd_pd(_mm256_load_pd(y.as_ptr().add(at)), vy, height);
        let height = _mm256_fmadd_pd(_mm256_load_pd(z.as_ptr().add(at)), vz, height);
        let index = _mm256_add_epi64(_mm256_set_epi64x(3, 2, 1, 0), _mm256_set1_epi64x(at as i64));
        let mask = _mm256_castsi256_pd(_mm256_set1_epi64x(INDEX as i64));
        _mm256_or_pd(_mm256_andnot_pd(mask, height), _mm256_castsi256_pd(index))
    }
}

#[inline(always)]
unsafe fn reduce256(keys: __m256d) -> f64 {
    // SAFETY: AVX2 is there (see `Avx2`).
    unsafe {
        let two = _mm_max_pd(_mm256_castpd256_pd128(keys), _mm256_extractf128_pd::<1>(keys));
        _mm_cvtsd_f64(_mm_max_sd(two, _mm_unpackhi_pd(two, two)))
    }
}
