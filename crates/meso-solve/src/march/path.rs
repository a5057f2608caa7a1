//! The path of a test over its time: straight on, or through the turns of its history.

use meso_trial::Test;
use meso_trial::{Turn, TurnOf};

/// The path of the supports, mm; it grows in the test's own sense.
#[derive(Clone, Debug)]
pub(crate) struct Path {
    /// Speed once the ramp is over, mm/s.
    pub(crate) speed: f64,
    /// Length of the ramp, s; a turn brakes and gains speed as long.
    pub(crate) ramp_s: f64,
    /// Time before the path begins, in which loads grow, s.
    pub(crate) lead_s: f64,
    /// Path over this is the strain, mm.
    pub(crate) length_mm: f64,
    /// The farthest that a leg may go without reaching its turn, mm.
    pub(crate) limit_mm: f64,
    /// Where it turns; none where it goes straight on.
    pub(crate) turns: Vec<Turn>,
}

/// The way from one turn to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Leg {
    /// Its number among the turns, from 0.
    pub(crate) number: usize,
    /// Time since it began, s at full speed.
    pub(crate) time: f64,
    /// Time at which it ends, s; infinite where its turn is not yet known.
    pub(crate) end: f64,
    /// Speed between its ramps, mm/s.
    pub(crate) speed: f64,
    /// What was measured where it began, and its place on the path there.
    pub(crate) from: [f64; 2],
}

impl Leg {
    /// The numbers that a checkpoint stores.
    pub(crate) const fn values(&self) -> [f64; 6] {
        [self.number as f64, self.time, self.end, self.speed, self.from[0], self.from[1]]
    }

    /// The leg after it, which has not begun.
    fn next(&self) -> Self {
        Self { number: self.number + 1, ..Self::default() }
    }

    /// The leg of numbers that [`values`](Self::values) gave.
    pub(crate) const fn from_values([number, time, end, speed, reading, travel]: [f64; 6]) -> Self {
        Self { number: number as usize, time, end, speed, from: [reading, travel] }
    }
}

