//! What is placed so far, and whether a grain has room among it.

use crate::aggregate::take::Grain;
use crate::geometry::NarrowPolyhedron;
use crate::gjk::{self, Counters};
use crate::math::{Aabb, Vec3};
use crate::packing::Pose;
use crate::packing::grid::Grid;
use crate::packing::place::Task;
use std::hint::black_box;

/// Edge of the grid's cells, as a share of the middle grain's diameter: from 0.8 on all take the same time, and large ones less
/// memory.
const CELL: f64 = 1.25;

/// Inscribed balls share a point when their distance squared over that of their touching is below this, with room for what
/// single precision loses. In a specimen of many thousand grains across it would lose more: attempts, never a proof.
const MEETS: f32 = 0.99;

/// Stands for: no body.
const NONE: u32 = u32::MAX;

/// The placed bodies, and the indices that find those near a candidate.
pub(super) struct Scene<'a> {
    pub(super) task: &'a Task<'a>,
    /// Every placed grain, and its images that a grain in the box may meet.
    placed: Vec<Placed>,
    /// The number of the grain that each is. Apart, so that the memory of a grain and of where it lies are waited for
    /// together.
    numbers: Vec<u32>,
    /// Centre and radius of the ball that each holds, mm: what is read of many lies close together.
    balls: Vec<[f32; 4]>,
    /// What a grain with its centre in the specimen's box may reach.
    domain: Aabb,
    grid: Grid,
    /// Volume placed of every class, mm3.
    class_volume: Vec<f64>,
}

/// Where a grain lies, and what most attempts end with: its body, in the form collision works on, would be as large as all
/// else that is known of it, and is made where a pair needs it.
#[repr(align(64))]
struct Placed {
    centre: Vec3,
    bounds: gjk::Bounds,
}

/// A grain that looks for its place.
pub(super) struct Candidate<'a> {
    pub(super) grain: &'a Grain,
    vertices: Vec<Vec3>,
    /// In the form collision works on, with all that lets pairs be told apart early.
    solid: gjk::Solid,
    /// Its box about its centre.
    pub(super) aabb: Aabb,
}

/// A position that a candidate tries.
pub(super) struct Trial {
    pub(super) centre: Vec3,
    /// What a look told: the grid's cell, that the position is taken, or what is most likely in the way.
    cell: u32,
    taken: bool,
    closest: Option<u32>,
}

impl Trial {
    pub(super) fn new(centre: Vec3) -> Self {
        Self { centre, cell: 0, taken: false, closest: None }
    }
}

impl<'a> Candidate<'a> {
    pub(super) fn new(grain: &'a Grain) -> Self {
        let body = grain.body.widened();
        let solid = gjk::Solid::new(body.vertices(), &body.facets());
        Self { grain, solid, aabb: grain.body.aabb(), vertices: body.into_vertices() }
    }
}

impl<'a> Scene<'a> {
    pub(super) fn new(task: &'a Task<'a>) -> Self {
        let grains = task.request.grains;
        let middle = middle_size(grains);
        let domain = task.domain();
        Self {
            task,
            // Doubling would leave as much memory behind; of what is set aside only what is used counts.
            placed: Vec::with_capacity(grains.len()),
            numbers: Vec::with_capacity(grains.len()),
            balls: Vec::with_capacity(grains.len()),
            grid: Grid::new(&domain, CELL * middle).with_room_for(grains.len()),
            domain,
            class_volume: vec![0.0; task.class_targets.len()],
        }
    }

    /// Number of bodies placed, images included.
    pub(super) fn len(&self) -> usize {
        self.placed.len()
    }

    /// mm3 placed.
    pub(super) fn volume(&self) -> f64 {
        self.class_volume.iter().sum()
    }

    /// Places the candidate, which is the grain of this number, at `centre`.
    pub(super) fn insert(&mut self, number: usize, candidate: Candidate, centre: Vec3) {
        let Candidate { grain, solid, aabb: local, .. } = candidate;
        let aabb = local.moved(&centre);
        for shift in self.task.period.shifts(&aabb, &self.domain) {
            self.grid.insert(&aabb.moved(&shift));
            let centre = centre + shift;
            let [x, y, z] = <[f64; 3]>::from(centre).map(|x| x as f32);
            self.balls.push([x, y, z, grain.inner_radius]);
            self.numbers.push(number as u32);
            self.placed.push(Placed { centre, bounds: solid.body().bounds() });
        }
        self.class_volume[usize::from(grain.class)] += grain.volume();
    }

    /// The pose of every grain; what finds near ones is given back before the list is made.
    pub(super) fn into_poses(self) -> Vec<Option<Pose>> {
        let Self { task, placed, numbers, balls, grid, .. } = self;
        drop((balls, grid));
        let mut poses = vec![None; task.request.grains.len()];
        // Images have their centres outside of the box.
        let itself = |centre: &Vec3| task.period.wrap(centre) == *centre;
        for (number, body) in numbers.iter().zip(&placed).filter(|(_, body)| itself(&body.centre)) {
            poses[*number as usize] = Some(Pose::at(body.centre));
        }
        poses
    }

