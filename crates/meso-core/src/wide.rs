//! Runs a loop on the widest vector registers there are, without changing a bit of its result.
//!
//! The compiler never fuses or reorders floating-point operations, so the same code gives the same bits on every
//! instruction set; it only gets faster.
#![allow(unsafe_code)]

/// Runs `work`, compiled for AVX2 where the machine has it. What `work` calls must be `#[inline(always)]` to gain.
#[inline]
pub(crate) fn widest<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        // SAFETY: the feature was detected.
        return unsafe { on_avx2(work) };
    }
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn on_avx2<R>(work: impl FnOnce() -> R) -> R {
    work()
}
