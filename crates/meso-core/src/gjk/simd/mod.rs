//! The support of both bodies of a pair at once, on the widest registers the machine has.
//!
//! The only unsafe code of the crate: `std::arch` loads and the calls into functions compiled for AVX2 or AVX-512,
//! which are reached after detection only. Every kernel does the same correctly rounded operations in the same order
//! (fused multiply-adds, which are exact to define), so that all machines find the same vertices and the same answers.
#![allow(unsafe_code)]

#[cfg(target_arch = "x86_64")]
mod eight;
#[cfg(target_arch = "x86_64")]
mod glance;
#[cfg(target_arch = "x86_64")]
mod lockstep;
mod open;
#[cfg(target_arch = "x86_64")]
mod supports;
#[cfg(target_arch = "x86_64")]
mod x86;

pub(crate) use open::Open;

use super::batch::Ask;
use super::body::{Body, GROUP, Group};
use crate::math::Vec3;

/// The mantissa bits that hold the index of a point within its group.
const INDEX: u64 = GROUP as u64 - 1;

/// The farthest point of A along a direction and the nearest of B, with their heights.
///
/// Heights are short of the true ones by at most 2^-47 of |direction| times the size: see [`HEIGHT_ERROR`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extremes {
    /// Slot in A; padding repeats the first point.
    pub(crate) a: u32,
    /// Slot in B.
    pub(crate) b: u32,
    /// Largest height of a point of A.
    pub(crate) top_of_a: f64,
    /// Smallest height of a point of B.
    pub(crate) bottom_of_b: f64,
}

/// Error of a height over |direction| times the size: 31 ulp for the index in the mantissa, 3 for the dot product,
/// and as much again to spare for what is done with it.
pub(crate) const HEIGHT_ERROR: f64 = 1.0 / (1u64 << 46) as f64;

/// One instruction set's way to find [`Extremes`].
pub(crate) trait Kernel: Copy {
    /// The extremes of the pair along `v`.
    fn extremes(self, a: &Body, b: &Body, v: &Vec3) -> Extremes;
}

/// A search that is compiled once per instruction set.
pub(crate) trait Search {
    /// What it finds.
    type Output;
    /// Runs with the given kernel; must be `#[inline(always)]` to be compiled for the kernel's instruction set.
    fn run<K: Kernel>(self, kernel: K) -> Self::Output;
}

/// Runs `search` on the widest registers there are.
#[inline]
pub(crate) fn dispatch<S: Search>(search: S) -> S::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("fma") {
            // SAFETY: both features were detected.
            return unsafe { x86::on_avx512(search) };
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            // SAFETY: both features were detected.
            return unsafe { x86::on_avx2(search) };
        }
    }
    search.run(Portable)
}

/// The kernel for any machine.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl Kernel for Portable {
    #[inline(always)]
    fn extremes(self, a: &Body, b: &Body, v: &Vec3) -> Extremes {
        let ((a, top_of_a), (b, top_of_b)) = (portable_top(a, v), portable_top(b, &-v));
        Extremes { a, b, top_of_a, bottom_of_b: -top_of_b }
    }
}

fn portable_top(body: &Body, v: &Vec3) -> (u32, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (g, group) in std::iter::once(body.first_group()).chain(body.more_groups()).enumerate() {
        for i in 0..GROUP {
            let key = f64::from_bits((portable_height(group, i, v).to_bits() & !INDEX) | i as u64);
            if key > best.1 {
                best = (g * GROUP, key);
            }
        }
    }
    (best.0 as u32 + (best.1.to_bits() & INDEX) as u32, best.1)
}

#[inline(always)]
fn portable_height(Group([x, y, z]): &Group, i: usize, v: &Vec3) -> f64 {
    z[i].mul_add(v.z, y[i].mul_add(v.y, x[i] * v.x))
}

/// What headers alone tell of each pair, eight at a time: `Some(true)` for an overlap, or a gap that is not exceeded.
///
/// What they leave open is listed for [`search_in_lockstep`]. Returns how many pairs the inscribed spheres decided, or
/// `None`, with nothing done, on a machine without AVX-512.
pub(crate) fn glance_in_lockstep(
    asks: &[Ask<'_>],
    gap: f64,
    answers: &mut [Option<bool>],
    open: &mut Open,
) -> Option<u64> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("fma") {
        // SAFETY: both features were detected.
        return Some(unsafe { glance::glance(asks, gap, answers, open) });
    }
    let _ = (asks, gap, answers, open);
    None
}

/// Searches the `chosen` entries of `open`, eight at a time; `None` is left where a single query must decide.
///
/// On a machine without AVX-512 that is everywhere.
pub(crate) fn search_in_lockstep(
    asks: &[Ask<'_>],
    gap: f64,
    open: &Open,
    chosen: &[u32],
    answers: &mut [Option<bool>],
) {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("fma") {
        // SAFETY: both features were detected.
        unsafe { lockstep::search(asks, gap, open, chosen, answers) };
    }
    let _ = (asks, gap, open, chosen, answers);
}

#[cfg(test)]
mod tests {
    use super::{Extremes, Kernel, Portable, Search, dispatch};
    use crate::gjk::body::Body;
    use crate::math::Vec3;

    /// The extremes by whatever kernel is dispatched to.
    struct Ask<'a>(&'a Body, &'a Body, Vec3);

    impl Search for Ask<'_> {
        type Output = Extremes;
        #[inline(always)]
        fn run<K: Kernel>(self, kernel: K) -> Extremes {
            kernel.extremes(self.0, self.1, &self.2)
        }
    }

    /// A scattered body of `n` points, the same on every machine.
    fn body(n: u32) -> Body {
        let scatter = |i: u32, k: u32| {
            f64::from(i.wrapping_mul(7919).wrapping_add(k * 104_729).wrapping_mul(2_654_435) % 2001) / 1000.0 - 1.0
        };
        Body::bare(
            (0..n).map(|i| Vec3::new(scatter(i, 1), scatter(i, 2), scatter(i, 3))).collect::<Vec<_>>().into_iter(),
        )
    }

    #[test]
    fn every_kernel_finds_the_same_slots_and_heights() {
        for n in [1, 4, 25, 31, 32, 33, 64, 100, 1000] {
            let (a, b) = (body(n), body(n + 3));
            for v in [Vec3::x(), -Vec3::y(), Vec3::new(0.3, -0.7, 0.2), Vec3::new(-1e-9, 1e3, 0.5)] {
                let expected = Portable.extremes(&a, &b, &v);
                assert_eq!(dispatch(Ask(&a, &b, v)), expected, "{n} points along {v:?}");
                #[cfg(target_arch = "x86_64")]
                if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                    // SAFETY: both features were detected.
                    let found = unsafe { super::x86::on_avx2(Ask(&a, &b, v)) };
                    assert_eq!(found, expected, "AVX2, {n} points along {v:?}");
                }
            }
        }
    }
}
