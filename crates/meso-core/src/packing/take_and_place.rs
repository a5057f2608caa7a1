//! Take-and-place: random positions one grain at a time, largest first (Sec. 2.2).
//!
//! Batches of grains look for their first free position in parallel, against what is placed so far; then they are
//! committed in order, and one that meets a batch mate goes on with its own random stream. A position that was refused
//! stays refused when more is placed, so the outcome is the sequential one, bit for bit, for any number of threads.

use super::grid::Grid;
use super::place::Task;
use super::{Outcome, Pose, StopReason, Work};
use crate::aggregate::random::{Purpose, Stream};
use crate::aggregate::take::{Grain, snap};
use crate::gjk::{self, Counters};
use crate::math::{Aabb, Vec3};
use rayon::prelude::*;

/// Grains that search at the same time. A constant, so that the counters do not depend on the threads.
const BATCH: usize = 64;

/// Tries up to `attempts` positions for every grain of `task`, in its order; what finds none is left out.
pub(super) fn place(task: &Task, attempts: u32) -> Outcome {
    let mut scene = Scene::new(task);
    let mut outcome = Outcome {
        poses: vec![None; task.request.grains.len()],
        work: Work::default(),
        stop: None,
        dead_end: StopReason::AttemptsExhausted,
        strategy: "take-and-place",
        itz_limited: Vec::new(),
        largest_mm3: Vec::new(),
    };
    // A stop during the take has left grains out; nothing placed of them would be what was asked.
    outcome.stop = task.stopped(0.0);
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
        let first_mate = scene.placed.len();
        for mut search in scouted {
            commit(&mut scene, &mut search, first_mate, &mut outcome);
        }
        if let Some(reason) = task.stopped(scene.class_volume.iter().sum()) {
            outcome.stop = Some(reason);
            break;
        }
    }
    outcome
}

fn commit(scene: &mut Scene, search: &mut Search, first_mate: usize, outcome: &mut Outcome) {
    if scene.class_is_full(search.grain) {
        return;
    }
    if search.found.is_some_and(|centre| !scene.free_of_mates(search.grain, &centre, first_mate, &mut search.counters))
    {
        search.run(scene);
    }
    outcome.work.candidates += search.candidates;
    outcome.work.add(&search.counters);
    if let Some(centre) = search.found {
        outcome.poses[search.grain] = Some(Pose::at(centre));
        scene.insert(search.grain, centre);
    }
}

/// The search of one grain for a free position; it can be resumed.
struct Search {
    grain: usize,
    stream: Stream,
    attempts_left: u32,
    found: Option<Vec3>,
    candidates: u64,
    counters: Counters,
}

impl Search {
    fn new(task: &Task, grain: usize, attempts: u32) -> Self {
        let Grain { class, index, .. } = task.request.grains[grain];
        let stream = Stream::new(task.request.seed, Purpose::Place, class, u64::from(index));
        Self { grain, stream, attempts_left: attempts, found: None, candidates: 0, counters: Counters::default() }
    }

    /// Goes on to the next free position.
    fn run(&mut self, scene: &Scene) {
        self.found = None;
        let grain = &scene.task.request.grains[self.grain];
        let aabb = grain.body.aabb();
        let reach = scene.task.reach(&aabb);
        while self.attempts_left > 0 && self.found.is_none() {
            self.attempts_left -= 1;
            self.candidates += 1;
            let centre = scene.task.period.wrap(&snap(&self.stream.point(&reach.min, &reach.max)));
            if scene.free(self.grain, &aabb, &centre, &mut self.counters) {
                self.found = Some(centre);
            }
        }
    }
}

/// What is placed so far.
struct Scene<'a> {
    task: &'a Task<'a>,
    /// Grain and centre of every placed body, and of its images that a grain in the box may meet.
    placed: Vec<(u32, Vec3)>,
    /// What a grain with its centre in the specimen's box may reach.
    domain: Aabb,
    grid: Grid,
    /// The grains in the form collision works on.
    bodies: Vec<gjk::Body>,
    /// Volume placed of every class, mm3.
    class_volume: Vec<f64>,
}

impl<'a> Scene<'a> {
    fn new(task: &'a Task<'a>) -> Self {
        let middle =
            task.request.grains.get(task.request.grains.len() / 2).map_or(1.0, |grain| 2.0 * grain.outer_radius);
        let domain = task.domain();
        Self {
            task,
            placed: Vec::new(),
            grid: Grid::new(&domain, middle),
            domain,
            bodies: task.request.grains.par_iter().map(collider).collect(),
            class_volume: vec![0.0; task.class_targets.len()],
        }
    }

    fn insert(&mut self, grain: usize, centre: Vec3) {
        let body = &self.task.request.grains[grain];
        let local = body.body.aabb();
        let aabb = Aabb { min: local.min + centre, max: local.max + centre };
        for shift in self.task.period.shifts(&aabb, &self.domain) {
            self.grid.insert(&Aabb { min: aabb.min + shift, max: aabb.max + shift });
            self.placed.push((grain as u32, centre + shift));
        }
        self.class_volume[usize::from(body.class)] += body.volume;
    }

    /// True when the class of `grain` comes no nearer to its target with it.
    fn class_is_full(&self, grain: usize) -> bool {
        let Grain { class, volume, .. } = self.task.request.grains[grain];
        let class = usize::from(class);
        self.class_volume[class] + volume / 2.0 >= self.task.class_targets[class]
    }

    /// True when the grain at `centre` is proved apart from everything placed, and inside the specimen.
    fn free(&self, grain: usize, local: &Aabb, centre: &Vec3, counters: &mut Counters) -> bool {
        let body = &self.task.request.grains[grain];
        let clearly_hit = self.grid.at(centre).any(|other| {
            let (other, other_centre) = self.placed[other as usize];
            let reach = body.inner_radius + self.task.request.grains[other as usize].inner_radius;
            (other_centre - centre).norm_squared() < reach * reach
        });
        if clearly_hit || !self.task.room.holds(body.body.vertices(), centre, self.task.request.placement.wall_gap_mm) {
            return false;
        }
        let gap = Vec3::repeat(self.task.request.placement.min_gap_mm);
        let aabb = Aabb { min: local.min + centre - gap, max: local.max + centre + gap };
        self.grid.all_near(&aabb, |other| self.apart(grain, centre, other as usize, counters))
    }

    /// The same against the bodies placed from `first_mate` on.
    fn free_of_mates(&self, grain: usize, centre: &Vec3, first_mate: usize, counters: &mut Counters) -> bool {
        (first_mate..self.placed.len()).all(|other| self.apart(grain, centre, other, counters))
    }

    fn apart(&self, grain: usize, centre: &Vec3, placed: usize, counters: &mut Counters) -> bool {
        let (other, other_centre) = self.placed[placed];
        let (body, other) = (&self.bodies[grain], &self.bodies[other as usize]);
        let gap = self.task.request.placement.min_gap_mm;
        gjk::apart_counted(body, other, &(other_centre - centre), gap, None, counters).is_some()
    }
}

/// The grain in the form collision works on, with all that lets pairs be told apart early.
fn collider(grain: &Grain) -> gjk::Body {
    gjk::Body::on_ellipsoid(grain.body.vertices(), &grain.semi_axes, &grain.rotation).with_inside_of(&grain.body)
}
