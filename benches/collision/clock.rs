//! Processor time of this thread, and medians: the machine may be busy with other things.
#![allow(unsafe_code, reason = "the C library's clock")]

use std::ffi::{c_int, c_long};

/// Seconds of processor time this thread has used.
pub fn seconds() -> f64 {
    #[repr(C)]
    struct Timespec {
        seconds: i64,
        nanoseconds: c_long,
    }
    unsafe extern "C" {
        fn clock_gettime(clock: c_int, time: *mut Timespec) -> c_int;
    }
    const THREAD_CPU_TIME: c_int = 3;
    let mut now = Timespec { seconds: 0, nanoseconds: 0 };
    // SAFETY: `now` is a timespec of 64-bit Linux, and outlives the call.
    unsafe { clock_gettime(THREAD_CPU_TIME, &raw mut now) };
    now.seconds as f64 + now.nanoseconds as f64 * 1e-9
}

/// A contestant: answers a slice of queries and returns how many were yes.
pub type Contestant<'a, Q> = (String, Box<dyn Fn(&[Q]) -> usize + 'a>);

/// Median seconds per query of each contestant, on the same queries, taking turns chunk by chunk.
///
/// A turn is two passes over the chunk, of which the second counts: what one contestant leaves in the caches is not to be
/// the next one's handicap.
pub fn compare<Q>(contestants: &[Contestant<'_, Q>], queries: &[Q], chunk: usize, rounds: usize) -> Vec<f64> {
    let mut totals = vec![0.0; contestants.len()];
    for part in queries.chunks(chunk) {
        let mut samples = vec![Vec::with_capacity(rounds); contestants.len()];
        for _ in 0..rounds {
            for (i, (_, run)) in contestants.iter().enumerate() {
                std::hint::black_box(run(part));
                let start = seconds();
                std::hint::black_box(run(part));
                samples[i].push(seconds() - start);
            }
        }
        for (total, sample) in totals.iter_mut().zip(&mut samples) {
            *total += median(sample);
        }
    }
    totals.iter().map(|t| t / queries.len() as f64).collect()
}

pub fn median(sample: &mut [f64]) -> f64 {
    sample.sort_by(f64::total_cmp);
    sample[sample.len() / 2]
}
