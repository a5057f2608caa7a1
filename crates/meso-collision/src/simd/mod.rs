//! The widest vector instructions of the machine: one choice, at run time, for the whole crate.
//!
//! [`widest`] runs plain loops, which the compiler vectorizes; `dispatch` runs code that is written with `Lanes`. The
//! compiler never fuses or reorders floating-point operations, and fused multiply-adds are exact to define, so every
//! instruction set finds the same bits. A value of a vector type is made from a token of its instruction set, and a
//! token only by `dispatch`, after detection: so the operations on it are safe.
//!
//! pulp 0.22 was tried in its place. It finds the same bits, and a support of two bodies takes as long with it. But its
//! portable trait has no compress, expand or transposed loads, which lockstep lives on, so those would stay intrinsics
//! of ours; and building it takes 12 s of processor time, a twentieth of the whole release build.
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

/// Runs `work` on `isa`, or the machine's widest set where that is narrower, whatever other threads choose.
#[cfg(test)]
pub(crate) fn dispatch_on<V: Vectorized>(isa: Isa, work: V) -> V::Output {
    // SAFETY: no set beyond the detected one is taken.
    unsafe { on(isa.min(Isa::best()), work) }
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
    struct Plain<W>(W);
    impl<W: Wide> Vectorized for Plain<W> {
        type Output = W::Output;
        #[inline(always)]
        fn run<S: Simd>(self, _: S) -> W::Output {
            self.0.run()
        }
    }
    dispatch(Plain(work))
}

/// The token of an instruction set.
pub(crate) trait Simd: Copy {
    /// Its register of f32.
    type F32: Lockstep<Token = Self>;
    /// Its register of f64.
    type F64: Lanes<T = f64, Token = Self>;
    /// True where many pairs in lockstep take less than two thirds of the time of one after the other: as measured.
    const LOCKSTEP_PAYS: bool;

    /// The columns of as many rows as a register has f64.
    fn columns(self, rows: &[&[f32; 8]; MOST_LANES]) -> [Self::F64; 8];

    /// The columns of as many rows as a register has f32.
    #[inline(always)]
    fn narrow_columns(self, rows: &[&[f32; 8]; MOST_LANES]) -> [Self::F32; 8] {
        std::array::from_fn(|column| Self::F32::of_lanes(self, |l| rows[l][column]))
    }

    /// The coordinates of as many vectors as a register has f64.
    #[inline(always)]
    fn coordinates(self, vectors: &[&[f64; 3]; MOST_LANES]) -> [Self::F64; 3] {
        std::array::from_fn(|axis| Self::F64::of_lanes(self, |l| vectors[l][axis]))
    }

    /// The rows of these columns, rounded: those of the lanes of the mask come first in `rows`, and the rest has no
    /// meaning. The last number of each is the bits of `first` plus its lane. Returns how many there are.
    #[inline(always)]
    fn store_rows(self, columns: [Self::F64; 7], first: u32, mask: u32, rows: &mut [Row]) -> usize {
        let (columns, mut taken) = (columns.map(Lanes::to_array), 0);
        for l in 0..Self::F64::LANES {
            let [c0, c1, c2, c3, c4, c5, c6] = columns.each_ref().map(|column| column.as_ref()[l] as f32);
            rows[taken] = Row([c0, c1, c2, c3, c4, c5, c6, f32::from_bits(first + l as u32)]);
            taken += (mask >> l & 1) as usize;
        }
        taken
    }

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

/// Eight numbers in one cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(align(32))]
pub(crate) struct Row(pub(crate) [f32; 8]);

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
    type Array: Copy + AsRef<[Self::T]>;
    /// Some of its lanes.
    type Mask: Mask;
    /// Number of lanes, at most [`MOST_LANES`].
    const LANES: usize;

