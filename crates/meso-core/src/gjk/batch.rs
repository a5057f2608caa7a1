//! Many questions at once: eight pairs in lockstep through the same stages as a single one.
//!
//! Packing asks in bulk: one candidate against its neighbours, or many candidate positions of one body against theirs.
//! The answers are those of [`overlap`](super::overlap), in any order and on any machine: both are exact.

use super::body::Body;
use super::pair::overlap;
use super::simd::{compare_in_lockstep, overlap_in_lockstep};
use crate::math::Vec3;

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

impl Ask<'_> {
    fn overlap(&self) -> bool {
        overlap(self.a, self.b, &self.b_from_a)
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
    let mut answers = vec![None; asks.len()];
    overlap_in_lockstep(asks, &mut answers);
    asks.iter().zip(answers).map(|(ask, answer)| answer.unwrap_or_else(|| ask.overlap())).collect()
}

/// Which of many attempts touch nothing: attempt i asks `asks[ends[i - 1]..ends[i]]`, and is clear if all are apart.
///
/// Headers first, for all; then, attempt by attempt, the pair that seems closest; then what is left. Most attempts of a
/// dense packing fail, most of them without a look at a vertex.
///
/// # Panics
/// When `ends` does not ascend to the number of `asks`.
pub fn clear_many(asks: &[Ask<'_>], ends: &[u32]) -> Vec<bool> {
    assert_eq!(ends.last().map_or(0, |&end| end as usize), asks.len(), "the attempts must cover the questions");
    let mut answers = vec![None; asks.len()];
    compare_in_lockstep(asks, &mut answers);
    settle(asks, ends, &mut answers, |attempt, answers, chosen| chosen.extend(closest_open(asks, attempt, answers)));
    settle(asks, ends, &mut answers, |attempt, answers, chosen| {
        chosen.extend(attempt.filter(|&i| answers[i].is_none()));
    });
    attempts(ends).map(|mut attempt| attempt.all(|i| answers[i] == Some(false))).collect()
}

fn attempts(ends: &[u32]) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
    (0..ends.len()).map(|i| if i == 0 { 0 } else { ends[i - 1] as usize }..ends[i] as usize)
}

/// Answers the open questions that `choose` adds to its list in attempts that have not failed yet.
fn settle(
    asks: &[Ask<'_>],
    ends: &[u32],
    answers: &mut [Option<bool>],
    choose: impl Fn(std::ops::Range<usize>, &[Option<bool>], &mut Vec<usize>),
) {
    let mut chosen = Vec::with_capacity(asks.len());
    for attempt in attempts(ends) {
        if !answers[attempt.clone()].contains(&Some(true)) {
            choose(attempt, answers, &mut chosen);
        }
    }
    let part: Vec<Ask<'_>> = chosen.iter().map(|&i| asks[i]).collect();
    for (i, answer) in chosen.into_iter().zip(overlap_many(&part)) {
        answers[i] = Some(answer);
    }
}

/// The open question of an attempt whose bodies are closest for their size.
fn closest_open(asks: &[Ask<'_>], mut attempt: std::ops::Range<usize>, answers: &[Option<bool>]) -> Option<usize> {
    let closeness = |i: usize| {
        let reach = asks[i].a.circumradius() + asks[i].b.circumradius();
        asks[i].b_from_a.norm_squared() / (reach * reach)
    };
    let mut best = None;
    for i in attempt.by_ref().filter(|&i| answers[i].is_none()) {
        let own = closeness(i);
        if best.is_none_or(|(_, least)| own < least) {
            best = Some((i, own));
        }
    }
    best.map(|(i, _)| i)
}
