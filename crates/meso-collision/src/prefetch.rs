//! Software prefetch: lets several cache misses overlap.
#![allow(unsafe_code)]

/// Begins to bring `there` near, where the machine can be asked to.
#[inline(always)]
pub fn prefetch<T>(there: &[T]) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        /// Bytes that come at once.
        const LINE: usize = 64;
        let bytes: *const i8 = there.as_ptr().cast();
        for at in (0..size_of_val(there)).step_by(LINE) {
            // SAFETY: the address lies within the slice; and a prefetch reads nothing that anyone could notice.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(bytes.add(at)) };
        }
    }
    let _ = there;
}
