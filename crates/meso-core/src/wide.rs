//! Runs a loop on the widest vector registers there are, without changing a bit of its result.
//!
//! The compiler never fuses or reorders floating-point operations, so the same code gives the same bits on every
//! instruction set; it only gets faster.
#![allow(unsafe_code)]

/// Work that gains from wide registers. A trait and not a closure: only a named function can be marked
/// `inline(always)`, and code that is not inlined is compiled for narrow registers.
pub(crate) trait Wide {
    /// What comes of it.
    type Output;

    /// Does the work. Give it `#[inline(always)]`, and all that it calls.
    fn run(self) -> Self::Output;
}

/// Runs `work`, compiled for AVX-512 or AVX2 where the machine has it.
#[inline]
pub(crate) fn widest<W: Wide>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx512dq") && is_x86_feature_detected!("avx512vl") {
        // SAFETY: the features were detected; they imply avx512f.
        return unsafe { on_avx512(work) };
    } else if is_x86_feature_detected!("avx2") {
        // SAFETY: the feature was detected.
        return unsafe { on_avx2(work) };
    }
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512dq,avx512vl")]
fn on_avx512<W: Wide>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn on_avx2<W: Wide>(work: W) -> W::Output {
    work.run()
}