    /// To memory.
    fn to_array(self) -> Self::Array;
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
    /// self * factor - term, rounded once.
    fn times_minus(self, factor: Self, term: Self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
    /// The larger number of each lane.
    fn max(self, other: Self) -> Self;
    /// The lanes of these bits.
    fn mask(token: Self::Token, bits: u32) -> Self::Mask;
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
    /// The largest lane of each of as many registers as there are lanes, in their order.
    fn largest_of_each<E: Each<Self>>(registers: &E) -> Self;
}

/// A register for each lane of another. A trait and not a closure, which would not inherit the instruction set.
pub(crate) trait Each<L> {
    /// The register of lane `l`.
    fn register(&self, l: usize) -> L;
}

/// Operations that only a search in lockstep needs.
pub(crate) trait Lockstep: Lanes<T = f32> {
    /// The lanes of the mask filled, from the first on, with the numbers from `from[at]` on, as many as there are
    /// lanes.
    fn refilled(self, mask: u32, from: &[f32], at: usize) -> Self;
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
            for mask in [above & a.above(b), above | above.but_not(above), L::mask(token, chosen)] {
                assert_eq!((mask.bits(), mask.but_not(above).bits()), (chosen, 0));
            }
            let all = [a + b, a - b, a * b, a / b, a.times_plus(b, a), a.times_minus(b, a), b.abs().sqrt(), a.max(b)];
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

    /// Each register begins one number later than the one before.
    struct Later<'a, L: Lanes>(L::Token, &'a [L::T; COUNT]);

    impl<L: Lanes> Each<L> for Later<'_, L> {
        #[inline(always)]
        fn register(&self, l: usize) -> L {
            L::load(self.0, self.1, l)
        }
    }

    fn largest_of_each<L: Lanes<T: PartialEq + std::fmt::Debug>>(
        token: L::Token,
        x: &[L::T; COUNT],
        is_larger: impl Fn(&L::T, &L::T) -> bool,
    ) {
        let stored = L::largest_of_each(&Later::<L>(token, x)).to_array();
        for (i, largest) in stored.as_ref().iter().enumerate() {
            let own = x[i..i + L::LANES].iter().reduce(|most, it| if is_larger(it, most) { it } else { most });
            assert_eq!(Some(largest), own);
        }
    }

    fn rows_and_columns<S: Simd>(simd: S, rows: &[[f32; 8]; MOST_LANES], x: &[f64; COUNT]) {
        for (column, register) in simd.narrow_columns(&rows.each_ref()).into_iter().enumerate() {
            let stored = register.to_array();
            stored.as_ref().iter().zip(rows).for_each(|(number, row)| assert_eq!(*number, row[column]));
        }
        let vectors: [[f64; 3]; MOST_LANES] = std::array::from_fn(|l| [x[l], x[l + 1], x[l + 2]]);
        for (axis, register) in simd.coordinates(&vectors.each_ref()).into_iter().enumerate() {
            let stored = register.to_array();
            stored.as_ref().iter().zip(&vectors).for_each(|(number, vector)| assert_eq!(*number, vector[axis]));
        }
        let columns: [S::F64; 7] = std::array::from_fn(|column| S::F64::load(simd, x, column));
        for mask in 0..1 << S::F64::LANES {
            let mut stored = [Row::default(); MOST_LANES];
            let taken = simd.store_rows(columns, 100, mask, &mut stored[..S::F64::LANES]);
            let chosen = (0..S::F64::LANES).filter(|l| mask >> l & 1 == 1);
            assert_eq!(taken, chosen.clone().count());
            for (Row(row), l) in stored.iter().zip(chosen) {
                (0..7).for_each(|column| assert_eq!(row[column], x[column + l] as f32));
                assert_eq!(row[7].to_bits(), 100 + l as u32);
            }
        }
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
            let rows: [[f32; 8]; MOST_LANES] = std::array::from_fn(|row| std::array::from_fn(|i| (8 * row + i) as f32));
            for (column, register) in simd.columns(&rows.each_ref()).into_iter().enumerate() {
                let mut stored = [0.0; MOST_LANES];
                register.store(&mut stored, 0);
                (0..S::F64::LANES).for_each(|row| assert_eq!(stored[row], f64::from(rows[row][column])));
            }
            rows_and_columns(simd, &rows, &x);
            largest_of_each::<S::F32>(simd, &small_x, |x, y| x > y);
            largest_of_each::<S::F64>(simd, &x, |x, y| x > y);
            let mut stored = [0.0; MOST_LANES];
            S::F32::all(simd, 1.0).refilled(0b101, &small_y, 3).store(&mut stored, 0);
            assert_eq!(stored[..4], [small_y[3], 1.0, small_y[4], 1.0]);
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
