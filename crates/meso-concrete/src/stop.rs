//! The end of work that nobody waits for: it unwinds at its next [`point`].
//!
//! Packing and a test end at [`Watch::stops`] with the best they have. A check, statistics or half a mesh is worth nothing when
//! nobody waits for it; a flag handed to each of its loops would take a hundred signatures. So the threads of a pool listen
//! to the [`Watch`], and long loops pass a point.

use crate::watch::Watch;
use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    // The watch's flag and not the watch: a call through its table would cost a point as much again.
    static ABANDONED: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Payload with which stopped work unwinds. No panic hook is run, and nothing is printed.
#[derive(Clone, Copy, Debug)]
pub struct Stopped;

/// Ends work on this thread from the moment when `watch` is [abandoned](Watch::abandoned). Whoever starts the work catches the
/// unwinding: see [`Stopped`].
pub fn listen(watch: &dyn Watch) {
    ABANDONED.set(watch.abandoned());
}

/// Unwinds where the thread's watch is abandoned. It takes 2 ns; pass one about every microsecond to millisecond.
///
/// A parallel loop of many short steps with a point needs rayon's `panic_fuse()`. Without it every piece of the loop unwinds
/// by itself, and pieces are split on down to single steps: of 3.5 million that took 19 s.
#[inline]
pub fn point() {
    if ABANDONED.with_borrow(|flag| flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))) {
        std::panic::resume_unwind(Box::new(Stopped));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};
    use std::sync::atomic::AtomicU32;

    #[derive(Clone, Default)]
    struct Flag(Arc<AtomicBool>);

    impl Watch for Flag {
        fn abandoned(&self) -> Option<Arc<AtomicBool>> {
            Some(Arc::clone(&self.0))
        }
    }

    #[test]
    fn loops_of_a_pool_end_at_their_next_point() {
        let flag = Flag::default();
        let heard = flag.clone();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).start_handler(move |_| listen(&heard));
        let pool = pool.build().unwrap();
        let seen = AtomicU32::new(0);
        let work = || {
            (0..1_000_000).into_par_iter().for_each(|_| {
                point();
                if seen.fetch_add(1, Ordering::Relaxed) == 1000 {
                    flag.0.store(true, Ordering::Relaxed);
                }
            });
        };
        let ended = catch_unwind(AssertUnwindSafe(|| pool.install(work)));
        assert!(ended.unwrap_err().is::<Stopped>());
        assert!((1000..100_000).contains(&seen.load(Ordering::Relaxed)), "{seen:?}");
        point();
    }
}
