//! The widest vector instructions of the machine: one choice, at run time, for the whole crate.
//!
//! [`widest`] runs plain loops, which the compiler vectorizes; `dispatch` runs code that is written with `Lanes`. The
//! compiler never fuses or reorders floating-point operations, and fused multiply-adds are exact to define, so every
//! instruction set finds the same bits. A value of a vector type is made from a token of its instruction set, and a
//! token only by `dispatch`, after detection: so the operations on it are safe.
//!
//! pulp 0.22 was tried in its place. It finds the same bits, and a support of two bodies takes as long with it. But its
//! portable trait has no compress, which sieve sizes live on, and building it takes 12 s of processor time.
#![allow(unsafe_code)]

#[cfg(any(test, not(target_arch = "aarch64")))]
mod bits;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(any(test, not(target_arch = "aarch64")))]
mod portable;
#[cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]
mod slots;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};
use std::sync::atomic::{AtomicU8, Ordering};

/// A set of vector instructions, the narrowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Isa {
    /// Instructions of every machine of the target: SSE2 on x86-64, NEON on arm64.
    Scalar,
    /// AVX2 and FMA, and their companions: BMI, LZCNT and POPCNT.
    Avx2,
    /// AVX-512 F, BW, DQ and VL.
    Avx512,
}

impl Isa {
    /// All, the narrowest first.
    pub const ALL: [Self; 3] = [Self::Scalar, Self::Avx2, Self::Avx512];

    /// `scalar`, `avx2` or `avx512`.
    pub fn name(self) -> &'static str {
        ["scalar", "avx2", "avx512"][self as usize]
    }

    /// The widest set that the machine has.
    pub fn best() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::is_x86_feature_detected as has;
            if has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt") {
                let wide = has!("avx512f") && has!("avx512bw") && has!("avx512dq") && has!("avx512vl");
                return if wide { Self::Avx512 } else { Self::Avx2 };
            }
        }
        Self::Scalar
    }
}

/// Number of the set that [`dispatch`] uses, plus 1; 0 before it is known. Never more than the machine has.
static CHOSEN: AtomicU8 = AtomicU8::new(0);

/// The instructions in use.
#[inline(always)]
pub fn isa() -> Isa {
    match CHOSEN.load(Ordering::Relaxed) {
        1 => Isa::Scalar,
        2 => Isa::Avx2,
        3 => Isa::Avx512,
        _ => choose(Isa::Avx512),
    }
}

/// Uses `isa`, or the machine's widest set where that is narrower, from now on and in all threads; returns the set in
/// use.
///
/// Results do not change, only their run time: for tests and benches.
#[cold]
pub fn choose(isa: Isa) -> Isa {
    let isa = isa.min(Isa::best());
    CHOSEN.store(isa as u8 + 1, Ordering::Relaxed);
    isa
}

