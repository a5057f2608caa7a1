//! Initial placement: grains are dropped, largest first, where they overlap least.

use super::FILLING;
use super::clearance_grid::{ClearanceGrid, around};
use crate::task::Task;
use crate::{Pose, StopReason};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Grain;
use meso_concrete::aggregate::Kind;
use meso_concrete::aggregate::random::{Draw, Stream};
use meso_concrete::parallel;
use meso_concrete::stop;
use meso_concrete::watch::Stage;

/// Random positions tried per dropped grain.
const LOOKS: usize = 12;
/// Positions tried for a fibre. With 12 a 75 mm cube at 0.50 with 1 % of fibres of 0.5 x 30 mm jammed; with 60 it does
/// not.
const LOOKS_FOR_A_LINE: usize = 60;
/// Draws per look until a point lies deep enough in a specimen that does not fill its box.
const DRAWS: usize = 100;
/// Grains dropped together, blind to each other, as a share of those already there.
const TOGETHER: f64 = 1.0 / 32.0;

/// For every wanted grain that fits into the specimen: its number, and the one of its random positions with the
/// largest clearance to those before it. Fibres come last: they look for a line that the others leave free.
///
/// # Errors
/// The reason to stop, where there is one before all are dropped.
pub(super) fn fill(task: &Task, wanted: impl Fn(usize) -> bool) -> Result<Vec<(u32, Pose)>, StopReason> {
    let grains = task.request.grains;
    let middle = grains.get(grains.len() / 2).map_or(1.0, |grain| 2.0 * f64::from(grain.outer_radius));
    let domain = task.domain();
    let mut ground = Ground { task, domain, balls: ClearanceGrid::new(&domain, middle) };
    let admitted = (0..grains.len()).filter(|&number| wanted(number) && task.admits(&grains[number]));
    let (long, short): (Vec<usize>, Vec<usize>) = admitted.partition(|&number| grains[number].kind == Kind::Fibre);
    let mut poses = Vec::with_capacity(grains.len());
    for order in [short, long] {
        let mut rest = order.as_slice();
        while !rest.is_empty() {
            let dropped = order.len() - rest.len();
            task.done(Stage::Place, FILLING * poses.len() as f64 / grains.len() as f64);
            if let Some(reason) = task.stopped(0.0) {
                return Err(reason);
            }
            let together = rest.len().min(1 + (TOGETHER * dropped as f64) as usize);
            for (number, row, centre) in ground.look_for(&rest[..together]) {
                poses.push((number as u32, Pose::at(centre)));
                row.balls.iter().for_each(|ball| ground.insert(row.radius, centre + ball));
            }
            rest = &rest[together..];
        }
    }
    poses.sort_unstable_by_key(|&(number, _)| number);
    Ok(poses)
}

/// A grain as balls of one radius (mm), about its centre: the one of its volume, or a row of thin ones along a fibre.
struct Row {
    radius: f64,
    balls: Vec<Vec3>,
}

/// Distance of the balls in a row over their radius, and most of them on either side of the middle.
const STEP: f64 = 4.0;
const MOST_BALLS: f64 = 16.0;

impl Row {
    fn of(grain: &Grain) -> Self {
        if grain.kind != Kind::Fibre {
            return Self { radius: grain.ball_radius(), balls: vec![Vec3::zeros()] };
        }
        let (radius, end) = (f64::from(grain.inner_radius), grain.half_length());
        let count = (f64::from(grain.outer_radius) / (STEP * radius)).ceil().clamp(1.0, MOST_BALLS);
        let shares = (-(count as i32)..=count as i32).map(|k| f64::from(k) / count);
        Self { radius, balls: shares.map(|share| end * share).collect() }
    }

    fn looks(&self) -> usize {
        if self.balls.len() > 1 { LOOKS_FOR_A_LINE } else { LOOKS }
    }
}

/// The grains already there, as balls of the same volume.
struct Ground<'a> {
    task: &'a Task<'a>,
    domain: Aabb,
    balls: ClearanceGrid,
}

impl Ground<'_> {
    fn insert(&mut self, radius: f64, centre: Vec3) {
        for shift in self.task.period.shifts(&around(&centre, radius), &self.domain) {
            self.balls.insert(&(centre + shift), radius);
        }
    }

    /// The grains of these numbers, each with its best position.
    fn look_for(&self, numbers: &[usize]) -> Vec<(usize, Row, Vec3)> {
        let look = |&number: &usize| {
            let grain = &self.task.request.grains[number];
            let row = Row::of(grain);
            let centre = self.best_position(grain, &row);
            (number, row, centre)
        };
        parallel::map_each(numbers, look)
    }

    fn best_position(&self, body: &Grain, row: &Row) -> Vec3 {
        stop::point();
        let mut stream = Stream::new(self.task.request.target.seed, Draw::Drop, body.class, u64::from(body.index));
        let reach = self.task.reach(&body.body.aabb());
        let mut best = (f32::NEG_INFINITY, reach.min);
        for _ in 0..row.looks() {
            let centre = self.inner_point(&mut stream, &reach, f64::from(body.inner_radius));
            let clearance = self.clearance(row, &centre, best.0);
            best = if clearance > best.0 { (clearance, centre) } else { best };
        }
        best.1
    }

    /// The clearance of a ball, as [`ClearanceGrid::clearance`]; of a row of balls the sum of their overlaps,
    /// negative.
    fn clearance(&self, row: &Row, centre: &Vec3, enough: f32) -> f32 {
        match row.balls[..] {
            [_] => self.balls.clearance(centre, row.radius, enough),
            _ => {
                let clearance = |ball: &Vec3| self.balls.clearance(&(centre + ball), row.radius, f32::NEG_INFINITY);
                row.balls.iter().map(|ball| clearance(ball).min(0.0)).sum()
            }
        }
    }

    /// A random point of `reach`, `depth` mm inside the walls where a few draws find one.
    fn inner_point(&self, stream: &mut Stream, reach: &Aabb, depth: f64) -> Vec3 {
        let mut point = stream.point(&reach.min, &reach.max);
        let depth = depth + self.task.request.placement.wall_gap_mm;
        for _ in 0..DRAWS {
            if self.task.container.is_box() || self.task.container.is_clear(&point, depth) {
                break;
            }
            point = stream.point(&reach.min, &reach.max);
        }
        point
    }
}
