//! The slow tier: `cargo test --release -p meso-collision --test collision -- --ignored slow`. It takes a million pairs;
//! `PAIRS=10000000` before the command takes as many as `docs/measured/accuracy.md` tells of.

use super::dice::Dice;
use super::families;
use super::reference;
use meso_collision::gjk::{self, Algorithm};
use rayon::prelude::*;
use std::time::Instant;

/// Pairs of a long test: `usual`, or `PAIRS` of the environment.
pub(crate) fn pairs(usual: u64) -> u64 {
    std::env::var("PAIRS").map_or(usual, |pairs| pairs.parse().expect("PAIRS is a number"))
}

#[test]
#[ignore = "slow tier: a million pairs, a minute of processor time"]
fn floating_point_and_exact_arithmetic_agree_on_a_million_pairs() {
    let families: Vec<_> = families::ALL.iter().filter(|(name, _)| *name != "fine spheres").collect();
    let wrong: Vec<u64> = (0..pairs(1_000_000))
        .into_par_iter()
        .filter(|&seed| {
            let (a, b) = families[seed as usize % families.len()].1(&mut Dice::new(1 << 40 | seed));
            gjk::intersects(&a, &b) != Algorithm::Exact.intersects(&a, &b)
        })
        .collect();
    assert_eq!(wrong, [0; 0], "seeds of pairs with different answers");
}

#[test]
#[ignore = "slow tier: 10^5 pairs against the linear programme"]
fn answers_agree_with_the_linear_programme_on_a_hundred_thousand_pairs() {
    let families: Vec<_> = families::ALL.iter().filter(|(name, _)| *name != "fine spheres").collect();
    let wrong: Vec<u64> = (0..100_000u64)
        .into_par_iter()
        .filter(|&seed| {
            let (a, b) = families[seed as usize % families.len()].1(&mut Dice::new(1 << 41 | seed));
            gjk::intersects(&a, &b).unwrap() != reference::intersects(&a, &b)
        })
        .collect();
    assert_eq!(wrong, [0; 0], "seeds of wrong answers");
}

#[test]
#[ignore = "slow tier: measures time, and wants a quiet machine"]
fn no_yes_or_no_takes_more_than_a_millisecond() {
    let mut slow = Vec::new();
    for (name, family) in families::ALL {
        for seed in 0..500 {
            let (a, b) = family(&mut Dice::new(seed));
            // The best of three: the machine may have been busy with something else.
            let best = (0..3).map(|_| seconds(|| gjk::intersects(&a, &b))).fold(f64::INFINITY, f64::min);
            if best > 1e-3 {
                slow.push((name, seed, best));
            }
        }
    }
    assert!(slow.is_empty(), "{slow:?}");
}

fn seconds<T>(run: impl FnOnce() -> T) -> f64 {
    let start = Instant::now();
    std::hint::black_box(run());
    start.elapsed().as_secs_f64()
}
