//! Certification: every pair of the final bodies is proved apart in double precision at the final coordinates, or one
//! of the two is left out.

use crate::task::Task;
use crate::{Moved, Placement, Pose, Work};
use meso_collision::geometry::BoxTree;
use meso_collision::gjk::{self, Counters, GjkError};
use meso_collision::math::{Aabb, Vec3};
use meso_collision::posed::Posed;
use meso_concrete::aggregate::grain::{Grain, snap};
use meso_concrete::parallel;
use meso_concrete::stop;

/// The final poses on the lattice, less the grains that are not proved inside and apart from all others.
pub(super) struct Proved {
    pub(super) poses: Vec<Option<Pose>>,
    /// Grains left out.
    pub(super) left_out: usize,
    /// Grains of pairs that are not proved apart.
    pub(super) unproved: Vec<u32>,
}

/// Keeps the proved bodies of `reached` (grain and pose, neighbours near each other in the list). Two grains that are
/// not proved apart lose the one with more such pairs, or the smaller one.
pub(super) fn keep_apart(task: &Task, reached: &[(u32, Pose)], work: &mut Work) -> Proved {
    let settle = |pose: &Pose| Pose { centre: task.period.wrap(&snap(&pose.centre)), ..*pose };
    let mut there: Vec<(u32, Pose)> = reached.iter().map(|(grain, pose)| (*grain, settle(pose))).collect();
    there.sort_unstable_by_key(|&(grain, _)| grain);
    let settled = parallel::map(there.len(), |number| {
        let (grain, pose) = &there[number];
        Settled::new(task, &task.request.grains[*grain as usize], pose)
    });
    let scene = ImagedBodies::new(task, &settled);
    let number = |grain: u32| there.partition_point(|body| body.0 < grain) as u32;
    let near = parallel::map_each(reached, |&(grain, _)| number(grain));
    let chunks: Vec<&[u32]> = near.chunks(CHUNK).collect();
    let looks = parallel::map_each(&chunks, |bodies| scene.unproved(bodies));
    looks.iter().for_each(|look| work.add(&look.1));
    let mut kept: Vec<bool> = settled.iter().map(|body| body.inside).collect();
    let pairs: Vec<(u32, u32)> = looks.iter().flat_map(|look| &look.0).map(|pair| (pair.other, pair.body)).collect();
    let mut unproved: Vec<u32> = pairs.iter().flat_map(|&(p, q)| [p, q]).map(|body| there[body as usize].0).collect();
    unproved.sort_unstable();
    unproved.dedup();
    leave_out_unproved(pairs, &mut kept);
    let mut poses = vec![None; task.request.grains.len()];
    for (&(grain, pose), _) in there.iter().zip(&kept).filter(|(_, kept)| **kept) {
        poses[grain as usize] = Some(pose);
    }
    Proved { poses, left_out: kept.iter().filter(|kept| !**kept).count(), unproved }
}

/// Bodies a thread certifies at once. Only they and their neighbours are then held in collision's own form, which is
/// as large as a grain: all at once were the peak of memory.
const CHUNK: usize = 512;

/// A grain at its final coordinates.
struct Settled<'a> {
    grain: &'a Grain,
    pose: &'a Pose,
    aabb: Aabb,
    inside: bool,
}

impl<'a> Settled<'a> {
    fn new(task: &Task, grain: &'a Grain, pose: &'a Pose) -> Self {
        stop::point();
        let body = Moved { body: &grain.body, pose, offset: &Vec3::zeros() };
        let (form, vertices) = (body.form(), body.vertices());
        let Placement { min_gap_mm, wall_gap_mm, .. } = task.request.placement;
        Self {
            grain,
            pose,
            aabb: form.aabb(&vertices).moved(&pose.centre).grown(*min_gap_mm),
            inside: task.container.holds_body(&form, &vertices, &pose.centre, *wall_gap_mm),
        }
    }

    fn body(&self) -> gjk::Body {
        gjk::Body::new(&self.pose.turned(&self.grain.body))
    }

    /// True when the boxes meet, with `other` moved by `shift`.
    fn meets(&self, other: &Self, shift: &Vec3) -> bool {
        self.aabb.intersects(&other.aabb.moved(shift))
    }
}

