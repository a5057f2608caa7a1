//! The end of long work that nobody waits for: it unwinds at its next [`point`].

use std::cell::RefCell;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    static ABANDONED: RefCell<Option<Arc<AtomicBool>>> = const { RefCell::new(None) };
}

/// Payload with which stopped work unwinds. No panic hook is run, and nothing is printed.
#[derive(Clone, Copy, Debug)]
pub struct Stopped;

/// Ends work on this thread at its next [`point`] once the flag is true. The flag that the thread had before is returned.
pub fn listen_to(flag: Option<Arc<AtomicBool>>) -> Option<Arc<AtomicBool>> {
    ABANDONED.replace(flag)
}

/// Unwinds where the thread's flag is true. It takes 2 ns; pass one about every microsecond to millisecond.
///
/// A parallel loop of many short steps with a point needs rayon's `panic_fuse()`. Without it every piece of the loop unwinds
/// by itself, and pieces are split on down to single steps: of 3.5 million that took 19 s.
#[inline]
pub fn point() {
    if ABANDONED.with_borrow(|flag| flag.as_ref().is_some_and(|flag| flag.load(Ordering::Relaxed))) {
        std::panic::resume_unwind(Box::new(Stopped));
    }
}
