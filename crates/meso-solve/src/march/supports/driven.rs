//! Plates in real time. A plate of a bar or a mass has one speed, and its force is that of all nodes that it meets.
//!
//! Its speed w after a step, towards the specimen, is the root of Z (2 v_i - (w0 + w) / 2) - M (w - w0) / dt = sum m / dt
//! (w - b)+: Z is the bar's impedance, M the mass, and b the speed beyond which the plate pushes a node of mass m. The left
//! side falls and the right side grows, so there is one root, which Newton's steps reach in as many as nodes change sides.
//! So momentum is kept to the last bit, and no penalty, filter or artificial mass comes between bar and specimen.

use crate::march::supports::contact::Contact;
use crate::march::supports::{Fixture, Held, Supports};
use meso_trial::{Drive, MOST_SUPPORTS, Rule, Speed};

/// Steps of Newton at most; some three are usual.
const MOST: usize = 100;

/// A plate in real time and the nodes that it can meet.
#[derive(Clone, Debug)]
pub(crate) struct Driven {
    pub(crate) drive: Drive,
    /// Its speed, or that of the wave of its bar where it meets the specimen.
    speed: Speed,
    /// The speed of largest size that it gives, mm/s towards the specimen.
    pub(crate) fastest: f64,
    /// Impedance of its bar, tonne/s; 0 without one.
    impedance: f64,
    /// Section of its bar, mm2.
    pub(crate) area_mm2: f64,
    /// Its own mass, tonne.
    mass: f64,
    contacts: Vec<Contact>,
}

impl Driven {
    /// A plate that has no nodes yet.
    pub(crate) fn of(drive: Drive) -> Self {
        let fastest = drive.fastest();
        Self { drive, fastest, speed: Speed::default(), impedance: 0.0, area_mm2: 0.0, mass: 0.0, contacts: Vec::new() }
    }

    /// Puts it on a side of this area with these nodes.
    pub(crate) fn stand_on(&mut self, side_mm2: f64, contacts: Vec<Contact>) {
        self.contacts = contacts;
        self.speed = self.drive.arrived(side_mm2);
        match self.drive {
            Drive::Speed { .. } => {}
            Drive::Bar { youngs_modulus_mpa, density_t_per_mm3, area_mm2, .. } => {
                self.area_mm2 = area_mm2.unwrap_or(side_mm2);
                self.impedance = self.area_mm2 * (youngs_modulus_mpa * density_t_per_mm3).sqrt();
            }
            // kg in tonne.
            Drive::Mass { mass_kg, .. } => self.mass = 1e-3 * mass_kg,
        }
    }

    /// Whether its speed hangs on the specimen's forces.
    pub(crate) fn answers(&self) -> bool {
        !matches!(self.drive, Drive::Speed { .. })
    }

    /// Stresses of the waves that run in its bar to the specimen and from it, MPa, positive in compression, at this force and
    /// speed of its end; none without a bar.
    pub(crate) fn waves(&self, force_n: f64, speed: f64) -> Option<[f64; 2]> {
        let [stress, of_speed] = [force_n, self.impedance * speed].map(|force| force / self.area_mm2);
        let incoming = if self.fastest == 0.0 { 0.0 } else { 0.5 * (stress + of_speed) };
        matches!(self.drive, Drive::Bar { .. }).then_some([incoming, stress - incoming])
    }
}

impl Supports {
    /// Whether the speed of one hangs on the specimen's forces of the step.
    pub(crate) fn answer(&self) -> bool {
        self.all.iter().any(Fixture::answers)
    }

