//! The end of work that nobody waits for: it unwinds at its next [`point`].
//!
//! Packing and a test end at [`Watch::stops`] with the best they have. A check, statistics or half a mesh is worth nothing when
//! nobody waits for it; a flag handed to each of its loops would take a hundred signatures. So the threads of a pool listen
//! to the [`Watch`], and long loops pass a point.

use crate::watch::{Waiting, Watch};
use meso_collision::stop::listen_to;
pub use meso_collision::stop::{Stopped, point};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

/// Ends work on this thread from the moment when `watch` is [abandoned](Watch::abandoned). Whoever starts the work catches the
/// unwinding: see [`Stopped`].
pub fn listen(watch: &dyn Watch) {
    // The watch's flag and not the watch: a call through its table would cost a point as much again.
    listen_to(watch.abandoned());
}

/// The deadline passed before the work was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Late;

/// The time between two looks at the deadline.
const LOOK: Duration = Duration::from_millis(20);

/// Does work on this thread that ends at its next [`point`] once the deadline has passed. Loops of a pool within the work do
/// not hear the deadline.
///
/// # Errors
/// [`Late`] where the work ended by the deadline. Work that the thread's own flag ends unwinds on.
pub fn until<T>(waiting: Waiting<'_>, work: impl FnOnce() -> T) -> Result<T, Late> {
    if waiting.deadline == f64::INFINITY {
        return Ok(work());
    }
    let (ends, is_late, is_done) = (Arc::new(AtomicBool::new(false)), AtomicBool::new(false), AtomicBool::new(false));
    let outer = listen_to(Some(Arc::clone(&ends)));
    let looks = || {
        while !is_done.load(Ordering::Relaxed) {
            let passed = waiting.watch.seconds() >= waiting.deadline;
            if passed || outer.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed)) {
                is_late.store(passed, Ordering::Relaxed);
                ends.store(true, Ordering::Relaxed);
                return;
            }
            thread::park_timeout(LOOK);
        }
    };
    let done = thread::scope(|scope| {
        let looking = scope.spawn(looks);
        let done = catch_unwind(AssertUnwindSafe(work));
        is_done.store(true, Ordering::Relaxed);
        looking.thread().unpark();
        done
    });
    listen_to(outer);
    match done {
        Ok(done) => Ok(done),
        Err(payload) if payload.is::<Stopped>() && is_late.into_inner() => Err(Late),
        Err(payload) => resume_unwind(payload),
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

    /// Its clock is at 1 s from the fourth question on.
    #[derive(Default)]
    struct Clock(AtomicU32);

    impl Watch for Clock {
        fn seconds(&self) -> f64 {
            f64::from(u8::from(self.0.fetch_add(1, Ordering::Relaxed) >= 3))
        }
    }

    #[test]
    fn work_ends_at_its_deadline_and_the_thread_goes_on() {
        let endless = || loop {
            point();
            thread::sleep(Duration::from_millis(1));
        };
        let clock = Clock::default();
        let waiting = Waiting { watch: &clock, deadline: 1.0 };
        assert_eq!(until(waiting, endless), Err::<(), _>(Late));
        point();
        assert_eq!(until(Waiting { watch: &Clock::default(), deadline: 2.0 }, || 7), Ok(7));
        assert_eq!(until(Waiting { watch: &Clock::default(), deadline: f64::INFINITY }, || 8), Ok(8));
    }

    #[test]
    fn work_with_a_deadline_still_hears_that_nobody_waits() {
        let flag = Flag::default();
        listen(&flag);
        flag.0.store(true, Ordering::Relaxed);
        let clock = Clock::default();
        let work = || {
            until(Waiting { watch: &clock, deadline: 2.0 }, || {
                loop {
                    point();
                    thread::sleep(Duration::from_millis(1));
                }
            })
        };
        let ended = catch_unwind(AssertUnwindSafe(|| -> Result<(), Late> { work() }));
        listen_to(None);
        assert!(ended.unwrap_err().is::<Stopped>());
    }
}
