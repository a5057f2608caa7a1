//! The supports of eight pairs of bodies at once, on AVX-512.

use super::super::batch::Ask;
use super::super::body::Group;
use super::eight::{Eight, LANES, Vectors};
use super::x86::keys512;
use super::{HEIGHT_ERROR, INDEX};
use crate::math::Vec3;
use std::arch::x86_64::*;

/// The supports of eight pairs, as keys of a height and a slot.
pub(super) struct Supports {
    top_a: Eight,
    top_b: Eight,
    separation: Eight,
}

impl Supports {
    /// Along `direction`, for the live lanes.
    #[inline(always)]
    pub(super) fn new(lanes: &[&Ask<'_>; LANES], live: u8, direction: Vectors, v0: Vectors) -> Self {
        let nothing = Eight::all(0.0).0;
        let (mut keys_a, mut keys_b) = ([nothing; LANES], [nothing; LANES]);
        let (along, against) = (direction.columns(), (-direction).columns());
        for l in 0..LANES {
            if live >> l & 1 == 1 {
                let at = |columns: &[[f64; LANES]; 3]| Vec3::new(columns[0][l], columns[1][l], columns[2][l]);
                // SAFETY: AVX-512 was detected.
                unsafe {
                    keys_a[l] = keys512(lanes[l].a.first_group(), &at(&along));
                    keys_b[l] = keys512(lanes[l].b.first_group(), &at(&against));
                }
            }
        }
        let (top_a, top_b) = (largest_of_each(&keys_a), largest_of_each(&keys_b));
        Self { top_a, top_b, separation: Eight::all(0.0) - (top_a + top_b + v0.dot(direction)) }
    }

    /// The lanes that are proved more than `gap` apart, and those for which a portal search is over.
    #[inline(always)]
    pub(super) fn apart(&self, direction: Vectors, reach: Eight, gap: f64) -> (u8, u8) {
        let doubt = direction.norm1() * reach * Eight::all(HEIGHT_ERROR) + Eight::all(f64::MIN_POSITIVE);
        let beyond = if gap == 0.0 {
            self.separation
        } else {
            self.separation - direction.dot(direction).sqrt() * Eight::all(gap)
        };
        (beyond.above(doubt), self.separation.above(Eight::all(0.0)))
    }

    /// The points a - b - x of the slots in the keys.
    #[inline(always)]
    pub(super) fn points(&self, lanes: &[&Ask<'_>; LANES], v0: Vectors) -> Vectors {
        let (mut of_a, mut of_b) = ([0.0; LANES], [0.0; LANES]);
        self.top_a.store(&mut of_a, 0);
        self.top_b.store(&mut of_b, 0);
        let slot = |key: f64| (key.to_bits() & INDEX) as usize;
        let a = |l: usize, k: usize| {
            let Group(p) = lanes[l].a.first_group();
            p[k][slot(of_a[l])]
        };
        let b = |l: usize, k: usize| {
            let Group(p) = lanes[l].b.first_group();
            p[k][slot(of_b[l])]
        };
        let of_a = Vectors {
            x: Eight::from_lanes(|l| a(l, 0)),
            y: Eight::from_lanes(|l| a(l, 1)),
            z: Eight::from_lanes(|l| a(l, 2)),
        };
        let of_b = Vectors {
            x: Eight::from_lanes(|l| b(l, 0)),
            y: Eight::from_lanes(|l| b(l, 1)),
            z: Eight::from_lanes(|l| b(l, 2)),
        };
        of_a - of_b + v0
    }
}

/// The largest number of each of eight registers, in their order.
#[inline(always)]
fn largest_of_each(k: &[__m512d; LANES]) -> Eight {
    // SAFETY: AVX-512 was detected.
    unsafe {
        let (t0, t1) = (largest_of_two(k[0], k[1]), largest_of_two(k[2], k[3]));
        let (t2, t3) = (largest_of_two(k[4], k[5]), largest_of_two(k[6], k[7]));
        let (u0, u1) = (halves(t0, t1), halves(t2, t3));
        Eight(halves(u0, u1))
    }
}

/// Per 128 bits: the larger of each register's two numbers.
#[inline(always)]
unsafe fn largest_of_two(p: __m512d, q: __m512d) -> __m512d {
    // SAFETY: AVX-512 was detected.
    unsafe { _mm512_max_pd(_mm512_unpacklo_pd(p, q), _mm512_unpackhi_pd(p, q)) }
}

/// The larger of neighbouring blocks of 128 bits, of `p` and then of `q`.
#[inline(always)]
unsafe fn halves(p: __m512d, q: __m512d) -> __m512d {
    // SAFETY: AVX-512 was detected.
    unsafe {
        let (even, odd) = (_mm512_shuffle_f64x2::<0b10_00_10_00>(p, q), _mm512_shuffle_f64x2::<0b11_01_11_01>(p, q));
        _mm512_max_pd(even, odd)
    }
}
