//! Take-and-place: random positions one grain at a time, largest first (Sec. 2.2).
//!
//! Batches of grains look for their first free position in parallel, against the grains placed so far; then they are
//! committed in order, and one that meets a batch mate goes on with its own random stream. A position that was refused
//! stays refused when more is placed, so the outcome is the sequential one, bit for bit, for any number of threads.

mod nearby;
mod scene;

use super::task::Task;
use super::{Placed, StopReason};
use meso_collision::gjk::{self, Counters};
use meso_collision::math::{Aabb, Vec3};
use meso_collision::simd::{Wide, widest};
use meso_concrete::aggregate::grain::snap;
use meso_concrete::aggregate::random::{Draw, Stream};
use meso_concrete::parallel;
use meso_concrete::specimen::Period;
use scene::{Candidate, Look, Looking, Scene, Scratch};

/// Grains that search at the same time. A constant, so that the counters do not depend on the threads.
const BATCH: usize = 32;

/// Tries up to `attempts` positions for every grain of `task`, in its order; a grain without a free position is left
/// out.
pub(super) fn place(task: &Task, attempts: u32) -> Placed {
    let mut outcome = Placed::empty(task, "take-and-place", StopReason::AttemptsExhausted);
    // After a stop during the take the caller places the grains that exist.
    if outcome.stop.is_some() {
        return outcome;
    }
    // Not needed before the end.
    outcome.poses = Vec::new();
    let mut scene = Scene::new(task);
    let some_body = || gjk::Body::new(&[Vec3::zeros()]);
    let mut other = some_body();
    let grains = task.request.grains.len();
    for first in (0..grains).step_by(BATCH) {
        let mut scouted = parallel::map_with(BATCH.min(grains - first), some_body, |other, mate| {
            let mut search = Search::new(task, first + mate, attempts);
            search.run(&scene, other);
            search
        });
        let first_mate = scene.len();
        for search in &mut scouted {
            commit(&mut scene, search, first_mate, &mut other, &mut outcome);
        }
        if let Some(reason) = task.stopped(scene.volume()) {
            outcome.stop = Some(reason);
            break;
        }
    }
    outcome.poses = scene.into_poses();
    outcome
}

fn commit(scene: &mut Scene, search: &mut Search, first_mate: usize, other: &mut gjk::Body, outcome: &mut Placed) {
    if scene.class_is_full(search.candidate.grain) {
        return;
    }
    let work = &mut Scratch { counters: &mut search.counters, other };
    let meets_mates = |centre: Vec3| !scene.free_of_mates(&search.candidate, &centre, first_mate, work);
    if search.found.is_some_and(meets_mates) {
        search.run(scene, other);
    }
    outcome.work.candidates += search.candidates;
    outcome.work.add(&search.counters);
    if let Some(centre) = search.found {
        scene.insert(search.number, &search.candidate, centre);
    }
}

/// Positions of a grain tested together, so that their cache misses overlap.
const AHEAD: usize = 16;

/// Positions of a grain after which its search asks whether to stop. At 0.05 to 1 us each these are at most 4 ms; a
/// search of fewer positions never asks, and leaves that to the batch.
const UNASKED: u32 = 1 << 12;

/// The next positions, with the prefilter's result for each. The first `left` remain; the last of them is next.
struct Ahead {
    centres: [Vec3; AHEAD],
    looks: [Look; AHEAD],
    left: usize,
}

/// The search of one grain for a free position; it can be resumed.
struct Search<'a> {
    number: usize,
    candidate: Candidate<'a>,
    stream: Stream,
    attempts_left: u32,
    ahead: Ahead,
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
            stream: Stream::new(task.request.target.seed, Draw::Place, grain.class, u64::from(grain.index)),
            attempts_left: if task.admits(grain) { attempts } else { 0 },
            ahead: Ahead { centres: [Vec3::zeros(); AHEAD], looks: [Look::Clear; AHEAD], left: 0 },
            found: None,
            candidates: 0,
            counters: Counters::default(),
        }
    }

    /// Goes on to the next free position.
    fn run(&mut self, scene: &Scene, other: &mut gjk::Body) {
        self.found = None;
        while self.found.is_none() {
            if self.ahead.left == 0 && !self.look_ahead(scene) {
                return;
            }
            self.ahead.left -= 1;
            self.candidates += 1;
            let (centre, look) = (self.ahead.centres[self.ahead.left], self.ahead.looks[self.ahead.left]);
            let work = &mut Scratch { counters: &mut self.counters, other };
            self.found = scene.free(&self.candidate, &centre, look, work).then_some(centre);
        }
    }

    /// Draws the next positions and looks at them; false where no attempts are left, or the run is to stop.
    fn look_ahead(&mut self, scene: &Scene) -> bool {
        let is_asked = self.attempts_left >= UNASKED && self.attempts_left % UNASKED < AHEAD as u32;
        if is_asked && scene.task.over().is_some() {
            return false;
        }
        let (task, count) = (scene.task, self.attempts_left.min(AHEAD as u32) as usize);
        self.attempts_left -= count as u32;
        let mut shares = [[0.0; 3]; AHEAD];
        for share in shares[..count].iter_mut().rev() {
            *share = [self.stream.unit(), self.stream.unit(), self.stream.unit()];
        }
        let Ahead { centres, looks, left } = &mut self.ahead;
        *centres = widest(Centres { shares, reach: task.reach(&self.candidate.aabb), period: &task.period });
        widest(Looking { scene, it: &self.candidate, centres, looks: &mut looks[..count] });
        *left = count;
        count > 0
    }
}

/// The lattice points nearest to these shares of the reach, rounded in vector registers.
struct Centres<'a> {
    shares: [[f64; 3]; AHEAD],
    reach: Aabb,
    period: &'a Period,
}

impl Wide for Centres<'_> {
    type Output = [Vec3; AHEAD];

    #[inline(always)]
    fn run(self) -> [Vec3; AHEAD] {
        let (low, size) = (self.reach.min, self.reach.max - self.reach.min);
        let mut centres = [Vec3::zeros(); AHEAD];
        for (centre, [x, y, z]) in centres.iter_mut().zip(&self.shares) {
            *centre = snap(&Vec3::new(low.x + size.x * x, low.y + size.y * y, low.z + size.z * z));
        }
        if !self.period.is_none() {
            for centre in &mut centres {
                *centre = self.period.wrap(centre);
            }
        }
        centres
    }
}
