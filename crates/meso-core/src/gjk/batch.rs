//! Many questions at once: eight pairs in lockstep through the same stages as a single one.
//!
//! Packing asks in bulk: one candidate against its neighbours, or many candidate positions of one body against theirs.
//! The answers are those of [`overlap`](super::overlap), in any order and on any machine: both are exact.

use super::body::Body;
use super::ellipsoid::Known;
use super::pair::{Counters, Query, Stage};
use super::simd::{Open, glance_in_lockstep, search_in_lockstep};
use crate::math::Vec3;
use std::cell::RefCell;
use std::ops::Range;

/// Do A and B share a point, with B displaced by `b_from_a` (mm)?
#[derive(Clone, Copy, Debug)]
pub struct Ask<'a> {
    /// The first body.
    pub a: &'a Body,
    /// The second body.
    pub b: &'a Body,
    /// What to add to B's points to have them in A's frame, mm.
    pub b_from_a: Vec3,
}

impl<'a> Ask<'a> {
    fn query(&self, gap: f64) -> Query<'a> {
        Query { a: self.a, b: self.b, x: self.b_from_a, gap }
    }

    /// Distance of the centres for the bodies' size, squared.
    fn closeness(&self) -> f64 {
        let reach = self.a.circumradius() + self.b.circumradius();
        self.b_from_a.norm_squared() / (reach * reach)
    }
}

