//! Damping schedule: how fast the moving bodies come to rest.
//!
//! Dropped at random they overlap deeply, and momentum turns that energy into motion: the bodies stream past each
//! other like a hot liquid. A sweep dissipates the share 1 - momentum of the motion. As with glass, slow cooling ends
//! denser. Where grains are free it only takes time; where they wedge, it lets them in: a periodic box of 75 mm at
//! 0.73 jams with a momentum of 0.96, and is done after 580 sweeps with 0.97.

use super::fibres;
use crate::task::Task;
use meso_concrete::aggregate::Grain;

/// Largest momentum for packings whose grains do not wedge. Sweeps in the 150 mm cube: 0.50: 29 with 0.7, 38 with
/// 0.8; 0.60: 70 with 0.85, 168 with 0.8; 0.68: 242 with 0.94, 712 with 0.92.
const QUICK: f64 = 0.945;
/// Crowding within the rims beyond which more momentum is needed, how much more, and the most: at 0.99 the steps
/// themselves keep the bodies moving. Sweeps in a periodic box of 75 mm with 0.945, 0.96, 0.97 and 0.98: 0.68: 156,
/// 205, 236, 448; 0.72: 1158, 338, 366, 633; 0.73: jammed, jammed, 580, 818; 0.74: 1150 with 0.98.
const WEDGED: f64 = 0.71;
const GAIN: f64 = 1.5;
const SLOWEST: f64 = 0.98;
/// After a jam the run restarts with this many times less damping or more, unless it was nearly the slowest,
const SLOWER: f64 = 2.0;
const NOTABLY: f64 = 1.25;
/// and the bodies lack less than this share of the smallest grain's radius (root mean square). If they lack more, the
/// grains exceed the space.
pub(super) const HOPEFUL: f64 = 0.1;
/// A run is jammed when the energy has not fallen by this factor in this many sweeps, scaled by how much slower than
/// quick the damping is.
pub(super) const FALL: f64 = 0.7;
const PATIENCE: f64 = 150.0;
/// Restart with fewer grains: the volume is cut by `EXCESS` * sqrt(lack), lack in radii of the smallest grain, at
/// most by `MOST_EXCESS`. Below `LEAST_EXCESS` relief suffices. Jams of a 75 mm cube without walls at 0.76 and 0.80
/// lack 0.08 and 0.76 radii, where 0.74 fits; with walls, at 0.70, 0.72 and 0.75, they lack 0.18, 0.43 and 0.69,
/// where 0.675 fits.
const EXCESS: f64 = 0.09;
const LEAST_EXCESS: f64 = 0.015;
const MOST_EXCESS: f64 = 0.1;
/// Relief: the worst wedged grains are left out, this share of the volume per radius of the smallest grain that a
/// body lacks, because a jam's energy grows with the square of the excess volume. The next relief takes twice the
/// last, within these bounds.
const RELIEF: f64 = 0.3;
const LEAST_RELIEF: f64 = 0.004;
const MOST_RELIEF: f64 = 0.02;

/// Damping of a run.
#[derive(Clone, Copy)]
pub(super) struct Damping {
    /// Share of the container's volume that is taken, gaps included; fibres count for more.
    crowding: f64,
    /// Share taken of the volume within the rims along the walls, which are as wide as a small grain's radius and
    /// hold hardly any grain; fibres count as they are.
    within_rims: f64,
    /// Lower bound of the momentum after a jam.
    least: f64,
    /// Too little time is left for slow damping.
    is_hurried: bool,
    /// Share of the volume left out the last time, or 0; a relieved run needs no slower damping.
    relief: f64,
}

impl Damping {
    /// For the grains of `task`, the smallest as large as a ball of this `radius` (mm).
    pub(super) fn new(task: &Task, radius: f64) -> Self {
        let rim = radius + task.request.placement.wall_gap_mm;
        let within_rims = crowding(task, |_| 1.0) / within(task, rim);
        Self { crowding: crowding(task, fibres::weight), within_rims, least: 0.0, is_hurried: false, relief: 0.0 }
    }

    /// Share of a sweep's movement carried over to the next.
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

    /// From now on damps as fast as possible.
    pub(super) fn hurry(&mut self) {
        self.is_hurried = true;
    }

    /// Sweeps without progress after which a run is jammed.
    pub(super) fn patience(&self) -> u32 {
        (PATIENCE * ((1.0 - QUICK) / (1.0 - self.momentum())).max(1.0)) as u32
    }

    /// The next attempt's damping after a jam, where slower damping may help. `lack` is the root mean square of the
    /// bodies' residual overlaps, over the radius of the smallest grain.
    pub(super) fn next(&self, lack: f64) -> Option<Self> {
        let motion_lost = 1.0 - self.momentum();
        let is_hopeful = lack < HOPEFUL && motion_lost > NOTABLY * (1.0 - SLOWEST) && self.is_slow();
        is_hopeful.then_some(Self { least: (1.0 - motion_lost / SLOWER).max(QUICK), ..*self })
    }

    /// Excess share of the volume in a jam with this `lack`, where a restart with less is worth its time, and the
    /// damping of that restart.
    pub(super) fn fewer(&self, lack: f64) -> Option<(f64, Self)> {
        let excess = (EXCESS * lack.sqrt()).min(MOST_EXCESS);
        let rest = 1.0 - excess;
        let damping = Self { crowding: self.crowding * rest, within_rims: self.within_rims * rest, ..*self };
        (excess >= LEAST_EXCESS && self.is_slow()).then_some((excess, damping))
    }

    /// Share of the volume to leave out of a jam with this `lack`.
    pub(super) fn relieve(&mut self, lack: f64) -> f64 {
        self.relief = (RELIEF * lack).max(2.0 * self.relief).clamp(LEAST_RELIEF, MOST_RELIEF);
        self.crowding *= 1.0 - self.relief;
        self.relief
    }
}

/// Share of the container's volume that the grains take with half of the least gap around each, weighted by `weight`.
fn crowding(task: &Task, weight: impl Fn(&Grain) -> f64) -> f64 {
    let half_gap = task.request.placement.min_gap_mm / 2.0;
    let grown = |grain: &Grain| {
        let scale = 1.0 + half_gap / grain.ball_radius();
        grain.volume() * (scale * scale * scale) * weight(grain)
    };
    task.request.grains.iter().map(grown).sum::<f64>() / task.volume
}

/// Share of the volume farther than `rim` mm from the walls, computed for the bounding box: a container as long and
/// as wide all over has as much surface for its volume.
fn within(task: &Task, rim: f64) -> f64 {
    let size = task.container.aabb().size();
    let walled = (0..3).filter(|&axis| task.period.along(axis).is_none());
    walled.map(|axis| (1.0 - 2.0 * rim / size[axis]).max(0.5)).product()
}
