//! What is placed so far, and whether a grain has room among it.

use super::mask::Mask;
use crate::aggregate::take::Grain;
use crate::gjk::{self, Counters};
use crate::math::{Aabb, Vec3};
use crate::packing::grid::Grid;
use crate::packing::place::Task;

/// Edge of the mask's voxels, as a share of the middle grain's diameter: 1.3 mm in a grading of 5 to 20 mm.
const VOXEL: f64 = 0.2;

/// The placed bodies, and the indices that find those near a candidate.
pub(super) struct Scene<'a> {
    pub(super) task: &'a Task<'a>,
    /// Every placed grain, and its images that a grain in the box may meet.
    placed: Vec<Placed>,
    /// The placed grains in the form collision works on.
    bodies: Vec<gjk::Body>,
    /// What a grain with its centre in the specimen's box may reach.
    domain: Aabb,
    grid: Grid,
    mask: Mask,
    /// Inner radius of the roundest grain from each on, mm: what the mask has to know about.
    inner_radii: Vec<f64>,
    /// Volume placed of every class, mm3.
    class_volume: Vec<f64>,
}

/// Where a body lies; what most attempts end with stands here, side by side.
struct Placed {
    /// Its place among the bodies.
    body: u32,
    /// Of the ball about the centre that the body holds, mm.
    inner_radius: f32,
    centre: Vec3,
}

/// A grain that looks for its place.
pub(super) struct Candidate<'a> {
    pub(super) grain: &'a Grain,
    /// In the form collision works on, with all that lets pairs be told apart early.
    pub(super) body: gjk::Body,
    /// Its box about its centre.
    pub(super) aabb: Aabb,
}

impl<'a> Candidate<'a> {
    pub(super) fn new(grain: &'a Grain) -> Self {
        let body = gjk::Body::on_ellipsoid(grain.body.vertices(), &grain.semi_axes, &grain.rotation);
        Self { grain, body: body.with_inside_of(&grain.body), aabb: grain.body.aabb() }
    }
}

impl<'a> Scene<'a> {
    pub(super) fn new(task: &'a Task<'a>) -> Self {
        let grains = task.request.grains;
        let middle = grains.get(grains.len() / 2).map_or(1.0, |grain| 2.0 * grain.outer_radius);
        let mut inner_radii: Vec<f64> = grains.iter().map(|grain| grain.inner_radius).collect();
        for i in (1..inner_radii.len()).rev() {
            inner_radii[i - 1] = inner_radii[i - 1].max(inner_radii[i]);
        }
        let domain = task.domain();
        Self {
            task,
            placed: Vec::new(),
            // Room for all at once: memory that is not used costs nothing, and a list that grows is copied.
            bodies: Vec::with_capacity(grains.len()),
            grid: Grid::new(&domain, middle),
            mask: Mask::new(&task.room.aabb(), VOXEL * middle, inner_radii.first().map_or(1.0, |radius| *radius)),
            domain,
            inner_radii,
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
        let Candidate { grain, body, aabb: local } = candidate;
        let aabb = local.moved(&centre);
        for shift in self.task.period.shifts(&aabb, &self.domain) {
            self.grid.insert(&aabb.moved(&shift));
            self.mask.insert(&grain.body, &(centre + shift), self.inner_radii[number]);
            let (body, inner_radius) = (self.bodies.len() as u32, grain.inner_radius as f32);
            self.placed.push(Placed { body, inner_radius, centre: centre + shift });
        }
        self.bodies.push(body);
        self.class_volume[usize::from(grain.class)] += grain.volume;
    }

    /// True when the class of `grain` comes no nearer to its target with it.
    pub(super) fn class_is_full(&self, grain: &Grain) -> bool {
        let class = usize::from(grain.class);
        self.class_volume[class] + grain.volume / 2.0 >= self.task.class_targets[class]
    }

    /// True when the candidate at `centre` is proved apart from everything placed, and inside the specimen.
    pub(super) fn free(&self, it: &Candidate, centre: &Vec3, counters: &mut Counters) -> bool {
        let (placement, grain) = (self.task.request.placement, it.grain);
        if self.mask.forbids(centre, grain.inner_radius) {
            return false;
        }
        // The body most likely in the way, first: it ends most attempts.
        let closest = self.closest(it, centre);
        if closest.is_some_and(|other| !self.apart(it, centre, other, counters)) {
            return false;
        }
        if !self.task.room.holds(grain.body.vertices(), centre, placement.wall_gap_mm) {
            return false;
        }
        let gap = placement.min_gap_mm;
        let aabb = it.aabb.moved(centre).grown(gap);
        self.grid.all_near(&aabb, |other| {
            let other = other as usize;
            Some(other) == closest || self.apart(it, centre, other, counters)
        })
    }

    /// True when the candidate at `centre` is proved apart from the bodies placed from `first_mate` on.
    pub(super) fn free_of_mates(
        &self,
        it: &Candidate,
        centre: &Vec3,
        first_mate: usize,
        counters: &mut Counters,
    ) -> bool {
        (first_mate..self.placed.len()).all(|other| self.apart(it, centre, other, counters))
    }

    /// Of the bodies around `centre`, the one whose inscribed ball comes nearest to the candidate's for their size.
    fn closest(&self, it: &Candidate, centre: &Vec3) -> Option<usize> {
        let closeness = |other: u32| {
            let Placed { inner_radius, centre: other_centre, .. } = &self.placed[other as usize];
            let reach = it.grain.inner_radius + f64::from(*inner_radius);
            ((other_centre - centre).norm_squared() / (reach * reach), other as usize)
        };
        self.grid.at(centre).map(closeness).min_by(|p, q| p.0.total_cmp(&q.0)).map(|(_, other)| other)
    }

    fn apart(&self, it: &Candidate, centre: &Vec3, placed: usize, counters: &mut Counters) -> bool {
        let Placed { body, centre: other_centre, .. } = &self.placed[placed];
        let (other, gap) = (&self.bodies[*body as usize], self.task.request.placement.min_gap_mm);
        gjk::apart_counted(&it.body, other, &(other_centre - centre), gap, None, counters).is_some()
    }
}
