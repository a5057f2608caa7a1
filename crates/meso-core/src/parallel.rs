//! Loops shared among threads, each compiled once for a type of result: a loop that names rayon's iterators has all of
//! their machinery compiled for its closures, a tenth of a second of each build.
//!
//! An item costs a call through a pointer, 2 ns, and a [`stop::point`], so what is cheaper than that goes in runs. All loops
//! keep the order of their items, and end early where one of them panics, as a stop does.

use crate::stop;
use rayon::prelude::*;

/// `of(i)` for every number below `count`.
pub(crate) fn map<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    mapped(count, &of)
}

fn mapped<T: Send>(count: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    // `collect` compiles a second loop, for iterators of unknown length.
    let mut all = Vec::new();
    let of = |i: usize| {
        stop::point();
        of(i)
    };
    (0..count).into_par_iter().panic_fuse().map(of).collect_into_vec(&mut all);
    all
}

/// `of(item)` for every item.
pub(crate) fn map_each<I: Sync, T: Send>(items: &[I], of: impl Fn(&I) -> T + Sync) -> Vec<T> {
    mapped(items.len(), &|i| of(&items[i]))
}

/// `of(i)` for every number below `count`.
///
/// # Errors
/// The first one in the order of the numbers; the others are worked out all the same.
pub(crate) fn try_map<T: Send, E: Send>(count: usize, of: impl Fn(usize) -> Result<T, E> + Sync) -> Result<Vec<T>, E> {
    mapped(count, &of).into_iter().collect()
}

/// All that `of(i)` yields for every number below `count`, in one list.
pub(crate) fn flat_map<T: Send, I: IntoIterator<Item = T>>(count: usize, of: impl Fn(usize) -> I + Sync) -> Vec<T> {
    gathered(count, &|i, found| found.extend(of(i)))
}

/// Lists that are put together at the end.
const PIECES: usize = 256;

fn gathered<T: Send>(count: usize, of: &(dyn Fn(usize, &mut Vec<T>) + Sync)) -> Vec<T> {
    let size = count.div_ceil(PIECES).max(1);
    let pieces = mapped(count.div_ceil(size), &|piece| {
        let mut found = Vec::new();
        (piece * size..count.min((piece + 1) * size)).for_each(|i| of(i, &mut found));
        found
    });
    let mut all = Vec::with_capacity(pieces.iter().map(Vec::len).sum());
    pieces.into_iter().for_each(|piece| all.extend(piece));
    all
}

/// The numbers below `count` for which `keep` holds.
pub(crate) fn filter(count: usize, keep: impl Fn(usize) -> bool + Sync) -> Vec<u32> {
    gathered(count, &|i, found| found.extend(keep(i).then_some(i as u32)))
}

/// The items for which `keep` holds.
pub(crate) fn pick<T: Copy + Send + Sync>(items: &[T], keep: impl Fn(&T) -> bool + Sync) -> Vec<T> {
    gathered(items.len(), &|i, found| found.extend(keep(&items[i]).then_some(items[i])))
}

/// Calls `of` for every item and its number.
pub(crate) fn each_mut<T: Send>(items: &mut [T], of: impl Fn(usize, &mut T) + Sync) {
    chunks_mut(items, 1, |i, item| of(i, &mut item[0]));
}

/// As [`each_mut`], in runs: for items that take less time than a call through a pointer.
pub(crate) fn each_mut_in_runs<T: Send>(items: &mut [T], of: impl Fn(usize, &mut T) + Sync) {
    chunks_mut(items, RUN, |run, items| (run * RUN..).zip(items).for_each(|(i, item)| of(i, item)));
}

/// Calls `of` for every run of `size` items, the last one shorter, and the run's number.
pub(crate) fn chunks_mut<T: Send>(items: &mut [T], size: usize, of: impl Fn(usize, &mut [T]) + Sync) {
    changed(items, size, &of);
}

fn changed<T: Send>(items: &mut [T], size: usize, of: &(dyn Fn(usize, &mut [T]) + Sync)) {
    items.par_chunks_mut(size).enumerate().panic_fuse().for_each(|(i, run)| {
        stop::point();
        of(i, run);
    });
}

/// Short items that are called for together.
const RUN: usize = 1 << 10;

/// As [`map`], in runs: for items that take less time than a call through a pointer.
pub(crate) fn map_in_runs<T: Copy + Default + Send>(count: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut items = vec![T::default(); count];
    chunks_mut(&mut items, RUN, |run, items| {
        for (i, item) in (run * RUN..).zip(items) {
            *item = of(i);
        }
    });
    items
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_loop_keeps_the_order_of_its_items() {
        let numbers: Vec<usize> = (0..10_000).collect();
        assert_eq!(map(10_000, |i| i), numbers);
        assert_eq!(map_in_runs(10_000, |i| i), numbers);
        assert_eq!(map_each(&numbers, |i| i + 1), (1..10_001).collect::<Vec<_>>());
        assert_eq!(flat_map(10_000, |i| [i, i]), numbers.iter().flat_map(|&i| [i, i]).collect::<Vec<_>>());
        assert_eq!(filter(10_000, |i| i % 3 == 0), (0..10_000).step_by(3).collect::<Vec<u32>>());
        let mut squares = vec![0; 10_000];
        each_mut(&mut squares, |i, square| *square = i * i);
        let mut in_runs = vec![0; 10_000];
        each_mut_in_runs(&mut in_runs, |i, square| *square = i * i);
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
    fn the_first_error_is_told() {
        assert_eq!(try_map(1000, |i| if i % 400 == 399 { Err(i) } else { Ok(i) }), Err(399));
        assert_eq!(try_map(3, Ok::<_, ()>), Ok(vec![0, 1, 2]));
    }
}
