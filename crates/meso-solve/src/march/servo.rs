//! The servo of a test: the plates slow down while the specimen breaks.
//!
//! A cracking specimen releases elastic energy. The part that its cracks do not dissipate becomes kinetic energy. The servo
//! of a testing machine holds its plates back then, and so does this one, in two ways:
//!
//! 1. Plates slow down where the elastic energy falls steeply over their way: a snap is taken slowly, a tail at full speed. The
//!    fall belongs to the specimen's curve, so that the speed does not act back on it.
//! 2. If cracks spend far more than the plates supply nevertheless, the plates slow down with the square of the rate.
//!
//! A control by a gauge takes the place of the first: the plates move so fast that the gauge moves as fast as it did while
//! the specimen was sound.
//!
//! Elastic energy grows until the peak, and until then the plates keep their speed. `benches/results/servo_pace.csv` has the
//! rules that were tried.

/// Fall of the elastic energy beyond which the plates slow down: largest elastic energies over the way of the test.
const SNAP: f64 = 2.0;
/// Least share of the speed in a snap.
const SNAPPING: f64 = 0.1;
/// Way over which the fall is a mean, over that of the test.
const WAY: f64 = 0.002;
/// Rate of release beyond which the plates are held: largest elastic energies per duration of the test.
const COLLAPSE: f64 = 2.5;
/// Least share of the speed.
const SLOWEST: f64 = 0.02;
/// Time constant of the plates' speed, over the duration of the test: a tenth of a sound wave's way through a cube.
const LAG: f64 = 0.001;
/// Time constant of the mean of the plates' power, over the duration of the test: a sound wave's way through a cube.
const MEAN: f64 = 0.01;

/// Time constant of the mean motion of a gauge, over the duration of the test: five periods of a beam. A beam
/// swings undamped; a servo that follows its every swing drives it.
const SWING: f64 = 0.1;

/// Follows the gauge that a test is controlled by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Follower {
    /// Value of the gauge after the last step.
    last: f64,
    /// Mean changes of the gauge and of the path in a step, mm.
    changes: [f64; 2],
    /// Change of the gauge per mm of the path while the specimen is sound.
    usual: f64,
}

impl Follower {
    /// The state of numbers that [`values`](Self::values) gave.
    pub(crate) const fn from_values([last, gauge, path, usual]: [f64; 4]) -> Self {
        Self { last, changes: [gauge, path], usual }
    }

    /// The numbers that a checkpoint stores.
    pub(crate) const fn values(&self) -> [f64; 4] {
        [self.last, self.changes[0], self.changes[1], self.usual]
    }

    /// Takes in a step of a test of `steps`: the gauge's value after it, the place on the path and its change. While the
    /// specimen `is_sound`, the usual motion is learnt.
    ///
    /// Returns the share of the speed at which the gauge keeps its usual rate.
    pub(crate) fn follow(&mut self, value: f64, [travel, moved]: [f64; 2], is_sound: bool, steps: f64) -> f64 {
        let change = value - std::mem::replace(&mut self.last, value);
        for (mean, now) in self.changes.iter_mut().zip([change, moved]) {
            *mean += (now - *mean) * within(SWING, steps);
        }
        if is_sound {
            self.usual = if travel > 0.0 { value / travel } else { 0.0 };
            return 1.0;
        }
        let [gauge, path] = self.changes;
        let (ahead, usual) = (gauge * self.usual.signum(), (self.usual * path).abs());
        if ahead > usual { (usual / ahead).max(SLOWEST) } else { 1.0 }
    }
}

/// The servo's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Servo {
    /// Speed of the plates over that without a servo.
    pub(crate) pace: f64,
    /// Largest elastic energy so far, mJ.
    most: f64,
    /// Mean work of the plates in a step, mJ.
    supply: f64,
    /// Elastic energy, mJ.
    stored: f64,
    /// How fast it falls without the plates' pull, as a mean over [`WAY`], mJ for the way of the test.
    fall: f64,
}

