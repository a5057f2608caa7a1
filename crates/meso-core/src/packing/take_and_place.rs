//! Take-and-place: random positions one grain at a time, largest first (Sec. 2.2).
//!
//! Batches of grains look for their first free position in parallel, against what is placed so far; then they are
//! committed in order, and one that meets a batch mate goes on with its own random stream. A position that was refused
//! stays refused when more is placed, so the outcome is the sequential one, bit for bit, for any number of threads.

mod mask;
mod scene;

use super::place::Task;
use super::{Outcome, Pose, StopReason};
use crate::aggregate::random::{Purpose, Stream};
use crate::aggregate::take::snap;
use crate::gjk::Counters;
use crate::math::Vec3;
use rayon::prelude::*;
use scene::{Candidate, Scene, Trial};

/// Grains that search at the same time. A constant, so that the counters do not depend on the threads.
const BATCH: usize = 64;

/// Tries up to `attempts` positions for every grain of `task`, in its order; what finds none is left out.
pub(super) fn place(task: &Task, attempts: u32) -> Outcome {
    let mut scene = Scene::new(task);
    let mut outcome = Outcome::empty(task, "take-and-place", StopReason::AttemptsExhausted);
    // A stop during the take has left grains out; nothing placed of them would be what was asked.
    if outcome.stop.is_some() {
        return outcome;
    }
    let order: Vec<usize> = (0..task.request.grains.len()).collect();
    for batch in order.chunks(BATCH) {
        let scouted: Vec<Search> = batch
            .par_iter()
            .map(|&grain| {
                let mut search = Search::new(task, grain, attempts);
                search.run(&scene);
                search
            })
            .collect();
        let first_mate = scene.len();
        for search in scouted {
            commit(&mut scene, search, first_mate, &mut outcome);
        }
        if let Some(reason) = task.stopped(scene.volume()) {
            outcome.stop = Some(reason);
            break;
        }
    }
    outcome
}

fn commit(scene: &mut Scene, mut search: Search, first_mate: usize, outcome: &mut Outcome) {
    if scene.class_is_full(search.candidate.grain) {
        return;
    }
    let Search { candidate, found, counters, .. } = &mut search;
    if found.is_some_and(|centre| !scene.free_of_mates(candidate, &centre, first_mate, counters)) {
        search.run(scene);
    }
    outcome.work.candidates += search.candidates;
    outcome.work.add(&search.counters);
    if let Some(centre) = search.found {
        outcome.poses[search.number] = Some(Pose::at(centre));
        scene.insert(search.number, search.candidate, centre);
    }
}

/// Positions of a grain that are looked at together: what each reads lies anywhere in memory, and is waited for together.
const AHEAD: usize = 16;

/// The search of one grain for a free position; it can be resumed.
struct Search<'a> {
    number: usize,
    candidate: Candidate<'a>,
    stream: Stream,
    attempts_left: u32,
    /// Attempts begun, the last first.
    ahead: Vec<Trial>,
    found: Option<Vec3>,
    candidates: u64,
    counters: Counters,
}

impl<'a> Search<'a> {
    fn new(task: &Task<'a>, number: usize, attempts: u32) -> Self {
        let grain = &task.request.grains[number];
        Self {
            number,
            candidate: Candidate::new(grain),
            stream: Stream::new(task.request.seed, Purpose::Place, grain.class, u64::from(grain.index)),
            attempts_left: attempts,
            ahead: Vec::with_capacity(AHEAD),
            found: None,
            candidates: 0,
            counters: Counters::default(),
        }
    }

    /// Goes on to the next free position.
    fn run(&mut self, scene: &Scene) {
        self.found = None;
        while self.found.is_none() {
            if self.ahead.is_empty() && self.attempts_left > 0 {
                self.look_ahead(scene);
            }
            let Some(trial) = self.ahead.pop() else { return };
            self.candidates += 1;
            self.found = scene.free(&self.candidate, &trial, &mut self.counters).then_some(trial.centre);
        }
    }

    fn look_ahead(&mut self, scene: &Scene) {
        let (reach, count) = (scene.task.reach(&self.candidate.aabb), self.attempts_left.min(AHEAD as u32));
        self.attempts_left -= count;
        for _ in 0..count {
            let centre = scene.task.period.wrap(&snap(&self.stream.point(&reach.min, &reach.max)));
            self.ahead.push(Trial::new(centre));
        }
        scene.look(&self.candidate, &mut self.ahead);
        self.ahead.reverse();
    }
}