/// Two bodies whose boxes meet, the other moved by `shift`.
#[derive(Clone, Copy)]
struct Near {
    body: u32,
    other: u32,
    shift: Vec3,
}

/// All bodies and their images.
struct ImagedBodies<'a> {
    task: &'a Task<'a>,
    settled: &'a [Settled<'a>],
    /// Number of the body and displacement of every item of the tree.
    images: Vec<(u32, Vec3)>,
    tree: BoxTree,
}

impl<'a> ImagedBodies<'a> {
    fn new(task: &'a Task<'a>, settled: &'a [Settled<'a>]) -> Self {
        let domain = task.domain();
        let shifts = |body: &Settled| task.period.shifts(&body.aabb, &domain);
        let of_one = |(number, body)| shifts(body).into_iter().map(move |shift| (number, shift));
        let images: Vec<(u32, Vec3)> = (0..).zip(settled).flat_map(of_one).collect();
        let boxes: Vec<Aabb> =
            images.iter().map(|(number, shift)| settled[*number as usize].aabb.moved(shift)).collect();
        Self { task, settled, images, tree: BoxTree::new(&boxes) }
    }

    /// The pairs of `bodies` that are not proved apart, and the counters.
    fn unproved(&self, bodies: &[u32]) -> (Vec<Near>, Counters) {
        let mut counters = Counters::default();
        let mut pairs: Vec<Near> = bodies.iter().flat_map(|&body| self.near(body)).collect();
        let mut numbers: Vec<u32> = pairs.iter().flat_map(|pair| [pair.body, pair.other]).collect();
        numbers.sort_unstable();
        numbers.dedup();
        let bodies: Vec<gjk::Body> = numbers.iter().map(|&number| self.settled[number as usize].body()).collect();
        let body = |number: u32| &bodies[numbers.partition_point(|&other| other < number)];
        pairs.retain(|pair| !self.apart(pair, body(pair.body), body(pair.other), &mut counters));
        (pairs, counters)
    }

    /// The bodies before `body`, and it itself, with an image whose box meets its own.
    fn near(&self, body: u32) -> impl Iterator<Item = Near> {
        stop::point();
        let own = &self.settled[body as usize];
        self.tree.near(own.aabb).filter_map(move |item| {
            let (other, shift) = self.images[item as usize];
            let is_other = other < body || (other == body && shift != Vec3::zeros());
            let meets = is_other && own.meets(&self.settled[other as usize], &shift);
            meets.then_some(Near { body, other, shift })
        })
    }

    fn apart(&self, pair: &Near, a: &gjk::Body, b: &gjk::Body, counters: &mut Counters) -> bool {
        stop::point();
        let [own, other] = [pair.body, pair.other].map(|number| &self.settled[number as usize]);
        let (offset, gap) = (other.pose.centre + pair.shift - own.pose.centre, self.task.request.placement.min_gap_mm);
        let moved = |it: &Settled<'a>, offset| Moved { body: &it.grain.body, pose: it.pose, offset };
        let hulls = || Ok::<_, GjkError>(counters.apart(a, b, &offset, gap, None).is_some());
        moved(own, &Vec3::zeros()).is_apart(&moved(other, &offset), gap, hulls) == Ok(true)
    }
}

/// Leaves out grains until no unproved pair remains; grains come in descending volume.
fn leave_out_unproved(mut pairs: Vec<(u32, u32)>, kept: &mut [bool]) {
    // Two bodies may be unproved in several images.
    pairs.sort_unstable();
    pairs.dedup();
    loop {
        pairs.retain(|&(p, q)| kept[p as usize] && kept[q as usize]);
        let mut count = vec![0u32; kept.len()];
        for &(p, q) in &pairs {
            count[p as usize] += 1;
            count[q as usize] += 1;
        }
        // The body with the most unproved pairs among its own neighbours is left out; of equals, the smaller.
        let goes: Vec<u32> =
            pairs.iter().map(|&(p, q)| if count[p as usize] > count[q as usize] { p } else { q }).collect();
        if goes.is_empty() {
            return;
        }
        let worst = goes.iter().map(|&body| count[body as usize]).max().unwrap_or(0);
        for body in goes.into_iter().filter(|&body| count[body as usize] == worst) {
            kept[body as usize] = false;
        }
    }
}