    /// True when the class of `grain` comes no nearer to its target with it.
    pub(super) fn class_is_full(&self, grain: &Grain) -> bool {
        let class = usize::from(grain.class);
        self.class_volume[class] + grain.volume() / 2.0 >= self.task.class_targets[class]
    }

    /// Looks at all of `trials` once for what ends most of them; what it says of one stays right when more is placed.
    pub(super) fn look(&self, it: &Candidate, trials: &mut [Trial]) {
        // What one look needs of memory is asked for before the first is waited for.
        for trial in &mut *trials {
            trial.cell = self.grid.cell(&trial.centre);
        }
        let first = |cell| self.grid.list(cell).next().map_or(0.0, |body| self.balls[body as usize][0]);
        black_box(trials.iter().map(|trial| first(trial.cell)).sum::<f32>());
        for trial in &mut *trials {
            self.look_around(it, trial);
        }
        // So what the proofs will read.
        let of = |other: u32| self.body(other as usize).coordinates().map(|along| along[0]).iter().sum::<f32>();
        let and = |other: u32| of(other) + self.placed[other as usize].centre.x as f32;
        black_box(trials.iter().filter_map(|trial| trial.closest).map(and).sum::<f32>());
    }

    /// True when the candidate at the place of the `trial` that was looked at is proved apart from everything placed, and
    /// inside the specimen.
    pub(super) fn free(&self, it: &Candidate, trial: &Trial, work: &mut Workplace) -> bool {
        let (placement, Trial { centre, taken, closest, .. }) = (self.task.request.placement, trial);
        // The body most likely in the way, first: it ends most attempts.
        if *taken || closest.is_some_and(|other| !self.apart(it, centre, other as usize, work)) {
            return false;
        }
        if !self.task.room.holds(&it.vertices, centre, placement.wall_gap_mm) {
            return false;
        }
        let gap = placement.min_gap_mm;
        let aabb = it.aabb.moved(centre).grown(gap);
        self.grid.all_near(&aabb, |other| Some(other) == *closest || self.apart(it, centre, other as usize, work))
    }

    /// True when the candidate at `centre` is proved apart from the bodies placed from `first_mate` on.
    pub(super) fn free_of_mates(&self, it: &Candidate, centre: &Vec3, first_mate: usize, work: &mut Workplace) -> bool {
        (first_mate..self.placed.len()).all(|other| self.apart(it, centre, other, work))
    }

    /// Of the bodies around the centre of the trial, finds one whose inscribed ball meets the candidate's, or else that which
    /// comes nearest to it for their size.
    #[inline(always)]
    fn look_around(&self, it: &Candidate, trial: &mut Trial) {
        let [x, y, z] = <[f64; 3]>::from(trial.centre).map(|x| x as f32);
        let own_radius = it.grain.inner_radius;
        let (mut least, mut closest) = (f32::INFINITY, NONE);
        // The first are the largest, and most often in the way.
        for other in self.grid.list(trial.cell) {
            let [other_x, other_y, other_z, radius] = self.balls[other as usize];
            let (dx, dy, dz, reach) = (other_x - x, other_y - y, other_z - z, own_radius + radius);
            let closeness = (dx * dx + dy * dy + dz * dz) / (reach * reach);
            let is_nearer = closeness < least;
            least = if is_nearer { closeness } else { least };
            closest = if is_nearer { other } else { closest };
            if closeness < MEETS {
                break;
            }
        }
        trial.taken = least < MEETS;
        trial.closest = (!trial.taken && closest != NONE).then_some(closest);
    }

    /// The shape of what was placed as this number.
    #[inline]
    fn body(&self, placed: usize) -> &NarrowPolyhedron {
        &self.task.request.grains[self.numbers[placed] as usize].body
    }

    fn apart(&self, it: &Candidate, centre: &Vec3, placed: usize, work: &mut Workplace) -> bool {
        let Placed { centre: other_centre, bounds } = &self.placed[placed];
        let place = (&(other_centre - centre), self.task.request.placement.min_gap_mm);
        gjk::apart_from(&it.solid, (bounds, self.body(placed)), &mut work.other, place, &mut work.counters)
    }
}

/// The middle grain's diameter counts for no less than this share of the root mean cube of all; gradings come to 0.7 or more.
const LEAST_MIDDLE: f64 = 0.5;

/// Diameter of the middle grain, mm; more where there are so many tiny ones that the large would cover cells without number.
fn middle_size(grains: &[Grain]) -> f64 {
    let size = |grain: &Grain| 2.0 * f64::from(grain.outer_radius);
    let mean_cube = grains.iter().map(|grain| size(grain).powi(3)).sum::<f64>() / grains.len() as f64;
    grains.get(grains.len() / 2).map_or(1.0, |grain| size(grain).max(LEAST_MIDDLE * libm::cbrt(mean_cube)))
}

/// What a search needs to ask about pairs.
pub(super) struct Workplace {
    pub(super) counters: Counters,
    /// The other body, where one is needed: its memory.
    other: gjk::Body,
}

impl Workplace {
    pub(super) fn new() -> Self {
        Self { counters: Counters::default(), other: gjk::Body::new(&[Vec3::zeros()]) }
    }
}