/// [`overlap`](super::overlap) for each of many pairs, in their order.
///
/// ```
/// use meso_core::{gjk::{Ask, Body, overlap_many}, math::Vec3};
/// let body = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
/// let ask = |x: f64| Ask { a: &body, b: &body, b_from_a: Vec3::new(x, 0.0, 0.0) };
/// assert_eq!(overlap_many(&[ask(1.0), ask(2.0), ask(3.0)]), [true, true, false]);
/// ```
pub fn overlap_many(asks: &[Ask<'_>]) -> Vec<bool> {
    with_work(|work| {
        work.glance(asks, 0.0);
        work.chosen.extend(0..work.open.len() as u32);
        work.search(asks, 0.0);
        work.answers.iter().map(|&answer| answer == Some(true)).collect()
    })
}

/// Which of many attempts are clear: attempt i asks `asks[ends[i - 1]..ends[i]]`, and is clear if all of these are more
/// than `gap` (mm, at least 0) apart.
///
/// Headers first, for all; then, attempt by attempt, the pair that seems closest; then what is left. Most attempts of a
/// dense packing fail, most of them without a look at a vertex.
///
/// ```
/// use meso_core::{gjk::{Ask, Body, clear_many}, math::Vec3};
/// let body = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
/// let ask = |x: f64| Ask { a: &body, b: &body, b_from_a: Vec3::new(x, 0.0, 0.0) };
/// // Two places for one body: at the first it has one neighbour, at the second two, of which one is 0.5 mm away.
/// assert_eq!(clear_many(&[ask(4.0), ask(4.0), ask(2.5)], &[1, 3], 0.6), [true, false]);
/// ```
///
/// # Panics
/// When `ends` does not ascend to the number of `asks`.
pub fn clear_many(asks: &[Ask<'_>], ends: &[u32], gap: f64) -> Vec<bool> {
    clear_many_counted(asks, ends, gap, &mut Counters::default())
}

/// [`clear_many`], counting what it took.
///
/// Every question counts as a pair; those that were not needed, after all, count as not put to GJK.
///
/// # Panics
/// As [`clear_many`].
pub fn clear_many_counted(asks: &[Ask<'_>], ends: &[u32], gap: f64, counters: &mut Counters) -> Vec<bool> {
    assert_eq!(ends.last().map_or(0, |&end| end as usize), asks.len(), "the attempts must cover the questions");
    with_work(|work| {
        work.glance(asks, gap);
        work.choose_closest(ends);
        work.search(asks, gap);
        work.choose_rest();
        work.search(asks, gap);
        counters.add(&work.counters);
        // All that is open still belongs to an attempt that has failed.
        let clear = |attempt: Range<usize>| !any(&work.answers[attempt], |answer| answer != Some(false));
        attempts(ends).map(clear).collect()
    })
}

fn attempts(ends: &[u32]) -> impl Iterator<Item = Range<usize>> + '_ {
    (0..ends.len()).map(|i| if i == 0 { 0 } else { ends[i - 1] as usize }..ends[i] as usize)
}

/// Runs with the memory that each thread keeps from one batch to the next: fresh memory would cost a sixth of the time.
fn with_work<R>(run: impl FnOnce(&mut Work) -> R) -> R {
    thread_local! {
        static WORK: RefCell<Work> = RefCell::default();
    }
    WORK.with_borrow_mut(run)
}

/// Questions on their way through the stages.
#[derive(Default)]
struct Work {
    /// `Some(true)`: not more than the gap apart.
    answers: Vec<Option<bool>>,
    open: Open,
    /// Entries of `open` to search next.
    chosen: Vec<u32>,
    /// The attempts of which the closest pair was searched: their entries of `open`.
    begun: Vec<Range<u32>>,
    counters: Counters,
}

impl Work {
    fn glance(&mut self, asks: &[Ask<'_>], gap: f64) {
        self.answers.clear();
        self.answers.resize(asks.len(), None);
        self.open.clear();
        let by_spheres = glance_in_lockstep(asks, gap, &mut self.answers, &mut self.open);
        let by_spheres = by_spheres.unwrap_or_else(|| self.glance_at_each(asks, gap));
        let (pairs, open) = (asks.len() as u64, self.open.len() as u64);
        self.counters =
            Counters { pairs, after_spheres: pairs - by_spheres, after_ellipsoids: open, ..Counters::default() };
    }

    /// One by one, where there is no lockstep; returns how many pairs the spheres decided.
    fn glance_at_each(&mut self, asks: &[Ask<'_>], gap: f64) -> u64 {
        let mut by_spheres = 0;
        for (i, ask) in asks.iter().enumerate() {
            let (stage, known) = ask.query(gap).glance();
            by_spheres += u64::from(stage == Stage::Spheres);
            match known {
                Known::Apart(_) => self.answers[i] = Some(false),
                Known::Overlap => self.answers[i] = Some(true),
                Known::Nothing(v) => self.open.push(i as u32, &v, ask.closeness()),
            }
        }
        by_spheres
    }

    /// Answers the chosen questions.
    fn search(&mut self, asks: &[Ask<'_>], gap: f64) {
        self.counters.gjk_calls += self.chosen.len() as u64;
        search_in_lockstep(asks, gap, &self.open, &self.chosen, &mut self.answers);
        for entry in self.chosen.drain(..) {
            let i = self.open.asks()[entry as usize] as usize;
            if self.answers[i].is_none() {
                let v = self.open.direction(entry as usize);
                self.answers[i] = Some(!asks[i].query(gap).settle(&v, &mut self.counters));
            }
        }
    }

    /// The closest open question of every attempt that has not failed.
    fn choose_closest(&mut self, ends: &[u32]) {
        self.begun.clear();
        let (open, mut at) = (&self.open, 0);
        for attempt in attempts(ends) {
            let (start, mut closest) = (at, at);
            while at < open.len() && (open.asks()[at] as usize) < attempt.end {
                closest = if open.closeness(at) < open.closeness(closest) { at } else { closest };
                at += 1;
            }
            if at > start && !any(&self.answers[attempt], |answer| answer == Some(true)) {
                self.chosen.push(closest as u32);
                self.begun.push(start as u32..at as u32);
            }
        }
    }

    /// Every question that is open still, of every attempt that has not failed since.
    fn choose_rest(&mut self) {
        let answer = |entry: u32| self.answers[self.open.asks()[entry as usize] as usize];
        for entries in &self.begun {
            if !entries.clone().any(|entry| answer(entry) == Some(true)) {
                self.chosen.extend(entries.clone().filter(|&entry| answer(entry).is_none()));
            }
        }
    }
}

/// Without a branch for each: nobody could foretell them.
#[inline(always)]
fn any(answers: &[Option<bool>], is_so: impl Fn(Option<bool>) -> bool) -> bool {
    answers.iter().fold(false, |any, &answer| any | is_so(answer))
}

#[cfg(test)]
mod tests {
    use super::{Ask, Work};
    use crate::geometry::convex_hull;
    use crate::gjk::Body;
    use crate::math::Vec3;

    #[test]
    fn without_lockstep_the_stages_are_the_same() {
        let corners = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()];
        let body = Body::new(&corners).with_inside_of(convex_hull(&corners).expect("solid").facets());
        let at = |i: u32| Vec3::new(0.11 * f64::from(i), 0.07 * f64::from(i % 5), 0.05 * f64::from(i % 3));
        let asks: Vec<Ask<'_>> = (0..30).map(|i| Ask { a: &body, b: &body, b_from_a: at(i) }).collect();
        let (mut wide, mut plain) = (Work::default(), Work::default());
        wide.glance(&asks, 0.1);
        plain.answers.resize(asks.len(), None);
        plain.glance_at_each(&asks, 0.1);
        assert_eq!((&wide.answers, wide.open.asks()), (&plain.answers, plain.open.asks()));
        assert!((1..29).contains(&plain.open.len()), "{} open", plain.open.len());
        for work in [&mut wide, &mut plain] {
            work.chosen.extend(0..work.open.len() as u32);
            work.search(&asks, 0.1);
        }
        assert_eq!(wide.answers, plain.answers);
    }
}