    /// Nodes that may meet a plate whose speed hangs on the specimen's forces; ascending.
    pub(crate) fn met(&self) -> Vec<u32> {
        let answering = self.all.iter().filter_map(|fixture| fixture.driven.as_ref()).filter(|driven| driven.answers());
        let mut nodes: Vec<u32> = answering.flat_map(|driven| &driven.contacts).map(|contact| contact.node).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Largest speed that a drive gives, mm/s.
    pub(crate) fn fastest(&self) -> f64 {
        self.all.iter().map(|fixture| fixture.fastest().abs()).fold(0.0, f64::max)
    }

    /// Way of the plates towards each other, or apart, in the test's sense, mm; 0 where the test has one end alone.
    pub(crate) fn approach(&self, held: &[Held; MOST_SUPPORTS]) -> f64 {
        self.between(held.iter().map(|[at, ..]| *at))
    }

    /// What the supports have, the upper end's less the lower one's in the test's sense; 0 where the test has one end alone.
    pub(crate) fn between(&self, own: impl Iterator<Item = f64> + Clone) -> f64 {
        let at = |end| self.all.iter().zip(own.clone()).find(|(fixture, _)| fixture.end == Some(end)).map(|(_, x)| x);
        at(0).zip(at(1)).map_or(0.0, |(bottom, top)| self.sign * (top - bottom))
    }

    /// Speeds that the drives of the lower and of the upper end give at first, mm/s along the axis.
    pub(crate) fn first(&self) -> [f64; 2] {
        let own = |end| self.all.iter().filter(move |fixture| fixture.end == Some(end));
        let speed = |fixture: &Fixture| {
            fixture.driven.as_ref().map_or(0.0, |driven| fixture.face.inward * driven.speed.at(0.0))
        };
        [0, 1].map(|end| own(end).map(speed).sum())
    }

    /// Strain of the test, or the largest change of the distance of two opposite plates over the size along their axis; strips
    /// are no plates, since a beam is thinner than their way.
    pub(crate) fn farthest(&self, held: &[Held; MOST_SUPPORTS]) -> f64 {
        let is_plate = |fixture: &Fixture| fixture.face.rule != Rule::Pressure && fixture.area_mm2 > 0.0;
        let plates = || self.all.iter().zip(held).filter(|(fixture, _)| is_plate(fixture));
        let at = |axis, inward| {
            let own = plates().filter(move |(fixture, _)| fixture.face.axis == axis && fixture.face.inward == inward);
            own.map(|(_, [at, ..])| *at).max_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        let strain = |axis: usize| Some((at(axis, 1.0)? - at(axis, -1.0)?).abs() / self.size_mm[axis]);
        let of_test = self.approach(held).abs() / self.length_mm;
        (0..3).filter_map(strain).fold(of_test, f64::max)
    }

    /// Moves the plates in real time by the step from `time`; `free` gives a node's mass, and its displacement and its velocity
    /// without a plate along an axis.
    pub(crate) fn drive(
        &self,
        (dt, time): (f64, f64),
        free: impl Fn(usize, usize) -> [f64; 3],
        held: &mut [Held; MOST_SUPPORTS],
    ) {
        for (fixture, [at, speed, before]) in self.all.iter().zip(held) {
            let Some(driven) = &fixture.driven else { continue };
            let (axis, inward) = (fixture.face.axis, fixture.face.inward);
            // A mass flies when the loads have grown.
            if let (Drive::Mass { .. }, true) = (&driven.drive, [*at, *speed] == [0.0; 2] && time >= 0.0) {
                *speed = inward * driven.fastest;
            }
            *before = *speed;
            let wave = |time| driven.speed.at(time);
            let is_waiting = time < 0.0 && matches!(driven.drive, Drive::Mass { .. });
            let next = if is_waiting {
                0.0
            } else if driven.answers() {
                let node = |contact: &Contact| {
                    let [m, u, v] = free(contact.node as usize, axis);
                    [m / dt, inward * v - (inward * (*at - u) - contact.gap) / dt]
                };
                let own: Vec<[f64; 2]> = driven.contacts.iter().map(node).collect();
                let (z, m, w0) = (driven.impedance, driven.mass / dt, inward * *before);
                let line = [z * (2.0 * wave(time) - 0.5 * w0) + m * w0, 0.5 * z + m];
                root(line, &own, fixture.face.rule == Rule::Plate, w0)
            } else {
                wave(time + 0.5 * dt)
            };
            *speed = inward * next;
            *at += dt * *speed;
        }
    }
}

/// The speed w at which a - b w is the sum of k (w - c) over the nodes [k, c], of a plate that cannot pull over those with
/// w > c alone.
fn root([a, b]: [f64; 2], nodes: &[[f64; 2]], pushes: bool, guess: f64) -> f64 {
    let mut w = guess;
    for _ in 0..MOST {
        let met = nodes.iter().filter(|[_, c]| !pushes || w > *c);
        let [over, under] = met.fold([a, b], |[over, under], [k, c]| [over + k * c, under + k]);
        let next = over / under;
        if next == w {
            break;
        }
        w = next;
    }
    w
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_speed_of_a_plate_is_the_root_for_the_nodes_that_it_pushes() {
        let nodes = [[2.0, 1.0], [1.0, 3.0], [4.0, -1.0], [0.5, 2.5]];
        for (a, guess) in [(5.0, 0.0), (40.0, -9.0), (-30.0, 9.0), (0.0, 3.0)] {
            let w = root([a, 0.7], &nodes, true, guess);
            let sum: f64 = nodes.iter().map(|[k, c]| k * (w - c).max(0.0)).sum();
            assert!((a - 0.7 * w - sum).abs() < 1e-12 * (1.0 + sum), "{a} {w} {sum}");
            let w = root([a, 0.7], &nodes, false, guess);
            let sum: f64 = nodes.iter().map(|[k, c]| k * (w - c)).sum();
            assert!((a - 0.7 * w - sum).abs() < 1e-12 * (1.0 + sum.abs()), "{a} {w} {sum}");
        }
    }

    #[test]
    fn waves_add_up_to_the_force_of_the_bars_end() {
        let drive = Drive::bar([2.1e5, 7.85e-9], Some(100.0), Speed::Steady(1.0));
        let mut driven = Driven::of(drive);
        driven.stand_on(50.0, Vec::new());
        let [incoming, outgoing] = driven.waves(3000.0, 500.0).unwrap();
        assert!((incoming + outgoing - 30.0).abs() < 1e-12);
        assert!((incoming - outgoing - (2.1e5_f64 * 7.85e-9).sqrt() * 500.0).abs() < 1e-12);
        assert!(Driven::of(Drive::Mass { mass_kg: 1.0, speed_m_per_s: 1.0 }).waves(1.0, 1.0).is_none());
    }
}