/// 3 s^2 - 2 s^3 of a share, which is taken between 0 and 1.
pub(crate) fn smooth(share: f64) -> f64 {
    let s = share.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// 35 s^4 - 84 s^5 + 70 s^6 - 20 s^7 of a share below 1: three derivatives vanish at both ends, so that hardly a vibration
/// remains.
fn smoother(s: f64) -> f64 {
    s.powi(4) * (35.0 - s * (84.0 - s * (70.0 - 20.0 * s)))
}

/// Share of the full speed from which a smooth stop takes the share `rest` of the way that it takes from full speed: with
/// s = t / T to the end, `rest` = 2 s^3 - s^4. It never falls below a hundredth, so that a leg comes to its end.
fn slowed(rest: f64) -> f64 {
    let rest = rest.clamp(1e-9, 1.0);
    let mut s = libm::cbrt(rest);
    for _ in 0..4 {
        s -= (s * s * s * (2.0 - s) - rest) / (s * s * (6.0 - 4.0 * s));
    }
    smooth(s).max(0.01)
}

impl Path {
    /// The path of a test that lasts `duration_s`, over this length, after a lead.
    pub(crate) fn new(test: &Test, length_mm: f64, duration_s: f64, lead_s: f64) -> Self {
        let (ramp_s, limit_mm) = (test.ramp * duration_s, test.strain() * length_mm);
        let speed = if test.has_path() { limit_mm / (duration_s - 0.5 * ramp_s) } else { 0.0 };
        Self { speed, ramp_s, lead_s, length_mm, limit_mm, turns: test.turns() }
    }

    /// Speed of a straight path at the time `t`, mm/s: it grows smoothly along the ramp, then it is constant.
    pub(crate) fn straight(&self, t: f64) -> f64 {
        let s = ((t - self.lead_s) / self.ramp_s).clamp(0.0, 1.0);
        self.speed * s * s * (3.0 - 2.0 * s)
    }

    /// Share of the way that a straight path has gone after the time `t`; none for paths with turns, and where the path begins
    /// after a lead or goes nowhere.
    pub(crate) fn gone(&self, t: f64) -> Option<f64> {
        let is_straight = self.turns.is_empty() && self.lead_s == 0.0 && self.speed > 0.0;
        let s = (t / self.ramp_s).min(1.0);
        let ramp = self.ramp_s * s * s * s * (1.0 - 0.5 * s);
        is_straight.then(|| self.speed * (ramp + (t - self.ramp_s).max(0.0)) / self.limit_mm)
    }

    /// Whether the path has just begun at the time `t`: the specimen is sound until a quarter of the ramp, which goes 0.5 % of
    /// the way.
    pub(crate) fn begins(&self, t: f64) -> bool {
        t < self.lead_s + 0.25 * self.ramp_s
    }

    /// Share of the loads at the time `t`.
    pub(crate) fn share(&self, t: f64) -> f64 {
        if t < self.lead_s { smoother(t / self.lead_s) } else { 1.0 }
    }

    /// Whether the path has come through its last turn.
    pub(crate) fn is_through(&self, leg: &Leg) -> bool {
        leg.number >= self.turns.len()
    }

    /// Speed of a step of `step_s` along a path with turns, mm/s, at the place `travel`; `reading` gives what is measured.
    pub(crate) fn turning(&self, leg: &mut Leg, travel: f64, step_s: f64, reading: impl Fn(TurnOf) -> f64) -> f64 {
        let Some(turn) = self.turns.get(leg.number) else { return 0.0 };
        if leg.time == 0.0 {
            self.begin(leg, turn, travel, reading(turn.of));
        }
        let middle = leg.time + 0.5 * step_s;
        leg.time += step_s;
        if leg.end.is_finite() {
            let speed = leg.speed * smooth(middle / self.ramp_s) * smooth((leg.end - middle) / self.ramp_s);
            if leg.time >= leg.end {
                *leg = leg.next();
            }
            return speed;
        }
        let rest = self.rest(leg, turn.at, travel, reading(turn.of));
        if rest <= 0.0 {
            *leg = leg.next();
            return 0.0;
        }
        leg.speed * smooth(middle / self.ramp_s).min(slowed(rest / (0.5 * self.ramp_s * self.speed)))
    }

    /// Way that a leg has before it, mm, to end where `at` is measured: it follows from the way so far and what was measured
    /// on it. The path's limit ends a leg at the latest.
    fn rest(&self, leg: &Leg, at: f64, travel: f64, reading: f64) -> f64 {
        let sense = leg.speed.signum();
        let [from, began] = leg.from;
        let (way, so_far) = (sense * (travel - began), (reading - from) / (at - from));
        let rest = way.max(f64::MIN_POSITIVE) * (1.0 / so_far.max(f64::MIN_POSITIVE) - 1.0);
        if so_far >= 1.0 { 0.0 } else { rest.min(self.limit_mm - sense * travel) }
    }

    /// Sets the speed of a leg, and its end where the path is measured. A short leg is slower, so that both ramps fit.
    fn begin(&self, leg: &mut Leg, turn: &Turn, travel: f64, reading: f64) {
        leg.from = [reading, travel];
        if turn.of != TurnOf::Strain {
            (leg.speed, leg.end) = (self.speed * (turn.at - reading).signum(), f64::INFINITY);
            return;
        }
        let way = turn.at * self.length_mm - travel;
        let speed = self.speed.min(way.abs() / self.ramp_s).max(f64::MIN_POSITIVE);
        (leg.speed, leg.end) = (speed * way.signum(), way.abs() / speed + self.ramp_s);
    }

    /// Steps of the whole test at full speed, where a straight path takes `straight`.
    pub(crate) fn steps(&self, straight: u64, dt: f64) -> u64 {
        let lead = (self.lead_s / dt).ceil() as u64;
        lead + if self.turns.is_empty() { straight } else { (self.legs_s() / dt).ceil() as u64 }
    }

    /// Time of all legs at full speed, s. A leg whose turn is no strain counts as long as the way to the limit, or back.
    pub(crate) fn legs_s(&self) -> f64 {
        let (mut time, mut at) = (0.0, 0.0_f64);
        for turn in &self.turns {
            let known = turn.of == TurnOf::Strain;
            let to = if known { turn.at * self.length_mm } else { self.limit_mm * f64::from(turn.at != 0.0) };
            time += (to - at).abs() / self.speed + self.ramp_s;
            at = to;
        }
        time
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path(turns: &[(f64, TurnOf)]) -> Path {
        let turns = turns.iter().map(|&(at, of)| Turn { at, of }).collect();
        Path { speed: 8.0, ramp_s: 0.5, lead_s: 0.0, length_mm: 10.0, limit_mm: 30.0, turns }
    }

    /// Places at which the path turns, where a spring of `k` MPa per mm of path gives the stress.
    fn turned_at(path: &Path, k: f64) -> Vec<f64> {
        let (mut leg, mut travel, mut at) = (Leg::default(), 0.0, Vec::new());
        let dt = 1e-4;
        while !path.is_through(&leg) {
            let number = leg.number;
            let read = |of| if of == TurnOf::Stress { k * travel } else { travel / path.length_mm };
            travel += dt * path.turning(&mut leg, travel, dt, read);
            if leg.number > number {
                at.push(travel);
            }
        }
        at
    }

    #[test]
    fn the_ramp_begins_and_ends_without_a_jerk() {
        let speed = |t: f64| path(&[]).straight(t);
        assert!([speed(0.0), speed(0.25), speed(0.5), speed(7.0)] == [0.0, 4.0, 8.0, 8.0]);
        assert!(speed(0.005) < 8.0 * 3e-4 && speed(0.495) > 8.0 * (1.0 - 3e-4));
    }

    #[test]
    fn a_path_turns_where_its_strains_say() {
        let strain = |at| (at, TurnOf::Strain);
        // The last legs are shorter than two ramps at full speed.
        let path = path(&[strain(2.0), strain(0.5), strain(0.6), strain(0.6 - 1e-3)]);
        let places = turned_at(&path, 1.0);
        for (place, expected) in places.iter().zip([20.0, 5.0, 6.0, 5.99]) {
            assert!((place - expected).abs() < 2e-3, "{places:?}");
        }
        assert_eq!(places.len(), 4);
    }

    #[test]
    fn a_path_turns_at_a_stress_and_at_its_limit_at_the_latest() {
        let stress = |at| (at, TurnOf::Stress);
        // The legs from 1 to 0.4 and to 0.5 are shorter than two ramps.
        let path = path(&[12.0, 1.0, 0.4, 0.5, 1e6].map(stress));
        let places = turned_at(&path, 2.0);
        for (place, expected) in places.iter().zip([6.0, 0.5, 0.2, 0.25, 30.0]) {
            assert!((place - expected).abs() < 2e-3, "{places:?}");
        }
        assert_eq!(places.len(), 5);
    }

    #[test]
    fn a_stop_slows_down_as_its_smooth_curve_does() {
        for s in [0.1, 0.4, 0.8, 1.0_f64] {
            assert!((slowed(s.powi(3) * (2.0 - s)) - smooth(s)).abs() < 1e-6, "{s}");
        }
        assert_eq!((slowed(7.0), slowed(0.0)), (1.0, 0.01));
    }
}
