//! The servo of a test: the plates slow down while the specimen breaks.
//!
//! A cracking specimen releases elastic energy. The part that its cracks do not dissipate becomes kinetic energy. The
//! servo of a testing machine holds its plates back then, and so does this one, in two ways:
//!
//! 1. While the elastic energy falls, the plates move at a part of their speed. The transition is smooth: plates that
//!    stop suddenly send waves through the specimen, and its curve descends in stairs.
//! 2. If the specimen collapses nevertheless, they almost stop.
//!
//! Elastic energy grows until the peak, and until then the plates keep their speed. The constants were chosen among 17
//! rules (`benches/results/servo_rules.csv`).

/// Share of the speed while the specimen softens.
const SOFTENING: f64 = 0.2;
/// Shares of the largest elastic energy between which the plates slow down to that speed.
const SLOWING: [f64; 2] = [0.99, 0.94];
/// Shares of the largest elastic energy between which the plates return to full speed.
const RECOVERING: [f64; 2] = [0.2, 0.1];
/// Rate of release beyond which the plates are held: largest elastic energies per duration of the test.
const COLLAPSE: f64 = 2.5;
/// Least share of the speed.
const SLOWEST: f64 = 0.02;
/// Time constant of the plates' speed, over the duration of the test: a tenth of a sound wave's way through a cube.
const LAG: f64 = 0.001;
/// Time constant of the mean of the plates' power, over the duration of the test: a sound wave's way through a cube.
const MEAN: f64 = 0.01;

/// The servo's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Servo {
    /// Speed of the plates over that without a servo.
    pub(crate) pace: f64,
    /// Largest elastic energy so far, mJ.
    most: f64,
    /// Mean work of the plates in a step, mJ.
    supply: f64,
}

impl Servo {
    /// The state of numbers that [`values`](Self::values) gave.
    pub(crate) const fn from_values([pace, most, supply]: [f64; 3]) -> Self {
        Self { pace, most, supply }
    }

    /// The numbers that a checkpoint stores.
    pub(crate) const fn values(&self) -> [f64; 3] {
        [self.pace, self.most, self.supply]
    }

    /// Lowers the largest elastic energy by the energy that the specimen gives back to its supports: unloading is no softening.
    pub(crate) fn give_back(&mut self) {
        self.most += self.supply.min(0.0);
    }

    /// What devices need to follow a test of `steps`: [`SLOWING`], [`RECOVERING`], [`SOFTENING`], [`COLLAPSE`], [`SLOWEST`], and
    /// the shares within [`LAG`] and [`MEAN`].
    pub(crate) fn rule(steps: f64) -> [f64; 9] {
        let ([a, b], [c, d]) = (SLOWING, RECOVERING);
        [a, b, c, d, SOFTENING, COLLAPSE, SLOWEST, within(LAG, steps), within(MEAN, steps)]
    }

    /// Follows a step of a test of `steps`: the elastic energy `stored` after it, the energy that cracks `spent` and the work
    /// that the plates `supplied` in it, mJ.
    ///
    /// A release at twice the rate of [`COLLAPSE`] gives a quarter of the speed.
    pub(crate) fn follow(&mut self, stored: f64, spent: f64, supplied: f64, steps: f64) {
        self.most = self.most.max(stored);
        self.supply += (supplied - self.supply) * within(MEAN, steps);
        // Energy that returns to the plates without a crack is vibration.
        let released = (spent - self.supply.max(0.0)) * steps;
        let share = if self.most > 0.0 { stored / self.most } else { 1.0 };
        let softens = passed(share, SLOWING) * (1.0 - passed(share, RECOVERING));
        let most = COLLAPSE * self.most;
        let held = if released > most { (most / released).powi(2).max(SLOWEST) } else { 1.0 };
        let wanted = held.min(1.0 - (1.0 - SOFTENING) * softens);
        self.pace += (wanted - self.pace) * within(LAG, steps);
    }
}

/// Share of a way that a time constant, over the duration of a test of `steps`, lets a step go.
fn within(share: f64, steps: f64) -> f64 {
    (1.0 / (share * steps)).min(1.0)
}

/// How far a share that falls has come `from` one value `to` another, 0 to 1, without a kink.
fn passed(share: f64, [from, to]: [f64; 2]) -> f64 {
    let way = ((from - share) / (from - to)).clamp(0.0, 1.0);
    way * way * (3.0 - 2.0 * way)
}

impl Default for Servo {
    /// Full speed.
    fn default() -> Self {
        Self { pace: 1.0, most: 0.0, supply: 0.0 }
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
        servo.follow(8.0, 0.0, 0.0, STEPS);
        (0..count).for_each(|_| servo.follow(8.0 * share, released / STEPS, 0.0, STEPS));
        servo.pace
    }

    #[test]
    fn the_pace_falls_with_the_square_of_the_release_and_not_below_its_least() {
        assert_eq!((pace(1.0, 0.0, 500), pace(1.0, 19.9, 500)), (1.0, 1.0));
        for (released, expected) in [(40.0, 0.25), (80.0, 0.0625), (1e3, SLOWEST), (f64::INFINITY, SLOWEST)] {
            assert!((pace(1.0, released, 500) - expected).abs() < 1e-12, "{released}: {}", pace(1.0, released, 500));
        }
    }

    #[test]
    fn a_specimen_that_softens_goes_at_a_part_of_the_speed_until_its_store_is_spent() {
        for (share, expected) in [(1.0, 1.0), (0.99, 1.0), (0.965, 0.6), (0.94, 0.2), (0.5, 0.2), (0.2, 0.2)] {
            assert!((pace(share, 0.0, 500) - expected).abs() < 1e-12, "{share}: {}", pace(share, 0.0, 500));
        }
        assert!((pace(0.15, 0.0, 500) - 0.6).abs() < 1e-12 && (pace(0.1, 0.0, 500) - 1.0).abs() < 1e-12);
        // The slower of the two counts.
        assert!((pace(0.5, 80.0, 500) - 0.0625).abs() < 1e-12 && (pace(0.5, 22.0, 500) - 0.2).abs() < 1e-12);
    }

    #[test]
    fn the_plates_follow_within_the_lag() {
        // Three steps are the lag: the remaining way is 2/3 after one step, and 8/27 after three.
        let way = |count| (pace(1.0, 1e9, count) - SLOWEST) / (1.0 - SLOWEST);
        assert!((way(1) - 2.0 / 3.0).abs() < 1e-12 && (way(3) - 8.0 / 27.0).abs() < 1e-12, "{} {}", way(1), way(3));
    }

    #[test]
    fn vibration_is_no_release() {
        // With and without cracks that the plates' mean power feeds.
        for (spent, supplied) in [(0.0, [9.0, -9.0]), (0.1, [0.25, -0.05])] {
            let mut servo = Servo::default();
            (0..300).for_each(|i| servo.follow(8.0, 0.0, supplied[i % 2], STEPS));
            (0..500).for_each(|i| servo.follow(8.0, spent, supplied[i % 2], STEPS));
            assert_eq!(servo.pace, 1.0, "{spent}");
        }
    }
}
