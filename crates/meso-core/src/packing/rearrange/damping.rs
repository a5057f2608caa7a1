//! How fast the moving bodies come to rest.
//!
//! Dropped at random they overlap deeply, and momentum turns that energy into motion: the bodies stream past each other
//! like a hot liquid. What share of the motion a sweep takes away, 1 - momentum, is how fast it cools; and as with glass,
//! what cools slowly comes to rest denser. Where grains are free that only takes time; where they wedge, it is what lets
//! them in: a periodic box of 75 mm at 0.73 jams with a momentum of 0.96, and is done after 580 sweeps with 0.97.

use super::fibres;
use crate::aggregate::take::Grain;
use crate::packing::place::Task;

/// Momentum up to where grains wedge, by crowding. Sweeps in the 150 mm cube: 0.50: 29 with 0.7, 38 with 0.8; 0.60: 70 with
/// 0.85, 168 with 0.8; 0.68: 242 with 0.94, 712 with 0.92.
const QUICK: f64 = 0.945;
/// Crowding within the rims along the walls from which on more is needed, how much more, and the most: with 0.99 the steps
/// themselves keep the bodies hot. Sweeps in a periodic box of 75 mm with 0.945, 0.96, 0.97 and 0.98: 0.68: 156, 205, 236, 448;
/// 0.72: 1158, 338, 366, 633; 0.73: jammed, jammed, 580, 818; 0.74: 1150 with 0.98.
const WEDGED: f64 = 0.71;
const GAIN: f64 = 1.5;
const SLOWEST: f64 = 0.98;
/// A jam is started over, cooled so many times slower or more, unless it was nearly the slowest,
const SLOWER: f64 = 2.0;
const NOTABLY: f64 = 1.25;
/// and where the root mean square of what a body lacks is less than this share of the smallest grain's radius: what lacks
/// more is too much for the room.
pub(super) const HOPEFUL: f64 = 0.1;
/// It is jammed when the energy has not fallen by this factor in so many sweeps, times as many as it cools slower than
/// quickly.
pub(super) const FALL: f64 = 0.7;
const PATIENCE: f64 = 150.0;
/// A jam of more than fits is started over with fewer grains: so much of the volume goes for the root of what a body lacks, in
/// radii of the smallest grain; no less than the least, below which a relief does, nor more than the most. A body lacks 0.08
/// and 0.76 radii in jams of a 75 mm cube without walls at 0.76 and 0.80, where 0.74 fits; with walls, at 0.70, 0.72 and 0.75,
/// 0.18, 0.43 and 0.69, where 0.675 does.
const EXCESS: f64 = 0.09;
const LEAST_EXCESS: f64 = 0.015;
const MOST_EXCESS: f64 = 0.1;
/// A jam is relieved by leaving out the worst wedged grains: so much of the volume for every radius of the smallest grain
/// that a body lacks, since the energy of a jam grows with the square of the volume that is too much; the next time twice as
/// much as the last, and never less or more than this.
const RELIEF: f64 = 0.3;
const LEAST_RELIEF: f64 = 0.004;
const MOST_RELIEF: f64 = 0.02;

/// What sets the momentum.
#[derive(Clone, Copy)]
pub(super) struct Damping {
    /// Share of the room that is taken, gaps included; fibres count for more.
    crowding: f64,
    /// Share that is taken of the room within the rims along the walls, as wide as a small grain's radius, where hardly any
    /// grain is; fibres count for what they are.
    within_rims: f64,
    /// Momentum is no less, after a jam.
    least: f64,
    /// Too little time is left to cool slowly.
    is_hurried: bool,
    /// Share of the volume that was left out the last time, or 0; what was relieved needs no more slowness.
    relief: f64,
}

impl Damping {
    /// For the grains of `task`, the smallest as large as a ball of this `radius` (mm).
    pub(super) fn new(task: &Task, radius: f64) -> Self {
        let rim = radius + task.request.placement.wall_gap_mm;
        let within_rims = crowding(task, |_| 1.0) / within(task, rim);
        Self { crowding: crowding(task, fibres::weight), within_rims, least: 0.0, is_hurried: false, relief: 0.0 }
    }

    /// Share of a sweep's movement that goes on in the next.
    pub(super) fn momentum(&self) -> f64 {
        let quick = (0.7 + (self.crowding - 0.5) * 1.4).clamp(0.6, QUICK);
        if !self.is_slow() {
            return quick;
        }
        let beyond = self.within_rims - WEDGED;
        let wedged = if beyond > 0.0 { QUICK + beyond * GAIN } else { 0.0 };
        quick.max(wedged).max(self.least).min(SLOWEST)
    }

    fn is_slow(&self) -> bool {
        !self.is_hurried && self.relief == 0.0
    }

    /// From now on cools as fast as may be.
    pub(super) fn hurry(&mut self) {
        self.is_hurried = true;
    }

    /// Sweeps without progress that make a jam.
    pub(super) fn patience(&self) -> u32 {
        (PATIENCE * ((1.0 - QUICK) / (1.0 - self.momentum())).max(1.0)) as u32
    }

    /// The next try's after a jam with this `lack` (root mean square of what a body lacks of its gaps, over the radius of
    /// the smallest grain), if there is hope.
    pub(super) fn next(&self, lack: f64) -> Option<Self> {
        let motion_lost = 1.0 - self.momentum();
        let is_hopeful = lack < HOPEFUL && motion_lost > NOTABLY * (1.0 - SLOWEST) && self.is_slow();
        is_hopeful.then_some(Self { least: (1.0 - motion_lost / SLOWER).max(QUICK), ..*self })
    }

    /// Share of the volume that is too much in a jam with this `lack`, where a start with less is worth its time, and how fast
    /// that is cooled.
    pub(super) fn fewer(&self, lack: f64) -> Option<(f64, Self)> {
        let excess = (EXCESS * lack.sqrt()).min(MOST_EXCESS);
        let rest = 1.0 - excess;
        let damping = Self { crowding: self.crowding * rest, within_rims: self.within_rims * rest, ..*self };
        (excess >= LEAST_EXCESS && self.is_slow()).then_some((excess, damping))
    }

    /// Share of the volume to be left out of a jam with this `lack`.
    pub(super) fn relieve(&mut self, lack: f64) -> f64 {
        self.relief = (RELIEF * lack).max(2.0 * self.relief).clamp(LEAST_RELIEF, MOST_RELIEF);
        self.crowding *= 1.0 - self.relief;
        self.relief
    }
}

/// The share of the room that the grains take with half of the least gap around each, every one counted for `weight` times
/// that.
fn crowding(task: &Task, weight: impl Fn(&Grain) -> f64) -> f64 {
    let half_gap = task.request.placement.min_gap_mm / 2.0;
    let grown = |grain: &Grain| {
        let scale = 1.0 + half_gap / grain.ball_radius();
        grain.volume() * (scale * scale * scale) * weight(grain)
    };
    task.request.grains.iter().map(grown).sum::<f64>() / task.volume
}

/// The share of the room that is farther than `rim` mm from the walls, as if it were its box: what is as long and as wide
/// all over has as much surface for its volume.
fn within(task: &Task, rim: f64) -> f64 {
    let size = task.container.aabb().size();
    let walled = (0..3).filter(|&axis| task.period.along(axis).is_none());
    walled.map(|axis| (1.0 - 2.0 * rim / size[axis]).max(0.5)).product()
}
