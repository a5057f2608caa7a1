//! Properties of whatever a strategy draws; a case that breaks one is shrunk before it is shown.
//!
//! The whole suite draws the same cases every time, so that it fails for a change alone. With `CASES=new` before the command
//! they are new ones, and ten times as many: the slow tier's. A failure names its seed, and `CASES=seed` draws that again.

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngSeed, TestCaseResult, TestRunner};
use std::cell::Cell;
use std::env;
use std::hash::{BuildHasher, RandomState};

/// Runs a property on so many cases; panics with the smallest that breaks it.
pub(crate) fn holds<S: Strategy>(cases: u32, drawn: &S, property: impl Fn(S::Value) -> TestCaseResult) {
    let (seed, times) = match env::var("CASES") {
        Err(_) => (0, 1),
        Ok(new) if new == "new" => (RandomState::new().hash_one(cases), 10),
        Ok(seed) => (seed.parse().expect("CASES is new or a seed"), 10),
    };
    let config = Config {
        cases: cases * times,
        rng_seed: RngSeed::Fixed(seed),
        // The shrunk case belongs into a test of its own.
        failure_persistence: None,
        max_shrink_iters: 10_000,
        ..Config::default()
    };
    if let Err(broken) = TestRunner::new(config).run(drawn, property) {
        panic!("{broken}\nCASES={seed} before the command draws it again");
    }
}

/// The share of cases that are of some kind, so that a property cannot hold for want of them.
#[derive(Default)]
pub(crate) struct Share {
    these: Cell<u32>,
    all: Cell<u32>,
}

impl Share {
    pub(crate) fn count(&self, is_of_the_kind: bool) {
        self.these.set(self.these.get() + u32::from(is_of_the_kind));
        self.all.set(self.all.get() + 1);
    }

    pub(crate) fn get(&self) -> f64 {
        f64::from(self.these.get()) / f64::from(self.all.get())
    }
}
