//! A vector for each lane: three registers.

use crate::simd::{Lanes, Simd};

/// One vector for each lane.
#[derive(Clone, Copy)]
pub(super) struct Vectors<L> {
    pub(super) x: L,
    pub(super) y: L,
    pub(super) z: L,
}

impl<L: Lanes> std::ops::Sub for Vectors<L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { x: self.x - o.x, y: self.y - o.y, z: self.z - o.z }
    }
}

impl<L: Lanes> std::ops::Add for Vectors<L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { x: self.x + o.x, y: self.y + o.y, z: self.z + o.z }
    }
}

impl<L: Lanes> Vectors<L> {
    /// One number in all lanes.
    #[inline(always)]
    pub(super) fn all(token: L::Token, value: L::T) -> Self {
        let all = L::all(token, value);
        Self { x: all, y: all, z: all }
    }

    /// Three columns in memory.
    #[inline(always)]
    pub(super) fn to_arrays(self) -> [L::Array; 3] {
        [self.x.to_array(), self.y.to_array(), self.z.to_array()]
    }

    #[inline(always)]
    pub(super) fn times(self, factor: L) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }

    /// |x| + |y| + |z|.
    #[inline(always)]
    pub(super) fn norm1(self) -> L {
        self.x.abs() + self.y.abs() + self.z.abs()
    }

    /// Fused: a rounding less than the bounds of `certificate` allow for.
    #[inline(always)]
    pub(super) fn dot(self, o: Self) -> L {
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
    pub(super) fn or(self, mask: L::Mask, o: Self) -> Self {
        Self { x: self.x.or(mask, o.x), y: self.y.or(mask, o.y), z: self.z.or(mask, o.z) }
    }
}

/// The bits of the first `n` lanes.
pub(super) fn first_lanes(n: usize) -> u32 {
    u32::MAX >> (32 - n)
}

/// As many f32 as a register of `S` has.
pub(super) const fn narrow_lanes<S: Simd>() -> usize {
    <S::F32 as Lanes>::LANES
}