impl Servo {
    /// The state of numbers that [`values`](Self::values) gave.
    pub(crate) const fn from_values([pace, most, supply, stored, fall]: [f64; 5]) -> Self {
        Self { pace, most, supply, stored, fall }
    }

    /// The numbers that a checkpoint stores.
    pub(crate) const fn values(&self) -> [f64; 5] {
        [self.pace, self.most, self.supply, self.stored, self.fall]
    }

    /// Lowers the largest elastic energy by the energy that the specimen gives back to its supports: unloading is no softening.
    pub(crate) fn give_back(&mut self) {
        self.most += self.supply.min(0.0);
    }

    /// Takes the energy `stored` after a step that it does not follow, mJ: phases that grow work against the plates, so that the
    /// path begins below nothing.
    pub(crate) fn rest(&mut self, stored: f64) {
        (self.stored, self.most) = (stored, self.most.max(stored.abs()));
    }

    /// What devices need to follow a test of `steps`: [`COLLAPSE`], [`SLOWEST`], the shares within [`LAG`] and [`MEAN`],
    /// [`SNAP`], [`SNAPPING`] and the way of a mean.
    pub(crate) fn rule(steps: f64) -> [f64; 7] {
        [COLLAPSE, SLOWEST, within(LAG, steps), within(MEAN, steps), SNAP, SNAPPING, mean_way(steps)]
    }

    /// Follows a step of a test of `steps`: the elastic energy `stored` after it, the energy that cracks `spent` and the work
    /// that the plates `supplied` in it, mJ. A control by a gauge gives the share of the speed that it `allows`.
    ///
    /// A release at twice the rate of [`COLLAPSE`] gives a quarter of the speed, a fall of twice [`SNAP`] half of it.
    pub(crate) fn follow(&mut self, [stored, spent, supplied]: [f64; 3], allows: Option<f64>, steps: f64) {
        self.most = self.most.max(stored);
        self.supply += (supplied - self.supply) * within(MEAN, steps);
        // Energy that returns to the plates without a crack is vibration.
        let released = (spent - self.supply.max(0.0)) * steps;
        let most = COLLAPSE * self.most;
        let held = if released > most { (most / released).powi(2).max(SLOWEST) } else { 1.0 };
        // What returns to the plates is no fall.
        let fell = self.stored - stored + supplied.min(0.0);
        self.stored = stored;
        self.fall += (fell - self.fall * (self.pace / steps)) / mean_way(steps);
        let usual = SNAP * self.most;
        let snaps = if self.fall > usual { (usual / self.fall).max(SNAPPING) } else { 1.0 };
        self.pace += (held.min(allows.unwrap_or(snaps)) - self.pace) * within(LAG, steps);
    }
}

/// Way of a mean, over that of a test of `steps`: one step at least.
fn mean_way(steps: f64) -> f64 {
    WAY.max(1.0 / steps)
}

/// Share of a way that a time constant, over the duration of a test of `steps`, lets a step go.
fn within(share: f64, steps: f64) -> f64 {
    (1.0 / (share * steps)).min(1.0)
}

