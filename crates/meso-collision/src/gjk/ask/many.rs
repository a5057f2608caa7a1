//! Many questions at once: pairs in lockstep through the same stages as a single one.
//!
//! The answers are those of [`Body::overlaps`](crate::gjk::Body::overlaps), in any order and on any machine: both are
//! exact. Where lockstep does not pay, on the instruction set or with few pairs, they are asked one by one.

use crate::gjk::ask::attempts::Attempts;
use crate::gjk::ask::pair_query::PairQuery;
use crate::gjk::search::lockstep::{Glance, Notes, Pending, Search, Undecided};
use crate::gjk::search::mpr::Portal;
use crate::simd::{Simd, Vectorized, dispatch};
use std::cell::RefCell;

/// Pairs below which they are asked one by one: less than a register's lanes, twice.
const FEW: usize = 8;

/// Pairs below which a search in lockstep leaves too many lanes idle: they are searched one by one.
const FEW_TO_SEARCH: usize = 12;

impl PairQuery<'_> {
    /// [`Body::overlaps`](crate::gjk::Body::overlaps) for each of many pairs, in their order.
    ///
    /// ```
    /// use meso_collision::{gjk::{Body, PairQuery}, math::Vec3};
    /// let body = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
    /// let query = |x: f64| PairQuery { a: &body, b: &body, b_from_a: Vec3::new(x, 0.0, 0.0) };
    /// assert_eq!(PairQuery::overlap_many(&[query(1.0), query(2.0), query(3.0)]), [true, true, false]);
    /// ```
    pub fn overlap_many(queries: &[Self]) -> Vec<bool> {
        overlap_settled(queries, &Own { queries, gap: 0.0 })
    }

    /// Which of many attempts are clear: attempt i asks `queries[ends[i - 1]..ends[i]]`, and is clear if all of these
    /// are more than `gap` (mm, at least 0) apart.
    ///
    /// Bounds first, for all; then, attempt by attempt, the pair that seems closest; then all others. Most attempts of
    /// a dense packing fail, most of them without a look at a vertex.
    ///
    /// ```
    /// use meso_collision::{gjk::{Body, PairQuery}, math::Vec3};
    /// let body = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
    /// let query = |x: f64| PairQuery { a: &body, b: &body, b_from_a: Vec3::new(x, 0.0, 0.0) };
    /// // Two positions of one body: at the first it has one neighbour, at the second two, of which one is 0.5 mm away.
    /// assert_eq!(PairQuery::clear_many(&[query(4.0), query(4.0), query(2.5)], &[1, 3], 0.6), [true, false]);
    /// ```
    ///
    /// # Panics
    /// When `ends` does not ascend to the number of `queries`.
    pub fn clear_many(queries: &[Self], ends: &[u32], gap: f64) -> Vec<bool> {
        clear_settled(queries, ends, gap, &Own { queries, gap })
    }
}

/// [`PairQuery::overlap_many`] where `open` answers pairs that bounds and lockstep leave open.
pub(crate) fn overlap_settled(queries: &[PairQuery<'_>], open: &dyn Settle) -> Vec<bool> {
    if queries.len() < FEW || !dispatch(Pays) {
        return (0..queries.len()).map(|i| !is_apart(queries, i, 0.0, open)).collect();
    }
    with_work(|work| {
        work.glance(queries, 0.0);
        work.chosen.extend(0..work.pending.len() as u32);
        work.search(queries, 0.0, open);
        work.answers.iter().map(|&answer| answer == Some(true)).collect()
    })
}

/// One question after the other.
fn is_apart(queries: &[PairQuery<'_>], i: usize, gap: f64, open: &dyn Settle) -> bool {
    queries[i].query(gap).apart_or(|portal| open.is_farther(i, portal))
}

/// Answers a question that searches in floating point left open.
pub(crate) trait Settle {
    /// Whether the pair of the `query`th question is more than the gap apart; the search may have come to a portal.
    fn is_farther(&self, query: usize, portal: Option<Portal>) -> bool;
}

/// From the bodies themselves.
struct Own<'a, 'q> {
    queries: &'a [PairQuery<'q>],
    gap: f64,
}

impl Settle for Own<'_, '_> {
    fn is_farther(&self, query: usize, portal: Option<Portal>) -> bool {
        self.queries[query].query(self.gap).settle_again(portal)
    }
}

/// True on instruction sets where many pairs in lockstep take less than two thirds of the time of one after the other.
struct Pays;

impl Vectorized for Pays {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, _: S) -> bool {
        S::LOCKSTEP_PAYS
    }
}

