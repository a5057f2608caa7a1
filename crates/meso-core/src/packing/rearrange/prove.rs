//! The proof: every pair of the final bodies, in double precision at their final coordinates, or one of them goes.

use crate::aggregate::take::{Grain, snap};
use crate::gjk::{self, Counters};
use crate::math::{Aabb, Vec3};
use crate::packing::grid::Grid;
use crate::packing::place::Task;
use crate::packing::{Placement, Pose, Work};
use rayon::prelude::*;

/// The final poses on the lattice, less the grains that are not proved inside and apart from all others.
pub(super) struct Proved {
    pub(super) poses: Vec<Option<Pose>>,
    /// Grains that had to go.
    pub(super) left_out: usize,
}

/// Keeps of `reached` (grain and pose) what is proved; of two grains in doubt the one with more doubts goes, then the
/// smaller.
pub(super) fn keep_apart(task: &Task, reached: &[(u32, Pose)], work: &mut Work) -> Proved {
    let settle = |pose: &Pose| Pose { centre: task.period.wrap(&snap(&pose.centre)), ..*pose };
    let mut there: Vec<(u32, Pose)> = reached.iter().map(|(grain, pose)| (*grain, settle(pose))).collect();
    there.sort_unstable_by_key(|&(grain, _)| grain);
    let settled: Vec<Settled> =
        there.par_iter().map(|(grain, pose)| Settled::new(task, &task.request.grains[*grain as usize], pose)).collect();
    let scene = Scene::new(task, &settled);
    let looks: Vec<(Vec<u32>, Counters)> = (0..settled.len()).into_par_iter().map(|body| scene.doubts(body)).collect();
    looks.iter().for_each(|look| work.add(&look.1));
    let mut kept: Vec<bool> = settled.iter().map(|body| body.inside).collect();
    drop_doubtful(looks.into_iter().map(|look| look.0).collect(), &mut kept);
    let mut poses = vec![None; task.request.grains.len()];
    for (&(grain, pose), _) in there.iter().zip(&kept).filter(|(_, kept)| **kept) {
        poses[grain as usize] = Some(pose);
    }
    Proved { poses, left_out: kept.iter().filter(|kept| !**kept).count() }
}

/// A grain at its final coordinates.
struct Settled {
    body: gjk::Body,
    centre: Vec3,
    aabb: Aabb,
    radius: f64,
    inside: bool,
}

impl Settled {
    fn new(task: &Task, grain: &Grain, pose: &Pose) -> Self {
        let vertices = pose.turned(grain.body.vertices());
        let local = Aabb::around(&vertices);
        let Placement { min_gap_mm, wall_gap_mm, .. } = task.request.placement;
        let half_gap = Vec3::repeat(*min_gap_mm);
        Self {
            body: gjk::Body::new(&vertices),
            centre: pose.centre,
            aabb: Aabb { min: local.min + pose.centre - half_gap, max: local.max + pose.centre + half_gap },
            radius: grain.outer_radius,
            inside: task.room.holds(&vertices, &pose.centre, *wall_gap_mm),
        }
    }

    /// True when the boxes meet, with `other` moved by `shift`.
    fn meets(&self, other: &Self, shift: &Vec3) -> bool {
        self.aabb.intersects(&Aabb { min: other.aabb.min + shift, max: other.aabb.max + shift })
    }
}

/// All bodies and their images.
struct Scene<'a> {
    task: &'a Task<'a>,
    settled: &'a [Settled],
    /// Number of the body and displacement of every item of the grid.
    images: Vec<(u32, Vec3)>,
    grid: Grid,
}

impl<'a> Scene<'a> {
    fn new(task: &'a Task<'a>, settled: &'a [Settled]) -> Self {
        let domain = task.domain();
        let mut scene = Self {
            task,
            settled,
            images: Vec::new(),
            grid: Grid::new(&domain, 2.0 * settled[settled.len() / 2].radius),
        };
        for (number, body) in (0..).zip(settled) {
            for shift in task.period.shifts(&body.aabb, &domain) {
                scene.grid.insert(&Aabb { min: body.aabb.min + shift, max: body.aabb.max + shift });
                scene.images.push((number, shift));
            }
        }
        scene
    }

    /// The bodies before `body`, or it itself, with an image that it is not proved apart from, and what it took.
    fn doubts(&self, body: usize) -> (Vec<u32>, Counters) {
        let own = &self.settled[body];
        let (mut doubts, mut counters) = (Vec::new(), Counters::default());
        self.grid.all_near(&own.aabb, |item| {
            let (other, shift) = self.images[item as usize];
            let it = &self.settled[other as usize];
            let is_other = (other as usize) < body || (other as usize == body && shift != Vec3::zeros());
            if is_other && own.meets(it, &shift) && !self.apart(own, it, &shift, &mut counters) {
                doubts.push(other);
            }
            true
        });
        doubts.sort_unstable();
        doubts.dedup();
        (doubts, counters)
    }

    fn apart(&self, a: &Settled, b: &Settled, shift: &Vec3, counters: &mut Counters) -> bool {
        let (offset, gap) = (b.centre + shift - a.centre, self.task.request.placement.min_gap_mm);
        gjk::apart_counted(&a.body, &b.body, &offset, gap, None, counters).is_some()
    }
}

/// Drops grains until no doubtful pair is left; grains come in descending volume.
fn drop_doubtful(doubts: Vec<Vec<u32>>, kept: &mut [bool]) {
    let mut pairs: Vec<(u32, u32)> = doubts
        .iter()
        .enumerate()
        .flat_map(|(body, others)| others.iter().map(move |&other| (other, body as u32)))
        .collect();
    loop {
        pairs.retain(|&(p, q)| kept[p as usize] && kept[q as usize]);
        let mut count = vec![0u32; kept.len()];
        for &(p, q) in &pairs {
            count[p as usize] += 1;
            count[q as usize] += 1;
        }
        // Whoever has the most doubts among its own doubtful neighbours goes; of equals the smaller.
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
