//! The supports of many pairs of bodies at once, in f32.

use super::super::body::Group;
use super::super::kernel::{Real, keys};
use super::vectors::{Vectors, narrow_lanes};
use crate::simd::{Lanes, Lockstep, MOST_LANES, Simd};

/// The two bodies of each lane.
pub(super) type Groups<'a> = [[&'a Group<f32>; 2]; MOST_LANES];

/// The supports of a lane each, as keys of a height and a slot.
pub(super) struct Supports<S: Simd> {
    top_a: S::F32,
    top_b: S::F32,
    separation: S::F32,
}

impl<S: Simd> Supports<S> {
    /// Along `direction`, for the live lanes.
    #[inline(always)]
    pub(super) fn new(
        simd: S,
        groups: &Groups<'_>,
        live: u32,
        direction: Vectors<S::F32>,
        v0: Vectors<S::F32>,
    ) -> Self {
        let nothing = S::F32::all(simd, 0.0);
        let (mut keys_a, mut keys_b) = ([nothing; MOST_LANES], [nothing; MOST_LANES]);
        let mut along = [[0.0; MOST_LANES]; 3];
        direction.store(&mut along);
        for l in 0..narrow_lanes::<S>() {
            if live >> l & 1 == 1 {
                let [x, y, z] = [along[0][l], along[1][l], along[2][l]];
                keys_a[l] = keys(simd, groups[l][0], [x, y, z]);
                keys_b[l] = keys(simd, groups[l][1], [-x, -y, -z]);
            }
        }
        let (top_a, top_b) = (S::F32::largest_of_each(&keys_a), S::F32::largest_of_each(&keys_b));
        Self { top_a, top_b, separation: nothing - (top_a + top_b + v0.dot(direction)) }
    }

    /// The lanes that are proved more than `gap` apart, and those for which a portal search is over.
    #[inline(always)]
    pub(super) fn apart(&self, simd: S, direction: Vectors<S::F32>, reach: S::F32, gap: f32) -> (u32, u32) {
        let doubt = doubt(simd, direction, reach);
        let beyond = if gap == 0.0 {
            self.separation
        } else {
            self.separation - direction.dot(direction).sqrt() * S::F32::all(simd, gap)
        };
        (beyond.above(doubt), self.separation.above(S::F32::all(simd, 0.0)))
    }

    /// The points a - b - x of the slots in the keys, and the slots, as bits.
    #[inline(always)]
    pub(super) fn points(&self, simd: S, groups: &Groups<'_>, v0: Vectors<S::F32>) -> (Vectors<S::F32>, S::F32) {
        let (mut of_a, mut of_b) = ([0.0; MOST_LANES], [0.0; MOST_LANES]);
        self.top_a.store(&mut of_a, 0);
        self.top_b.store(&mut of_b, 0);
        let (mut w, mut slots) = ([[0.0; MOST_LANES]; 3], [0.0; MOST_LANES]);
        for l in 0..narrow_lanes::<S>() {
            let (a, b) = (of_a[l].slot(), of_b[l].slot());
            let [Group(from_a), Group(from_b)] = groups[l];
            for axis in 0..3 {
                w[axis][l] = from_a[axis][a as usize] - from_b[axis][b as usize];
            }
            slots[l] = packed(a, b);
        }
        (Vectors::load(simd, &w) + v0, S::F32::load(simd, &slots, 0))
    }
}

/// The most that rounding can add to the separation along `direction`.
#[inline(always)]
pub(super) fn doubt<S: Simd>(simd: S, direction: Vectors<S::F32>, reach: S::F32) -> S::F32 {
    (direction.norm1() * reach).times_plus(S::F32::all(simd, f32::HEIGHT_ERROR), S::F32::all(simd, f32::TINY))
}

/// Two slots as the bits of a number, which is only moved.
#[inline(always)]
fn packed(a: u32, b: u32) -> f32 {
    f32::from_bits(a | b << 8)
}

/// The two slots.
#[inline(always)]
pub(super) fn unpacked(slots: f32) -> (u32, u32) {
    (slots.to_bits() & 0xFF, slots.to_bits() >> 8)
}