/// Work written with the vector types of an instruction set.
pub(crate) trait Vectorized {
    /// The result.
    type Output;
    /// Does the work; must be `#[inline(always)]`, with all it calls, to be compiled for the instructions of `simd`.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// Runs `work` on the widest registers there are.
#[inline]
pub(crate) fn dispatch<V: Vectorized>(work: V) -> V::Output {
    // SAFETY: `isa` is at most the detected set.
    unsafe { on(isa(), work) }
}

/// Runs `work` on `isa`.
///
/// # Safety
/// The machine must have its instructions.
#[inline(always)]
#[cfg_attr(not(target_arch = "x86_64"), allow(unused_variables, reason = "there is one set alone"))]
unsafe fn on<V: Vectorized>(isa: Isa, work: V) -> V::Output {
    #[cfg(target_arch = "x86_64")]
    match isa {
        // SAFETY: as the caller promises; so below.
        Isa::Avx512 => return unsafe { x86::on_avx512(work) },
        Isa::Avx2 => return unsafe { x86::on_avx2(work) },
        Isa::Scalar => {}
    }
    #[cfg(target_arch = "aarch64")]
    return work.run(neon::Neon::new());
    #[cfg(not(target_arch = "aarch64"))]
    on_any(work)
}

/// Runs `work` on plain instructions: in a function of its own, so that [`on`] is small enough to be inlined.
#[cfg(not(target_arch = "aarch64"))]
#[cfg_attr(target_arch = "x86_64", inline(never))]
#[cfg_attr(not(target_arch = "x86_64"), inline(always))]
fn on_any<V: Vectorized>(work: V) -> V::Output {
    work.run(portable::Portable::new())
}

/// Plain loops that gain from wide registers. A trait and not a closure: only a named function can be marked as one
/// that must be inlined, and other functions are compiled for narrow registers.
pub trait Wide {
    /// The result.
    type Output;
    /// Does the work. Give it `#[inline(always)]`, and all that it calls.
    fn run(self) -> Self::Output;
}

/// Runs `work`, compiled for the widest registers there are.
#[inline]
pub fn widest<W: Wide>(work: W) -> W::Output {
    struct PlainLoops<W>(W);
    impl<W: Wide> Vectorized for PlainLoops<W> {
        type Output = W::Output;
        #[inline(always)]
        fn run<S: Simd>(self, _: S) -> W::Output {
            self.0.run()
        }
    }
    dispatch(PlainLoops(work))
}

/// The token of an instruction set.
pub(crate) trait Simd: Copy {
    /// Its register of f32.
    type F32: Lanes<T = f32, Token = Self>;
    /// Its register of f64.
    type F64: Lanes<T = f64, Token = Self>;

    /// Returns the reference, opaque to the optimiser.
    ///
    /// Else it loads the points once for all supports of a search: into registers that it does not have, hence onto the
    /// stack, where a first support took twice its time.
    #[inline(always)]
    #[allow(clippy::pointers_in_nomem_asm_block, reason = "what it points to is not touched")]
    fn afresh<T>(self, there: &T) -> &T {
        #[cfg(all(target_arch = "x86_64", not(miri)))]
        {
            let mut at: *const T = there;
            // SAFETY: nothing is done, so the pointer is unchanged.
            unsafe {
                std::arch::asm!("/* {0} */", inout(reg) at, options(nomem, nostack, preserves_flags));
                &*at
            }
        }
        #[cfg(any(not(target_arch = "x86_64"), miri))]
        there
    }
}

/// The most lanes of any register.
pub(crate) const MOST_LANES: usize = 16;
/// Slots whose number fits into the low bits of a key.
pub(crate) const SLOTS: usize = 32;

/// Lanes of a register, chosen: as the instruction set compares and blends.
pub(crate) trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// The lanes that the other mask has not.
    fn but_not(self, other: Self) -> Self;
    /// Bit `l` for lane `l`.
    fn bits(self) -> u32;
}

/// A register: numbers side by side, lane 0 first.
pub(crate) trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// f32 or f64.
    type T: Copy;
    /// Proof that the machine has the instructions.
    type Token: Copy;
    /// The numbers in memory.
    type Lane4: Copy + AsRef<[Self::T]>;
    /// Some of its lanes.
    type Mask: Mask;
    /// Number of lanes, at most [`MOST_LANES`].
    const LANES: usize;

    /// To memory.
    fn to_array(self) -> Self::Lane4;
    /// One number in all lanes.
    fn all(token: Self::Token, value: Self::T) -> Self;
    /// The number that `lane` tells of each lane, straight into the register: a load of numbers that were just stored
    /// one by one would wait for them.
    fn of_lanes(token: Self::Token, lane: impl Fn(usize) -> Self::T) -> Self;
    /// The numbers from `from[at]` on.
    fn load(token: Self::Token, from: &[Self::T], at: usize) -> Self;
    /// Stores all lanes from `to[at]` on.
    fn store(self, to: &mut [Self::T], at: usize);
    /// self * factor + term, rounded once.
    fn times_plus(self, factor: Self, term: Self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The larger number of each lane.
    fn max(self, other: Self) -> Self;
    /// The lanes where `self` is larger; none for NaN.
    fn above(self, other: Self) -> Self::Mask;
    /// `other` in the lanes of the mask.
    fn or(self, mask: Self::Mask, other: Self) -> Self;
    /// The lanes of these bits, moved to the front; the rest has no meaning.
    fn front(self, mask: u32) -> Self;
    /// The numbers with their lowest five bits replaced by the slots `at`, `at` + 1, ...
    fn keyed(self, at: usize) -> Self;
    /// The largest lane.
    fn largest(self) -> Self::T;
}

