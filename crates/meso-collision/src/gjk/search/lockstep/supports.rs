//! The supports of many pairs of bodies at once.

use super::vectors::Vectors;
use crate::gjk::body::Group;
use crate::gjk::search::kernel::{Real, keys};
use crate::simd::{Each, Lanes, MOST_LANES, Simd};

/// The two bodies of each lane.
pub(super) type Groups<'a, T> = [[&'a Group<T>; 2]; MOST_LANES];

/// The keys of each lane's points: of its body A along a direction, or of B against it.
struct Keys<'a, T: Real, S: Simd, const BODY: usize> {
    simd: S,
    groups: &'a Groups<'a, T>,
    live: u32,
    /// The direction in which the body's points are high: for B, the opposite one.
    along: [<T::Lanes<S> as Lanes>::Array; 3],
}

impl<T: Real, S: Simd, const BODY: usize> Each<T::Lanes<S>> for Keys<'_, T, S, BODY> {
    #[inline(always)]
    fn register(&self, l: usize) -> T::Lanes<S> {
        if self.live >> l & 1 == 0 {
            return T::Lanes::all(self.simd, T::zero());
        }
        let v = [self.along[0].as_ref()[l], self.along[1].as_ref()[l], self.along[2].as_ref()[l]];
        keys(self.simd, self.groups[l][BODY], v)
    }
}

/// The supports of a lane each, as keys of a height and a slot.
pub(super) struct Supports<L> {
    top_a: L,
    top_b: L,
    separation: L,
}

impl<L> Supports<L> {
    /// Along `direction`, for the live lanes.
    #[inline(always)]
    pub(super) fn new<T: Real<Lanes<S> = L>, S: Simd>(
        simd: S,
        groups: &Groups<'_, T>,
        live: u32,
        direction: Vectors<L>,
        v0: Vectors<L>,
    ) -> Self
    where
        L: Lanes<T = T, Token = S>,
    {
        let (along, against) = (direction.to_arrays(), direction.times(L::all(simd, -T::one())).to_arrays());
        let top_a = L::largest_of_each(&Keys::<T, S, 0> { simd, groups, live, along });
        let top_b = L::largest_of_each(&Keys::<T, S, 1> { simd, groups, live, along: against });
        Self { top_a, top_b, separation: L::all(simd, T::zero()) - (top_a + top_b + v0.dot(direction)) }
    }

    /// The lanes that are proved more than `gap` apart, and those for which a portal search is over.
    #[inline(always)]
    pub(super) fn apart<T: Real<Lanes<S> = L>, S: Simd>(
        &self,
        simd: S,
        direction: Vectors<L>,
        reach: L,
        gap: T,
    ) -> (L::Mask, L::Mask)
    where
        L: Lanes<T = T, Token = S>,
    {
        let doubt = doubt(simd, direction, reach);
        let beyond = if gap == T::zero() {
            self.separation
        } else {
            self.separation - direction.dot(direction).sqrt() * L::all(simd, gap)
        };
        (beyond.above(doubt), self.separation.above(L::all(simd, T::zero())))
    }

    /// The points a - b - x of the slots in the keys, and the slots, as bits.
    #[inline(always)]
    pub(super) fn points<S: Simd<F32 = L>>(&self, simd: S, groups: &Groups<'_, f32>, v0: Vectors<L>) -> (Vectors<L>, L)
    where
        L: Lanes<T = f32, Token = S>,
    {
        let (of_a, of_b) = (self.top_a.to_array(), self.top_b.to_array());
        let of = |l: usize| (of_a.as_ref()[l].slot(), of_b.as_ref()[l].slot());
        (corners(simd, groups, of) + v0, L::of_lanes(simd, |l| packed(of(l))))
    }
}

/// The points a - b of these slots.
#[inline(always)]
pub(super) fn corners<T: Real, S: Simd>(
    simd: S,
    groups: &Groups<'_, T>,
    of: impl Fn(usize) -> (u32, u32),
) -> Vectors<T::Lanes<S>> {
    let (x, y, z) = (along(simd, groups, &of, 0), along(simd, groups, &of, 1), along(simd, groups, &of, 2));
    Vectors { x, y, z }
}

/// Their coordinate along an axis.
#[inline(always)]
fn along<T: Real, S: Simd>(
    simd: S,
    groups: &Groups<'_, T>,
    of: &impl Fn(usize) -> (u32, u32),
    axis: usize,
) -> T::Lanes<S> {
    let a = T::Lanes::<S>::of_lanes(simd, |l| groups[l][0].0[axis][of(l).0 as usize]);
    a - T::Lanes::<S>::of_lanes(simd, |l| groups[l][1].0[axis][of(l).1 as usize])
}

/// The most that rounding can add to the separation along `direction`.
#[inline(always)]
pub(super) fn doubt<T: Real<Lanes<S> = L>, S: Simd, L: Lanes<T = T, Token = S>>(
    simd: S,
    direction: Vectors<L>,
    reach: L,
) -> L {
    (direction.norm1() * reach).times_plus(L::all(simd, T::HEIGHT_ERROR), L::all(simd, T::TINY))
}

/// The lanes whose tetrahedron of v0 and three points is proved to hold the origin; they face away from v0.
///
/// Lane by lane the test [`encloses_origin_roughly`](crate::gjk::prove::certificate::encloses_origin_roughly).
#[inline(always)]
pub(super) fn enclosing<T: Real<Lanes<S> = L>, S: Simd, L: Lanes<T = T, Token = S>>(
    simd: S,
    v0: Vectors<L>,
    [v1, v2, v3]: [Vectors<L>; 3],
    reach: L,
) -> L::Mask {
    let bound = (reach * reach * reach).times_plus(L::all(simd, T::ENCLOSING), L::all(simd, T::UNDERFLOW));
    let (c12, c23) = (v2.cross(v1), v3.cross(v2));
    let [e12, e23, e31] = [c12.dot(v0), c23.dot(v0), v1.cross(v3).dot(v0)];
    let determinant = L::all(simd, T::zero()) - v1.dot(c23);
    e12.above(bound) & e23.above(bound) & e31.above(bound) & determinant.above(bound)
}

/// Two slots as the bits of a number, which is only moved.
#[inline(always)]
fn packed((a, b): (u32, u32)) -> f32 {
    f32::from_bits(a | b << 8)
}

/// The two slots.
#[inline(always)]
pub(super) fn unpacked(slots: f32) -> (u32, u32) {
    (slots.to_bits() & 0xFF, slots.to_bits() >> 8)
}
