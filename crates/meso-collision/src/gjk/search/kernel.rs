//! The support of both bodies of a pair at once, on vector registers.
//!
//! Every instruction set does the same correctly rounded operations in the same order (fused multiply-adds, which are
//! exact to define), so that all machines find the same vertices and the same answers.

use crate::gjk::body::{Body, GROUP, Group};
use crate::math::Vec3;
use crate::simd::{Lanes, MOST_LANES, SLOTS, Simd};
use nalgebra::{RealField, Vector3};

const _: () = assert!(GROUP == SLOTS, "a key holds the slot of a point within its group");

/// The numbers of a search: f64, or f32 over points that were rounded once.
///
/// The bounds are in units of the roundoff u: 2^-53 or 2^-24.
pub(crate) trait Real: RealField + Copy {
    /// The register of `S` for these numbers.
    type Lanes<S: Simd>: Lanes<T = Self, Token = S>;
    /// Error of a height over |direction| times the size, 128 u: 62 u for the slot in the mantissa, 5 u for the points,
    /// where they are rounded, and the dot product, and the rest for its further use.
    const HEIGHT_ERROR: Self;
    /// Error of a determinant over the size cubed: see
    /// [`certificate`](crate::gjk::prove::certificate::encloses_origin_roughly).
    const ENCLOSING: Self;
    /// More than all products of one determinant can lose by underflow.
    const UNDERFLOW: Self;
    /// More than all products of one height can lose by underflow.
    const TINY: Self;
    /// The share of a height's error below which a step of a search is none: f64 takes up pairs that f32 leaves open.
    const PROGRESS: Self;
    /// The slot in the low bits.
    fn slot(self) -> u32;
}

impl Real for f64 {
    type Lanes<S: Simd> = S::F64;
    const HEIGHT_ERROR: f64 = 64.0 * f64::EPSILON;
    const ENCLOSING: f64 = 64.0 * f64::EPSILON;
    const UNDERFLOW: f64 = 1e-300;
    const TINY: f64 = f64::MIN_POSITIVE;
    const PROGRESS: f64 = 0.0;

    #[inline(always)]
    fn slot(self) -> u32 {
        self.to_bits() as u32 % SLOTS as u32
    }
}

impl Real for f32 {
    type Lanes<S: Simd> = S::F32;
    const HEIGHT_ERROR: f32 = 64.0 * f32::EPSILON;
    const ENCLOSING: f32 = 64.0 * f32::EPSILON;
    const UNDERFLOW: f32 = 1e-36;
    const TINY: f32 = f32::MIN_POSITIVE;
    const PROGRESS: f32 = 1.0;

    #[inline(always)]
    fn slot(self) -> u32 {
        self.to_bits() % SLOTS as u32
    }
}

/// The farthest point of A along a direction and the nearest of B, with their heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extremes<T> {
    /// Slot in A; padding repeats the first point.
    pub(crate) a: u32,
    /// Slot in B.
    pub(crate) b: u32,
    /// Largest height of a point of A.
    pub(crate) top_of_a: T,
    /// Smallest height of a point of B.
    pub(crate) bottom_of_b: T,
}

/// The extremes of two bodies of one group each.
#[inline(always)]
pub(crate) fn extremes_of_groups<T: Real, S: Simd>(simd: S, a: &Group<T>, b: &Group<T>, v: &Vector3<T>) -> Extremes<T> {
    let top_a = keys(simd, simd.afresh(a), [v.x, v.y, v.z]).largest();
    let top_b = keys(simd, simd.afresh(b), [-v.x, -v.y, -v.z]).largest();
    Extremes { a: top_a.slot(), b: top_b.slot(), top_of_a: top_a, bottom_of_b: -top_b }
}

/// The extremes of two bodies of any number of points.
#[inline(always)]
pub(crate) fn extremes<S: Simd>(simd: S, a: &Body, b: &Body, v: &Vec3) -> Extremes<f64> {
    if a.is_one_group() && b.is_one_group() {
        return extremes_of_groups(simd, a.first_group(), b.first_group(), v);
    }
    let ((a, top_a), (b, top_b)) = (top_of_groups(simd, a, v), top_of_groups(simd, b, &-v));
    Extremes { a, b, top_of_a: top_a, bottom_of_b: -top_b }
}

/// The slot of the highest point of a body of several groups, and its key.
#[inline(always)]
fn top_of_groups<S: Simd>(simd: S, body: &Body, v: &Vec3) -> (u32, f64) {
    let v = [v.x, v.y, v.z];
    let mut best = keys(simd, body.first_group(), v);
    let mut group_of_best = S::F64::all(simd, 0.0);
    for (i, group) in body.more_groups().iter().enumerate() {
        let keys = keys(simd, group, v);
        group_of_best = group_of_best.or(keys.above(best), S::F64::all(simd, (i + 1) as f64));
        best = best.max(keys);
    }
    let mut groups = [0.0; MOST_LANES];
    group_of_best.store(&mut groups, 0);
    let top = best.largest();
    let slot = top.slot();
    // Slots are dealt to lanes in turn.
    let group = groups[slot as usize % S::F64::LANES] as u32;
    (group * GROUP as u32 + slot, top)
}

/// The largest key of each lane: heights with their slots in the low bits.
///
/// No closures here: those do not inherit the instruction set, and every vector operation in them becomes a call.
#[inline(always)]
pub(crate) fn keys<T: Real, S: Simd>(simd: S, group: &Group<T>, [vx, vy, vz]: [T; 3]) -> T::Lanes<S> {
    let v = [T::Lanes::all(simd, vx), T::Lanes::all(simd, vy), T::Lanes::all(simd, vz)];
    let step = T::Lanes::<S>::LANES;
    // Two chains of maxima: one would be waited for.
    let (mut even, mut odd) = (key(simd, group, 0, v), key(simd, group, step, v));
    let mut at = 2 * step;
    while at < GROUP {
        even = even.max(key(simd, group, at, v));
        odd = odd.max(key(simd, group, at + step, v));
        at += 2 * step;
    }
    even.max(odd)
}

#[inline(always)]
fn key<T: Real, S: Simd>(
    simd: S,
    Group([x, y, z]): &Group<T>,
    at: usize,
    [vx, vy, vz]: [T::Lanes<S>; 3],
) -> T::Lanes<S> {
    let height = T::Lanes::load(simd, x, at) * vx;
    let height = T::Lanes::load(simd, y, at).times_plus(vy, height);
    T::Lanes::load(simd, z, at).times_plus(vz, height).keyed(at)
}

#[cfg(test)]
mod tests {
    use super::{Extremes, extremes};
    use crate::gjk::body::Body;
    use crate::math::Vec3;
    use crate::simd::{Isa, Simd, Vectorized, choose, dispatch};

    struct Ask<'a>(&'a Body, &'a Body, Vec3);

    impl Vectorized for Ask<'_> {
        type Output = Extremes<f64>;
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Extremes<f64> {
            extremes(simd, self.0, self.1, &self.2)
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
    fn every_instruction_set_finds_the_same_slots_and_heights() {
        for n in [1, 4, 25, 31, 32, 33, 64, 100, 1000] {
            let (a, b) = (body(n), body(n + 3));
            for v in [Vec3::x(), -Vec3::y(), Vec3::new(0.3, -0.7, 0.2), Vec3::new(-1e-9, 1e3, 0.5)] {
                let found = Isa::ALL.map(|isa| {
                    choose(isa);
                    dispatch(Ask(&a, &b, v))
                });
                assert_eq!([found[0]; 3], found, "{n} points along {v:?}");
            }
        }
    }
}
