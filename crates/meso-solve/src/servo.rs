//! The servo of a test: the plates slow down while the specimen breaks.
//!
//! A specimen that cracks gives back elastic energy. What its cracks do not spend of that becomes motion, the more so the
//! faster it is given back. A testing machine with a servo holds its plates back then, and so does this one, in two ways.
//! While the store shrinks the plates go at a part of their speed, to which they come smoothly: plates that stop at once
//! send waves through the specimen, and its curve goes down in stairs. Where it collapses nevertheless they nearly stand.
//! Before the peak the store grows, and the plates keep their speed.

/// Share of the speed while the specimen softens.
const SOFTENING: f64 = 0.4;
/// Shares of the largest store between which the plates come to that speed.
const SLOWING: [f64; 2] = [0.99, 0.94];
/// Those between which they leave it.
const RECOVERING: [f64; 2] = [0.2, 0.1];
/// Largest stores that a specimen may release in the time of the test, before the plates are held.
const COLLAPSE: f64 = 1.5;
/// Share of the speed that is always left.
const SLOWEST: f64 = 0.02;
/// Time in which the plates follow, over that of the test: a third of a sound wave's way through a cube at the usual
/// speed.
const LAG: f64 = 0.003;
/// Time over which the plates' power is a mean, over that of the test: a sound wave's way through a cube.
const MEAN: f64 = 0.01;

/// The servo's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Servo {
    /// Speed of the plates over that without a servo.
    pub(crate) pace: f64,
    /// The most that the specimen has stored, mJ.
    most: f64,
    /// Mean of what the plates supply in a step, mJ.
    supply: f64,
}

impl Servo {
    /// The state of numbers that [`values`](Self::values) gave.
    pub(crate) const fn from_values([pace, most, supply]: [f64; 3]) -> Self {
        Self { pace, most, supply }
    }

    /// What a checkpoint holds.
    pub(crate) const fn values(&self) -> [f64; 3] {
        [self.pace, self.most, self.supply]
    }

    /// Takes in a step of a test of `steps`: what the specimen has `stored` after it, what cracks `spent` and what the plates
    /// `supplied` in it, mJ.
    ///
    /// A specimen that releases twice as much as [`COLLAPSE`] allows goes at a quarter of the speed.
    pub(crate) fn follow(&mut self, stored: f64, spent: f64, supplied: f64, steps: f64) {
        self.most = self.most.max(stored);
        let within = |share: f64| (1.0 / (share * steps)).min(1.0);
        self.supply += (supplied - self.supply) * within(MEAN);
        // What comes back to the plates without a crack is vibration.
        let released = (spent - self.supply.max(0.0)) * steps;
        let share = if self.most > 0.0 { stored / self.most } else { 1.0 };
        let softens = passed(share, SLOWING) * (1.0 - passed(share, RECOVERING));
        let most = COLLAPSE * self.most;
        let held = if released > most { (most / released).powi(2).max(SLOWEST) } else { 1.0 };
        let wanted = held.min(1.0 - (1.0 - SOFTENING) * softens);
        self.pace += (wanted - self.pace) * within(LAG);
    }
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

    const STEPS: f64 = 1000.0;

    /// The pace after `count` steps in which a specimen that has stored 8 mJ has 8 `share` left, and releases `released`
    /// mJ a test.
    fn pace(share: f64, released: f64, count: u32) -> f64 {
        let mut servo = Servo::default();
        servo.follow(8.0, 0.0, 0.0, STEPS);
        (0..count).for_each(|_| servo.follow(8.0 * share, released / STEPS, 0.0, STEPS));
        servo.pace
    }

    #[test]
    fn the_pace_falls_with_the_square_of_the_release_and_not_below_its_least() {
        assert_eq!((pace(1.0, 0.0, 500), pace(1.0, 11.9, 500)), (1.0, 1.0));
        for (released, expected) in [(24.0, 0.25), (48.0, 0.0625), (1e3, SLOWEST), (f64::INFINITY, SLOWEST)] {
            assert!((pace(1.0, released, 500) - expected).abs() < 1e-12, "{released}: {}", pace(1.0, released, 500));
        }
    }

    #[test]
    fn a_specimen_that_softens_goes_at_a_part_of_the_speed_until_its_store_is_spent() {
        for (share, expected) in [(1.0, 1.0), (0.99, 1.0), (0.965, 0.7), (0.94, 0.4), (0.5, 0.4), (0.2, 0.4)] {
            assert!((pace(share, 0.0, 500) - expected).abs() < 1e-12, "{share}: {}", pace(share, 0.0, 500));
        }
        assert!((pace(0.15, 0.0, 500) - 0.7).abs() < 1e-12 && (pace(0.1, 0.0, 500) - 1.0).abs() < 1e-12);
        // The slower of the two counts.
        assert!((pace(0.5, 24.0, 500) - 0.25).abs() < 1e-12 && (pace(0.5, 13.0, 500) - 0.4).abs() < 1e-12);
    }

    #[test]
    fn the_plates_follow_within_the_lag() {
        // Three steps of a thousand are the lag: what is left of the way is 2/3 after one step, and 8/27 after three.
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
