//! The bodies placed so far, and whether a grain fits among them.

use super::nearby::Nearby;
use crate::task::Task;
use crate::{Moved, Pose};
use meso_collision::geometry::{CompactPolyhedron, Polyhedron};
use meso_collision::gjk::{self, Counters, GjkError};
use meso_collision::math::{Aabb, Vec3};
use meso_collision::posed::{Posed, WithTree};
use meso_collision::prefetch::prefetch;
use meso_collision::simd::Wide;
use meso_concrete::aggregate::Grain;
use std::borrow::Cow;

/// Edge of the grid's cells, as a share of the middle grain's diameter: from 1 to 1.5 all take the same time, and this
/// the least memory.
const CELL: f64 = 1.25;

/// Inscribed balls share a point when their squared distance over the squared distance of touching is below this. The
/// margin covers single precision. In a specimen of many thousand grains across it would be too small: that would
/// cost attempts, never a proof.
const MEETS: f32 = 0.99;

/// The placed bodies, and the indices that find those near a candidate.
pub(super) struct Scene<'a> {
    pub(super) task: &'a Task<'a>,
    /// Every placed grain, and its images that a grain in the box may meet.
    placed: Vec<Placed>,
    /// The number of the grain that each is. Apart, so that the memory of a grain and of where it lies are waited for
    /// together.
    numbers: Vec<u32>,
    /// The space that a grain with its centre in the specimen's box may reach.
    domain: Aabb,
    nearby: Nearby,
    /// Volume placed of every class, mm3.
    class_volume: Vec<f64>,
}

/// Position and bounds of a placed grain: all that most attempts need. Its body in collision's own form would double
/// the memory, and is built when a pair needs it.
#[repr(align(64))]
struct Placed {
    centre: Vec3,
    bounds: gjk::Bounds,
}

/// A grain that looks for its place.
pub(super) struct Candidate<'a> {
    pub(super) grain: &'a Grain,
    body: WithTree<Polyhedron>,
    /// Its hull in collision's own form, with the bounds that decide pairs early.
    solid: gjk::Solid,
    /// Its box about its centre.
    pub(super) aabb: Aabb,
}

/// Result of the prefilter at a position.
#[derive(Clone, Copy)]
pub(super) enum Look {
    /// A body is there.
    Taken,
    /// This body is most likely in the way.
    Near(u32),
    /// Nothing is close.
    Clear,
}

impl<'a> Candidate<'a> {
    /// The candidate for `grain`.
    pub(super) fn new(grain: &'a Grain) -> Self {
        let body = grain.body.widened();
        let hull = body.hull().unwrap_or(Cow::Borrowed(&body));
        let solid = gjk::Solid::new(hull.vertices(), &hull.facets());
        Self { grain, solid, aabb: grain.body.aabb(), body: WithTree::new(body) }
    }
}