/// Calls `act` with each lane of the mask.
#[inline(always)]
pub(crate) fn for_each_lane(mut mask: u32, mut act: impl FnMut(usize)) {
    while mask != 0 {
        act(mask.trailing_zeros() as usize);
        mask &= mask - 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lanes that every register divides.
    const COUNT: usize = 2 * MOST_LANES;

    /// Every operation on one register after the other, as bits; `bits` of a number.
    fn operations<L: Lanes>(token: L::Token, x: &[L::T], y: &[L::T], bits: impl Fn(L::T) -> u64) -> Vec<u64> {
        let (mut found, mut masks) = (Vec::new(), 0u64);
        for at in (0..COUNT).step_by(L::LANES) {
            let (a, b) = (L::load(token, x, at), L::load(token, y, at));
            let above = a.above(b);
            let chosen = above.bits();
            masks |= u64::from(chosen) << at;
            for mask in [above & a.above(b), above | above.but_not(above)] {
                assert_eq!((mask.bits(), mask.but_not(above).bits()), (chosen, 0));
            }
            let all = [a + b, a - b, a * b, a / b, a.times_plus(b, a), (b * b).sqrt(), a.max(b)];
            let all = all.into_iter().chain([a.or(above, b), a.keyed(at), L::all(token, y[at - at % MOST_LANES])]);
            let all = all.chain([L::of_lanes(token, |l| x[at + l]) * b]);
            let mut place = x.to_vec();
            for register in all {
                register.store(&mut place, at);
                found.extend(place[at..at + L::LANES].iter().map(|number| bits(*number)));
            }
            a.front(chosen).store(&mut place, at);
            found.extend(place[at..at + chosen.count_ones() as usize].iter().map(|number| bits(*number)));
        }
        // By operation and lane, whatever the width: sorted, since front has as many as are above.
        found.sort_unstable();
        found.push(masks);
        let mut largest = L::load(token, x, 0);
        (0..COUNT).step_by(L::LANES).for_each(|at| largest = largest.max(L::load(token, x, at)));
        found.push(bits(largest.largest()));
        found
    }

    struct All;

    impl Vectorized for All {
        type Output = Vec<u64>;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Vec<u64> {
            let number = |i: usize, step: f64| (i as f64 * step).rem_euclid(7.0) - 3.0;
            let x: [f64; COUNT] = std::array::from_fn(|i| number(i, 1.37));
            let y: [f64; COUNT] = std::array::from_fn(|i| number(i, 2.61));
            let (small_x, small_y) = (x.map(|x| x as f32), y.map(|y| y as f32));
            let mut found = operations::<S::F64>(simd, &x, &y, f64::to_bits);
            found.extend(operations::<S::F32>(simd, &small_x, &small_y, |x| u64::from(x.to_bits())));
            simd.afresh(&found).clone()
        }
    }

    #[test]
    fn every_set_of_instructions_finds_the_bits_of_the_portable_one() {
        let portable = All.run(portable::Portable::new());
        for isa in Isa::ALL {
            choose(isa);
            assert_eq!(dispatch(All), portable, "{isa:?}");
        }
        choose(Isa::Avx512);
    }
}
