//! Vector types of arm64: NEON, which every such machine has.

use super::slots::{SLOTS_32, SLOTS_64};
use super::{Lanes, Mask, SLOTS, Simd};
use std::arch::aarch64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// The token of NEON.
#[derive(Clone, Copy)]
pub(crate) struct Neon(());

impl Neon {
    pub(super) fn new() -> Self {
        Self(())
    }
}

impl Simd for Neon {
    type F32 = F32x4;
    type F64 = F64x2;
}

/// For each mask of four lanes of 32 bits, the byte to take for each byte so that the lanes of the mask come first.
static TO_FRONT: [[u8; 16]; 16] = to_front();
/// The bit of each lane.
static BITS_32: [u32; 4] = [1, 2, 4, 8];
static BITS_64: [u64; 2] = [1, 2];

const fn to_front() -> [[u8; 16]; 16] {
    let mut all = [[0; 16]; 16];
    let mut mask = 0;
    while mask < 16 {
        let (mut lane, mut taken) = (0, 0);
        while lane < 4 {
            if mask >> lane & 1 == 1 {
                let mut byte = 0;
                while byte < 4 {
                    all[mask][4 * taken + byte] = (4 * lane + byte) as u8;
                    byte += 1;
                }
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
                // SAFETY: every machine of arm64 has NEON; so for all operations of this file. Loads and stores assert that
                // the memory is there.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        }
    };
}

/// Masks: all bits of a lane, or none.
macro_rules! mask {
    ($name:ident($register:ty), [$and:ident, $or:ident, $clear:ident, $sum:ident, $load:ident, $bits:ident]) => {
        /// Lanes, chosen.
        #[derive(Clone, Copy)]
        pub(crate) struct $name($register);
        operator!($name, BitAnd, bitand, $and);
        operator!($name, BitOr, bitor, $or);

        impl Mask for $name {
            #[inline(always)]
            fn but_not(self, other: Self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $clear(self.0, other.0) })
            }

            #[inline(always)]
            fn bits(self) -> u32 {
                // SAFETY: see `operator`.
                unsafe { $sum($and(self.0, $load($bits.as_ptr()))) as u32 }
            }
        }
    };
}
mask! { M32x4(uint32x4_t), [vandq_u32, vorrq_u32, vbicq_u32, vaddvq_u32, vld1q_u32, BITS_32] }
mask! { M64x2(uint64x2_t), [vandq_u64, vorrq_u64, vbicq_u64, vaddvq_u64, vld1q_u64, BITS_64] }

macro_rules! lanes {
    (
        $name:ident($register:ty), $lanes:literal of $t:ty, with $mask:ident,
        [$add:ident, $sub:ident, $mul:ident, $div:ident, $max:ident, $sqrt:ident, $fma:ident],
        [$dup:ident, $load:ident, $store:ident, $above:ident, $blend:ident],
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
            type Token = Neon;
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
            fn all(_: Neon, value: $t) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $dup(value) })
            }

            #[inline(always)]
            fn of_lanes(token: Neon, lane: impl Fn(usize) -> $t) -> Self {
                let array: [$t; $lanes] = std::array::from_fn(lane);
                Self::load(token, &array, 0)
            }

            #[inline(always)]
            fn load(_: Neon, from: &[$t], at: usize) -> Self {
                assert!(at + $lanes <= from.len());
                // SAFETY: the numbers are there.
                Self(unsafe { $load(from.as_ptr().add(at)) })
            }

            #[inline(always)]
            fn store(self, to: &mut [$t], at: usize) {
                assert!(at + $lanes <= to.len());
                // SAFETY: there is room.
                unsafe { $store(to.as_mut_ptr().add(at), self.0) };
            }

            #[inline(always)]
            fn times_plus(self, factor: Self, term: Self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $fma(term.0, self.0, factor.0) })
            }

            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $sqrt(self.0) })
            }

            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: see `operator`. Keys alone come here: none is NaN, and of two zeros either will do.
                Self(unsafe { $max(self.0, other.0) })
            }

            #[inline(always)]
            fn above(self, other: Self) -> $mask {
                // SAFETY: see `operator`.
                $mask(unsafe { $above(self.0, other.0) })
            }

            #[inline(always)]
            fn or(self, mask: $mask, other: Self) -> Self {
                // SAFETY: see `operator`.
                Self(unsafe { $blend(mask.0, other.0, self.0) })
            }

            $($special)*
        }
    };
}

lanes! {
    F32x4(float32x4_t), 4 of f32, with M32x4,
    [vaddq_f32, vsubq_f32, vmulq_f32, vdivq_f32, vmaxq_f32, vsqrtq_f32, vfmaq_f32],
    [vdupq_n_f32, vld1q_f32, vst1q_f32, vcgtq_f32, vbslq_f32],

    #[inline(always)]
    fn front(self, mask: u32) -> Self {
        self.permuted(&TO_FRONT[mask as usize % 16])
    }

    #[inline(always)]
    fn keyed(self, at: usize) -> Self {
        assert!(at + 4 <= SLOTS);
        // SAFETY: see `operator`. Bits of the slot where the mask is set, of the height elsewhere.
        unsafe {
            let slots = vreinterpretq_f32_u32(vld1q_u32(SLOTS_32.0.as_ptr().add(at)));
            Self(vbslq_f32(vdupq_n_u32(SLOTS as u32 - 1), slots, self.0))
        }
    }

    #[inline(always)]
    fn largest(self) -> f32 {
        // SAFETY: see `operator`.
        unsafe { vmaxvq_f32(self.0) }
    }

}

impl F32x4 {
    #[inline(always)]
    fn permuted(self, bytes: &[u8; 16]) -> Self {
        // SAFETY: see `operator`.
        Self(unsafe { vreinterpretq_f32_u8(vqtbl1q_u8(vreinterpretq_u8_f32(self.0), vld1q_u8(bytes.as_ptr()))) })
    }
}

lanes! {
    F64x2(float64x2_t), 2 of f64, with M64x2,
    [vaddq_f64, vsubq_f64, vmulq_f64, vdivq_f64, vmaxq_f64, vsqrtq_f64, vfmaq_f64],
    [vdupq_n_f64, vld1q_f64, vst1q_f64, vcgtq_f64, vbslq_f64],

    #[inline(always)]
    fn front(self, mask: u32) -> Self {
        // SAFETY: see `operator`.
        if mask & 1 == 0 { Self(unsafe { vdupq_laneq_f64::<1>(self.0) }) } else { self }
    }

    #[inline(always)]
    fn keyed(self, at: usize) -> Self {
        assert!(at + 2 <= SLOTS);
        // SAFETY: see `operator`. Bits of the slot where the mask is set, of the height elsewhere.
        unsafe {
            let slots = vreinterpretq_f64_u64(vld1q_u64(SLOTS_64.0.as_ptr().add(at)));
            Self(vbslq_f64(vdupq_n_u64(SLOTS as u64 - 1), slots, self.0))
        }
    }

    #[inline(always)]
    fn largest(self) -> f64 {
        // SAFETY: see `operator`.
        unsafe { vmaxvq_f64(self.0) }
    }

}