impl<'a> Scene<'a> {
    pub(super) fn new(task: &'a Task<'a>) -> Self {
        let grains = task.request.grains;
        let middle = middle_size(grains);
        let domain = task.domain();
        Self {
            task,
            // A growing list would leave as much memory behind; of reserved memory only the used part counts.
            placed: Vec::with_capacity(grains.len()),
            numbers: Vec::with_capacity(grains.len()),
            nearby: Nearby::new(&domain, CELL * middle, grains.len()),
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
    pub(super) fn insert(&mut self, number: usize, candidate: &Candidate, centre: Vec3) {
        let Candidate { grain, solid, aabb: local, .. } = candidate;
        let aabb = local.moved(&centre);
        for shift in self.task.period.shifts(&aabb, &self.domain) {
            let centre = centre + shift;
            let [x, y, z] = <[f64; 3]>::from(centre).map(|x| x as f32);
            self.nearby.insert(&aabb.moved(&shift), [x, y, z, grain.inner_radius]);
            self.numbers.push(number as u32);
            self.placed.push(Placed { centre, bounds: solid.body().bounds() });
        }
        self.class_volume[usize::from(grain.class)] += grain.graded_volume();
    }

    /// The pose of every grain; the lookup is freed before the list is made.
    pub(super) fn into_poses(self) -> Vec<Option<Pose>> {
        let Self { task, placed, numbers, nearby, .. } = self;
        drop(nearby);
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
        self.class_volume[class] + grain.graded_volume() / 2.0 >= self.task.class_targets[class]
    }

    /// True when the candidate at `centre`, already prefiltered, is proved apart from everything placed and inside
    /// the specimen.
    pub(super) fn free(&self, it: &Candidate, centre: &Vec3, look: Look, work: &mut Scratch) -> bool {
        // The body most likely in the way, first: it ends most attempts.
        let closest = match look {
            Look::Taken => return false,
            Look::Near(other) if !self.apart(it, centre, other as usize, work) => return false,
            Look::Near(other) => Some(other),
            Look::Clear => None,
        };
        let placement = self.task.request.placement;
        let (container, wall_gap) = (&self.task.container, placement.wall_gap_mm);
        if !container.holds_body(&it.body.form(), &it.body.vertices(), centre, wall_gap) {
            return false;
        }
        let gap = placement.min_gap_mm;
        let aabb = it.aabb.moved(centre).grown(gap);
        self.nearby.all_near(&aabb, |other| Some(other) == closest || self.apart(it, centre, other as usize, work))
    }

    /// True when the candidate at `centre` is proved apart from the bodies placed from `first_mate` on.
    pub(super) fn free_of_mates(&self, it: &Candidate, centre: &Vec3, first_mate: usize, work: &mut Scratch) -> bool {
        (first_mate..self.placed.len()).all(|other| self.apart(it, centre, other, work))
    }

    /// The shape of a placed body.
    #[inline]
    fn body(&self, placed: usize) -> &CompactPolyhedron {
        &self.task.request.grains[self.numbers[placed] as usize].body
    }

    fn apart(&self, it: &Candidate, centre: &Vec3, placed: usize, work: &mut Scratch) -> bool {
        let Placed { centre: other_centre, bounds } = &self.placed[placed];
        let (offset, gap) = (other_centre - centre, self.task.request.placement.min_gap_mm);
        let mut hulls =
            || gjk::apart_from(&it.solid, (bounds, self.body(placed)), work.other, (&offset, gap), work.counters);
        if self.task.only_hulls {
            return hulls();
        }
        // Coordinates on the lattice make the sums exact.
        let other = Moved { body: self.body(placed), pose: &Pose::at(Vec3::zeros()), offset: &offset };
        it.body.is_apart(&other, gap, || Ok::<_, GjkError>(hulls())) == Ok(true)
    }
}

/// The prefilter: tests positions for the most frequent rejections, in vector registers. A rejection stays right when
/// more is placed.
pub(super) struct Looking<'a, const N: usize> {
    pub(super) scene: &'a Scene<'a>,
    pub(super) it: &'a Candidate<'a>,
    pub(super) centres: &'a [Vec3; N],
    /// Results of the first centres.
    pub(super) looks: &'a mut [Look],
}

impl<const N: usize> Wide for Looking<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { scene, it, centres, looks } = self;
        let at = by_axis(centres);
        // All memory is requested before the first access.
        let cells = scene.nearby.cells_about(&at);
        for &cell in &cells[..looks.len()] {
            scene.nearby.prefetch(cell);
        }
        for (i, look) in looks.iter_mut().enumerate() {
            let closest = scene.nearby.closest(cells[i], [at[0][i], at[1][i], at[2][i]], it.grain.inner_radius);
            *look = match scene.nearby.body(closest) {
                _ if closest.closeness < MEETS => Look::Taken,
                Some(body) => Look::Near(body),
                None => Look::Clear,
            };
        }
        // Prefetches the memory that the proofs will read.
        for look in looks {
            if let Look::Near(other) = *look {
                prefetch(&scene.placed[other as usize..=other as usize]);
                prefetch(scene.body(other as usize).all_coordinates());
            }
        }
    }
}

/// The coordinates in single precision.
#[inline(always)]
fn by_axis<const N: usize>(points: &[Vec3; N]) -> [[f32; N]; 3] {
    let mut by_axis = [[0.0; N]; 3];
    for (i, point) in points.iter().enumerate() {
        for (axis, along) in by_axis.iter_mut().enumerate() {
            along[i] = point[axis] as f32;
        }
    }
    by_axis
}

/// The middle grain's diameter counts for at least this share of the root mean cube of all; gradings come to 0.7 or
/// more.
const LEAST_MIDDLE: f64 = 0.5;

/// Diameter of the middle grain, mm. It is larger where there are so many tiny grains that large ones would cover
/// countless cells.
fn middle_size(grains: &[Grain]) -> f64 {
    let size = |grain: &Grain| 2.0 * f64::from(grain.outer_radius);
    let mean_cube = grains.iter().map(|grain| size(grain).powi(3)).sum::<f64>() / grains.len() as f64;
    grains.get(grains.len() / 2).map_or(1.0, |grain| size(grain).max(LEAST_MIDDLE * libm::cbrt(mean_cube)))
}

/// Scratch memory of a search.
pub(super) struct Scratch<'a> {
    pub(super) counters: &'a mut Counters,
    /// Memory for the other body of a pair.
    pub(super) other: &'a mut gjk::Body,
}
