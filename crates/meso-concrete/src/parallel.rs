//! Loops shared among threads. The code that names rayon's iterators is compiled once, and calls a pointer: one loop
//! for each type of result was a sixth of this crate's code.
//!
//! Items are cut into runs, `RUNS` a thread at the most. Each item passes a [`stop::point`], 2 ns, unless a name says that
//! items are short. All loops keep the order of their items, and end early where one of them panics, as a stop does.

use crate::stop;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Runs for each thread: enough to even out their costs. Each may have memory of its own, so that more cost time.
const RUNS: usize = 32;

/// Calls `of` for every number below `count`.
fn shared(count: usize, of: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().panic_fuse().for_each(of);
}

/// Length of a loop's runs.
fn run_len(count: usize) -> usize {
    count.div_ceil(RUNS * rayon::current_num_threads()).max(1)
}

/// All that `of` pushes for the runs of the numbers below `count`, in order.
fn gathered<T: Send>(count: usize, of: &(dyn Fn(Range<usize>, &mut Vec<T>) + Sync)) -> Vec<T> {
    let len = run_len(count);
    let runs: Vec<Mutex<Vec<T>>> = (0..count.div_ceil(len)).map(|_| Mutex::default()).collect();
    let total = AtomicUsize::new(0);
    shared(runs.len(), &|run| {
        let mut found = Vec::new();
        of(run * len..count.min((run + 1) * len), &mut found);
        total.fetch_add(found.len(), Ordering::Relaxed);
        *runs[run].lock().unwrap_or_else(PoisonError::into_inner) = found;
    });
    let mut all = Vec::with_capacity(total.into_inner());
    for run in runs {
        all.append(&mut run.into_inner().unwrap_or_else(PoisonError::into_inner));
    }
    all
}

/// `of(i)` for every number below `count`.
pub fn map<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    map_with(count, || (), |(), i| of(i))
}

/// `of(scratch, i)` for every number below `count`; each run of numbers has one scratch.
pub fn map_with<S, T: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync,
    of: impl Fn(&mut S, usize) -> T + Sync,
) -> Vec<T> {
    gathered(count, &|run, found| {
        let mut scratch = scratch();
        found.reserve(run.len());
        for i in run {
            stop::point();
            found.push(of(&mut scratch, i));
        }
    })
}

/// Short items for one [`stop::point`].
const SHORT: usize = 1 << 10;

/// Like [`map`], for many short items: they are written in their place, with a [`stop::point`] for every thousand.
pub fn map_short<T: Copy + Default + Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut items = vec![T::default(); count];
    each_short_mut(&mut items, |i, item| *item = of(i));
    items
}

/// `of(item)` for every item.
pub fn map_each<I: Sync, T: Send>(items: &[I], of: impl Fn(&I) -> T + Sync) -> Vec<T> {
    map(items.len(), |i| of(&items[i]))
}

/// `of(i)` for every number below `count`.
///
/// # Errors
/// The first one in the order of the numbers; the others are worked out all the same.
pub fn try_map<T: Send, E: Send>(count: usize, of: impl Fn(usize) -> Result<T, E> + Sync) -> Result<Vec<T>, E> {
    map(count, of).into_iter().collect()
}

/// All that `of(i)` yields for every number below `count`, in one list.
pub fn flat_map<T: Send, I: IntoIterator<Item = T>>(count: usize, of: impl Fn(usize) -> I + Sync) -> Vec<T> {
    gathered(count, &|run, found| {
        for i in run {
            stop::point();
            found.extend(of(i));
        }
    })
}

/// The numbers below `count` for which `keep` holds.
pub fn filter(count: usize, keep: impl Fn(usize) -> bool + Sync) -> Vec<u32> {
    flat_map(count, |i| keep(i).then_some(i as u32))
}

/// The items for which `keep` holds.
pub fn pick<T: Copy + Send + Sync>(items: &[T], keep: impl Fn(&T) -> bool + Sync) -> Vec<T> {
    flat_map(items.len(), |i| keep(&items[i]).then_some(items[i]))
}