/// [`PairQuery::clear_many`] where `open` answers pairs that bounds and lockstep leave open.
pub(crate) fn clear_settled(queries: &[PairQuery<'_>], ends: &[u32], gap: f64, open: &dyn Settle) -> Vec<bool> {
    assert_eq!(ends.last().map_or(0, |&end| end as usize), queries.len(), "the attempts must cover the questions");
    assert!(ends.is_sorted(), "the ends of the attempts must ascend");
    if !dispatch(Pays) {
        let attempts = (0..ends.len()).map(|i| if i == 0 { 0 } else { ends[i - 1] as usize }..ends[i] as usize);
        return attempts.map(|mut attempt| attempt.all(|i| is_apart(queries, i, gap, open))).collect();
    }
    with_work(|work| {
        work.glance(queries, gap);
        let mut clear = work.attempts.begin(ends, &work.answers);
        work.attempts.choose_closest(&work.pending, &mut work.chosen);
        work.search(queries, gap, open);
        work.attempts.choose_rest(&work.pending, &work.answers, &mut work.chosen, &mut clear);
        work.search(queries, gap, open);
        work.attempts.end(&work.pending, &work.answers, &mut clear);
        clear
    })
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
    pending: Pending,
    /// Entries of `pending` to search next.
    chosen: Vec<u32>,
    notes: Notes,
    undecided: Vec<Undecided>,
    attempts: Attempts,
}

impl Work {
    fn glance(&mut self, queries: &[PairQuery<'_>], gap: f64) {
        self.answers.clear();
        self.answers.resize(queries.len(), None);
        self.pending.clear();
        dispatch(Glance { queries, gap, answers: &mut self.answers, pending: &mut self.pending });
    }

    /// Answers the chosen questions.
    fn search(&mut self, queries: &[PairQuery<'_>], gap: f64, open: &dyn Settle) {
        let Self { answers, pending, chosen, notes, undecided, .. } = self;
        if chosen.len() < FEW_TO_SEARCH {
            for entry in chosen.drain(..) {
                let (i, v) = (pending.query(entry) as usize, pending.direction(entry));
                let apart = queries[i].query(gap).apart_from(&v, |portal| open.is_farther(i, portal));
                answers[i] = Some(!apart);
            }
            return;
        }
        dispatch(Search { queries, gap, pending, chosen, notes, answers, undecided });
        chosen.clear();
        for Undecided { query, portal } in undecided.drain(..) {
            answers[query as usize] = Some(!open.is_farther(query as usize, portal));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex_hull;
    use crate::gjk::body::Body;
    use crate::gjk::method::Algorithm;
    use crate::math::Vec3;
    use crate::random::Stream;
    use crate::simd::{Isa, dispatch_on};

    /// A solid of 24 points near a sphere, which is known to hold its frame's origin.
    fn body(stream: &mut Stream) -> Body {
        let points: Vec<Vec3> = (0..24).map(|_| stream.direction() * stream.uniform(2.0, 4.0)).collect();
        Body::new(&points).with_inside_of(&convex_hull(&points).unwrap())
    }

    /// Pairs at 1e-9 to 1e-5 of their size from touching, on either side.
    fn near_touch<'a>(stream: &mut Stream, bodies: &'a [Body], n: usize) -> Vec<PairQuery<'a>> {
        let mut one = |i: usize| {
            let (a, b) = (&bodies[i % bodies.len()], &bodies[(7 * i + 1) % bodies.len()]);
            let v = stream.direction();
            let (mut inside, mut outside) = (0.0, a.circumradius() + b.circumradius());
            for _ in 0..60 {
                let middle = 0.5 * (inside + outside);
                *(if a.overlaps(b, &(v * middle)) { &mut inside } else { &mut outside }) = middle;
            }
            let off = libm::exp10(stream.uniform(-9.0, -5.0)) * if i.is_multiple_of(2) { 1.0 } else { -1.0 };
            PairQuery { a, b, b_from_a: v * (inside * (1.0 + off)) }
        };
        (0..n).map(&mut one).collect()
    }

    #[test]
    fn lockstep_itself_proves_nearly_all_pairs_that_single_precision_cannot() {
        let mut stream = Stream::new(3);
        let bodies: Vec<Body> = (0..40).map(|_| body(&mut stream)).collect();
        let queries = near_touch(&mut stream, &bodies, 1000);
        let exact: Vec<bool> = queries.iter().map(|q| Algorithm::Exact.overlap(q.a, q.b, &q.b_from_a)).collect();
        for isa in Isa::ALL.into_iter().filter(|&isa| dispatch_on(isa, Pays)) {
            let (answers, open) = in_lockstep(isa, &queries);
            let right = answers.iter().zip(&exact).filter(|(answer, exact)| **answer == Some(**exact)).count();
            assert_eq!(right + open, queries.len(), "{isa:?}");
            assert!(open < 20, "{isa:?} leaves {open} open");
        }
    }

    /// The answers of bounds and lockstep, and how many these leave open.
    fn in_lockstep(isa: Isa, queries: &[PairQuery<'_>]) -> (Vec<Option<bool>>, usize) {
        let Work { mut answers, mut pending, mut chosen, mut notes, mut undecided, .. } = Work::default();
        answers.resize(queries.len(), None);
        dispatch_on(isa, Glance { queries, gap: 0.0, answers: &mut answers, pending: &mut pending });
        chosen.extend(0..pending.len() as u32);
        let (pending, chosen, notes) = (&pending, &chosen, &mut notes);
        let search =
            Search { queries, gap: 0.0, pending, chosen, notes, answers: &mut answers, undecided: &mut undecided };
        dispatch_on(isa, search);
        (answers, undecided.len())
    }
}