impl Default for Servo {
    /// Full speed.
    fn default() -> Self {
        Self { pace: 1.0, most: 0.0, supply: 0.0, stored: 0.0, fall: 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEPS: f64 = 3000.0;

    /// The pace after `count` steps in which a specimen, whose largest elastic energy is 8 mJ, has 8 `share` left, and
    /// releases `released` mJ per duration of the test.
    fn pace(share: f64, released: f64, count: u32) -> f64 {
        let mut servo = Servo::default();
        servo.follow([8.0, 0.0, 0.0], None, STEPS);
        (0..count).for_each(|_| servo.follow([8.0 * share, released / STEPS, 0.0], None, STEPS));
        servo.pace
    }

    #[test]
    fn the_pace_falls_with_the_square_of_the_release_and_not_below_its_least() {
        assert_eq!((pace(1.0, 0.0, 500), pace(1.0, 19.9, 500)), (1.0, 1.0));
        for (released, expected) in [(40.0, 0.25), (80.0, 0.0625), (1e3, SLOWEST), (f64::INFINITY, SLOWEST)] {
            assert!((pace(1.0, released, 500) - expected).abs() < 1e-12, "{released}: {}", pace(1.0, released, 500));
        }
    }

    /// The case: plates stayed at a fifth of the speed for two thirds of a test, whose kinetic energy was 2e-5 of its
    /// internal energy.
    #[test]
    fn a_tail_goes_at_full_speed_and_a_snap_the_slower_the_steeper_it_falls() {
        let pace = |fall: f64| {
            let (mut servo, mut stored) = (Servo::default(), 8.0);
            for _ in 0..500 {
                servo.follow([stored, 0.0, 0.0], None, STEPS);
                stored -= 8.0 * fall * servo.pace / STEPS;
            }
            servo.pace
        };
        assert_eq!([pace(-3.0), pace(0.5), pace(1.99)], [1.0; 3]);
        for (fall, expected) in [(4.0, 0.5), (8.0, 0.25), (40.0, SNAPPING)] {
            assert!((pace(fall) - expected).abs() < 1e-3, "{fall}: {}", pace(fall));
        }
    }

    #[test]
    fn the_plates_follow_within_the_lag() {
        // Three steps are the lag: the remaining way is 2/3 after one step, and 8/27 after three.
        let way = |count| (pace(1.0, 1e9, count) - SLOWEST) / (1.0 - SLOWEST);
        assert!((way(1) - 2.0 / 3.0).abs() < 1e-12 && (way(3) - 8.0 / 27.0).abs() < 1e-12, "{} {}", way(1), way(3));
    }

    /// Share of the speed after a gauge went `slope` times as fast as usual for a tenth of a test, swinging about its way.
    fn allowed(slope: f64) -> f64 {
        let (mut follower, mut value, mut share) = (Follower::default(), 0.0, 1.0);
        for step in 1..=1500 {
            let is_sound = step <= 1000;
            value += if is_sound { 0.5 } else { 0.5 * slope };
            let swing = 3.0 * f64::from(step).sin();
            share = follower.follow(value + swing, [f64::from(step), 1.0], is_sound, STEPS);
        }
        share
    }

    #[test]
    fn a_gauge_that_goes_faster_than_in_a_sound_specimen_slows_the_plates() {
        assert_eq!([allowed(0.5), allowed(-5.0)], [1.0; 2]);
        for slope in [2.0, 5.0, 20.0] {
            // The mean of 300 steps has forgotten all but a fifth of the sound steps.
            let mean = slope + (1.0 - slope) * (-500.0_f64 / 300.0).exp();
            assert!((allowed(slope) * mean - 1.0).abs() < 0.02, "{slope}: {}", allowed(slope));
        }
        assert_eq!(allowed(1e4), SLOWEST);
    }

    #[test]
    fn the_servo_takes_the_share_that_a_gauge_allows() {
        let mut servo = Servo::default();
        (0..500).for_each(|_| servo.follow([4.0, 0.0, 0.0], Some(0.3), STEPS));
        assert!((servo.pace - 0.3).abs() < 1e-12, "{}", servo.pace);
    }

    #[test]
    fn vibration_is_no_release() {
        // With and without cracks that the plates' mean power feeds.
        for (spent, supplied) in [(0.0, [9.0, -9.0]), (0.1, [0.25, -0.05])] {
            let mut servo = Servo::default();
            (0..300).for_each(|i| servo.follow([8.0, 0.0, supplied[i % 2]], None, STEPS));
            (0..500).for_each(|i| servo.follow([8.0, spent, supplied[i % 2]], None, STEPS));
            assert_eq!(servo.pace, 1.0, "{spent}");
        }
    }
}
