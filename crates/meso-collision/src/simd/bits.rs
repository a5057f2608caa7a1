//! A mask that is its bits: of the portable lanes and of AVX-512.

use super::Mask;
use std::ops::{BitAnd, BitOr};

/// Lanes, chosen: bit `l` for lane `l`.
#[derive(Clone, Copy)]
pub(crate) struct Bits(pub(super) u32);

impl BitAnd for Bits {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

impl BitOr for Bits {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl Mask for Bits {
    #[inline(always)]
    fn but_not(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    #[inline(always)]
    fn bits(self) -> u32 {
        self.0
    }
}
