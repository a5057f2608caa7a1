//! Named tests in real time: split Hopkinson bars, spalling, a falling mass, and impact.

use crate::error::{TEST, TrialError};
use crate::sample::Geometry;
use crate::trial::drive::{Drive, Speed};
use crate::trial::load::{Gauge, Rule, Side, SupportSpec};
use crate::trial::named::Rig;
use crate::trial::{Test, TestKind};
use meso_concrete::OutOfRange;

/// Modulus, MPa, and density, tonne/mm3, of steel bars.
const STEEL: [f64; 2] = [2.1e5, 7.85e-9];
/// Slowest waves along a specimen of concrete, mm/s.
const SLOWEST: f64 = 2.5e6;
/// Ways of a wave through the specimen beside the pulse in a test between bars.
const TRANSITS: f64 = 6.0;
/// Strain at which a test of impact ends.
const CRUSHED: f64 = 0.015;
/// Periods of a beam that a mass strikes.
const PERIODS: f64 = 2.0;

impl TestKind {
    /// Whether it is one in real time.
    pub(super) fn is_fast(self) -> bool {
        matches!(self, Self::Hopkinson | Self::Spall | Self::Drop | Self::Impact)
    }
}

impl Test {
    /// Speed of the striker, the falling mass or the plate, m/s.
    pub fn speed_m_per_s(&self) -> f64 {
        self.speed_m_per_s.unwrap_or(match self.kind {
            TestKind::Spall => 1.0,
            TestKind::Drop => 3.0,
            _ => 8.0,
        })
    }

    /// Length of the pulse at half of its height, s.
    pub fn pulse_s(&self) -> f64 {
        self.pulse_s.unwrap_or(if self.kind == TestKind::Spall { 4e-5 } else { 1e-4 })
    }

    /// Time in which the pulse or the plate's speed rises, s.
    pub fn rise_s(&self) -> f64 {
        self.rise_s.unwrap_or(match self.kind {
            TestKind::Spall => 5e-6,
            TestKind::Hopkinson => 2e-5,
            _ => 1e-5,
        })
    }

    /// Time of a named test in real time, s.
    pub(super) fn fast_duration_s(&self, geometry: &Geometry) -> f64 {
        let [length, _, height] = geometry.size_mm;
        let (transit, pulse) = (height / SLOWEST, self.pulse_s() + self.rise_s());
        match self.kind {
            TestKind::Impact => self.rise_s() + CRUSHED * height / (1e3 * self.speed_m_per_s().abs().max(1e-3)),
            TestKind::Drop if length > height => PERIODS * self.period_s(geometry),
            _ => pulse + TRANSITS * transit,
        }
    }

    /// The rig of a named test in real time.
    pub(super) fn fast_rig(&self, geometry: &Geometry) -> Result<Rig, TrialError> {
        let (friction, v) = (self.friction(), self.speed_m_per_s());
        let driven = |name, on, drive| SupportSpec { friction, drive: Some(drive), ..SupportSpec::new(name, on) };
        let [pulse, rise] = [self.pulse_s(), self.rise_s()];
        let bar = |speed_m_per_s| {
            let [youngs_modulus_mpa, density_t_per_mm3] = STEEL;
            Drive::Bar { youngs_modulus_mpa, density_t_per_mm3, area_mm2: None, speed_m_per_s }
        };
        let at_rest = Drive::Speed { speed_m_per_s: Speed::default() };
        // A striker of the same bar gives it half of its speed.
        let supports = match self.kind {
            TestKind::Hopkinson => {
                let rows = vec![[0.0, 0.0], [rise, 0.5 * v], [pulse, 0.5 * v], [pulse + rise, 0.0]];
                let mut all = vec![
                    driven("input", Side::ZMin, bar(Speed::Over(rows))),
                    driven("output", Side::ZMax, bar(Speed::default())),
                ];
                if let Some(pressure_mpa) = self.pressure_mpa {
                    let mantle = SupportSpec::new("mantle", Side::Mantle);
                    all.push(SupportSpec { rule: Rule::Pressure, pressure_mpa, ..mantle });
                }
                all
            }
            TestKind::Spall => {
                let rows = vec![[0.0, 0.0], [rise, 0.5 * v], [2.0 * pulse, 0.0]];
                vec![driven("input", Side::ZMin, bar(Speed::Over(rows)))]
            }
            TestKind::Drop => {
                let mass = Drive::Mass { mass_kg: self.mass_kg.unwrap_or(1.0), speed_m_per_s: v };
                let [length, _, height] = geometry.size_mm;
                if 0.9 * length > height {
                    // Rollers and strips of a bent beam; the loading one falls.
                    let bent = self.bent(geometry)?;
                    let supports = bent.supports.into_iter().map(|support| {
                        let drive = if support.moves == 0.0 { at_rest.clone() } else { mass.clone() };
                        SupportSpec { moves: 0.0, drive: Some(drive), ..support }
                    });
                    return Ok(Rig { supports: supports.collect(), ..bent });
                }
                vec![driven("base", Side::ZMin, at_rest), driven("load", Side::ZMax, mass)]
            }
            _ => {
                let rows = Speed::Over(vec![[0.0, 0.0], [rise, v]]);
                vec![
                    driven("base", Side::ZMin, at_rest),
                    driven("plate", Side::ZMax, Drive::Speed { speed_m_per_s: rows }),
                ]
            }
        };
        let section_mm2 = geometry.section_mm2;
        Ok(Rig { supports, axis: 2, length_mm: geometry.size_mm[2], section_mm2, breaking_mm2: section_mm2 })
    }

    /// Checks the values of a named test in real time, which others do not have.
    pub(super) fn validate_named_fast(&self) -> Result<(), OutOfRange> {
        use TestKind::{Drop, Hopkinson, Impact, Spall};
        let (kind, is_own) = (self.kind, !self.supports.is_empty());
        let pulsed = matches!(kind, Hopkinson | Spall);
        for (key, value, most, has, of) in [
            ("speed_m_per_s", self.speed_m_per_s, 100.0, kind.is_fast(), "hopkinson, spall, drop and impact"),
            ("pulse_s", self.pulse_s, 1.0, pulsed, "hopkinson and spall"),
            ("rise_s", self.rise_s, 1.0, pulsed || kind == Impact, "hopkinson, spall and impact"),
            ("mass_kg", self.mass_kg, 1e6, kind == Drop, "drop"),
        ] {
            let Some(value) = value else { continue };
            TEST.positive(key, value)?;
            TEST.require(key, value, value <= most, format!("it must be {most} at most"))?;
            let accepted = format!("only {of} have it; leave it out, or take that kind of test");
            TEST.require(key, value, has && !is_own, accepted)?;
        }
        let is_short = !pulsed || self.rise_s() < self.pulse_s();
        TEST.require("rise_s", self.rise_s(), is_short, "it must be shorter than the pulse; take a tenth of pulse_s")
    }

    /// Gauges of a named test in real time.
    pub(super) fn fast_gauges(&self) -> Vec<Gauge> {
        if self.kind == TestKind::Spall { vec![Gauge::Side { name: "face".to_owned(), on: Side::ZMax }] } else { Vec::new() }
    }
}
