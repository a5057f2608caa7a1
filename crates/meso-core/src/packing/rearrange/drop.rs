//! The start: grains are dropped, largest first, where they overlap least.

use crate::aggregate::random::{Purpose, Stream};
use crate::aggregate::take::Grain;
use crate::math::{Aabb, Vec3};
use crate::packing::Pose;
use crate::packing::grid::Grid;
use crate::packing::place::Task;

/// Random points looked at per dropped grain.
const LOOKS: usize = 12;
/// Draws per look until a point lies deep enough in a specimen that does not fill its box.
const DRAWS: usize = 100;

/// For every grain, of the random positions looked at, the one that leaves it most room among those before it.
pub(super) fn fill(task: &Task) -> Vec<Pose> {
    let grains = task.request.grains;
    let middle = grains.get(grains.len() / 2).map_or(1.0, |grain| 2.0 * grain.outer_radius);
    let domain = task.domain();
    let mut ground = Ground { task, domain, grid: Grid::new(&domain, middle), balls: Vec::new() };
    grains
        .iter()
        .map(|grain| {
            let centre = ground.roomiest(grain);
            ground.insert(grain.ball_radius(), centre);
            Pose::at(centre)
        })
        .collect()
}

/// What lies there already, as balls of the same volume.
struct Ground<'a> {
    task: &'a Task<'a>,
    domain: Aabb,
    grid: Grid,
    balls: Vec<(f64, Vec3)>,
}

impl Ground<'_> {
    fn insert(&mut self, radius: f64, centre: Vec3) {
        let half = Vec3::repeat(radius);
        let aabb = Aabb { min: centre - half, max: centre + half };
        for shift in self.task.period.shifts(&aabb, &self.domain) {
            self.grid.insert(&aabb.moved(&shift));
            self.balls.push((radius, centre + shift));
        }
    }

    fn roomiest(&self, body: &Grain) -> Vec3 {
        let mut stream = Stream::new(self.task.request.seed, Purpose::Drop, body.class, u64::from(body.index));
        let reach = self.task.reach(&body.body.aabb());
        let radius = body.ball_radius();
        let mut best = (f64::NEG_INFINITY, reach.min);
        for _ in 0..LOOKS {
            let centre = self.inner_point(&mut stream, &reach, body.inner_radius);
            let clearance = self.clearance(radius, &centre, best.0);
            best = if clearance > best.0 { (clearance, centre) } else { best };
        }
        best.1
    }

    /// A random point of `reach`, `depth` mm inside the walls where a few draws find one.
    fn inner_point(&self, stream: &mut Stream, reach: &Aabb, depth: f64) -> Vec3 {
        let mut point = stream.point(&reach.min, &reach.max);
        let depth = depth + self.task.request.placement.wall_gap_mm;
        for _ in 0..DRAWS {
            if self.task.room.is_box() || self.task.room.depth(&point) >= depth {
                break;
            }
            point = stream.point(&reach.min, &reach.max);
        }
        point
    }

    /// Distance of the ball to the nearest other, negative where it overlaps one; or of any other, no farther than `enough`.
    fn clearance(&self, radius: f64, centre: &Vec3, enough: f64) -> f64 {
        let half = Vec3::repeat(radius);
        let mut least = f64::INFINITY;
        self.grid.all_near(&Aabb { min: centre - half, max: centre + half }, |other| {
            let (other_radius, other_centre) = self.balls[other as usize];
            least = least.min((other_centre - centre).norm() - radius - other_radius);
            least > enough
        });
        least
    }
}