/// The first thing that `find` yields in the order of the numbers below `count`. Once it has yielded something, only
/// smaller numbers are asked.
pub fn find<T: Send>(count: usize, find: impl Fn(usize) -> Option<T> + Sync) -> Option<T> {
    let first = AtomicUsize::new(usize::MAX);
    let found = flat_map(count, |i| {
        let found = if i < first.load(Ordering::Relaxed) { find(i) } else { None };
        if found.is_some() {
            first.fetch_min(i, Ordering::Relaxed);
        }
        found
    });
    found.into_iter().next()
}

/// Calls `of` for every item and its number.
pub fn each_mut<T: Send>(items: &mut [T], of: impl Fn(usize, &mut T) + Sync) {
    each_mut_with(items, || (), |(), i, item| of(i, item));
}

/// Like [`each_mut`], for many short items: with a [`stop::point`] for every thousand.
pub fn each_short_mut<T: Send>(items: &mut [T], of: impl Fn(usize, &mut T) + Sync) {
    chunks_mut(items, SHORT, |chunk, items| (chunk * SHORT..).zip(items).for_each(|(i, item)| of(i, item)));
}

/// Calls `of` with every item, its number and a scratch, which a run of items shares.
pub fn each_mut_with<S, T: Send>(
    items: &mut [T],
    scratch: impl Fn() -> S + Sync,
    of: impl Fn(&mut S, usize, &mut T) + Sync,
) {
    changed(items, 1, &|first, run| {
        let mut scratch = scratch();
        for (i, item) in (first..).zip(run) {
            stop::point();
            of(&mut scratch, i, item);
        }
    });
}

/// Calls `of` for every chunk of `size` items, the last one shorter, and the chunk's number.
pub fn chunks_mut<T: Send>(items: &mut [T], size: usize, of: impl Fn(usize, &mut [T]) + Sync) {
    changed(items, size, &|first, run| {
        for (i, chunk) in (first..).zip(run.chunks_mut(size)) {
            stop::point();
            of(i, chunk);
        }
    });
}

/// Calls `of` for runs of chunks of `size` items, and the number of the first chunk.
fn changed<T: Send>(items: &mut [T], size: usize, of: &(dyn Fn(usize, &mut [T]) + Sync)) {
    let len = run_len(items.len().div_ceil(size));
    let runs: Vec<_> = items.chunks_mut(len * size).map(Mutex::new).collect();
    shared(runs.len(), &|run| of(run * len, &mut runs[run].lock().unwrap_or_else(PoisonError::into_inner)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_loop_keeps_the_order_of_its_items() {
        let numbers: Vec<usize> = (0..10_000).collect();
        assert_eq!(map(10_000, |i| i), numbers);
        assert_eq!(map_short(10_000, |i| i), numbers);
        assert_eq!(map_with(10_000, || 0, |_, i| i), numbers);
        assert_eq!(map_each(&numbers, |i| i + 1), (1..10_001).collect::<Vec<_>>());
        assert_eq!(flat_map(10_000, |i| [i, i]), numbers.iter().flat_map(|&i| [i, i]).collect::<Vec<_>>());
        assert_eq!(filter(10_000, |i| i % 3 == 0), (0..10_000).step_by(3).collect::<Vec<u32>>());
        let mut squares = vec![0; 10_000];
        each_mut(&mut squares, |i, square| *square = i * i);
        let mut in_runs = vec![0; 10_000];
        each_short_mut(&mut in_runs, |i, square| *square = i * i);
        assert_eq!(pick(&in_runs, |square| square % 2 == 1), (1..10_000).step_by(2).map(|i| i * i).collect::<Vec<_>>());
        let mut runs = vec![0; 10_000];
        chunks_mut(&mut runs, 7, |run, items| {
            for (k, item) in items.iter_mut().enumerate() {
                *item = (7 * run + k) * (7 * run + k);
            }
        });
        assert!(squares == in_runs && squares == runs && squares[99] == 9801 && runs[9999] == 9999 * 9999);
    }

    #[test]
    fn find_yields_the_first_hit_in_order() {
        assert_eq!(find(10_000, |i| (i % 4000 == 3999).then_some(i)), Some(3999));
        assert_eq!(find(10_000, |_| None::<()>), None);
    }

    #[test]
    fn try_map_yields_the_first_error_in_order() {
        assert_eq!(try_map(1000, |i| if i % 400 == 399 { Err(i) } else { Ok(i) }), Err(399));
        assert_eq!(try_map(3, Ok::<_, ()>), Ok(vec![0, 1, 2]));
    }
}
