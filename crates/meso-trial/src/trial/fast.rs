//! Named tests in real time: split Hopkinson bars, spalling, a falling mass, and impact.

use crate::error::{TEST, TrialError};
use crate::sample::Geometry;
use crate::trial::drive::{Drive, FASTEST, MASSES_KG, Speed};
use crate::trial::load::{Along, Rule, Side, Strip, SupportSpec};
use crate::trial::named::Rig;
use crate::trial::setup::word;
use crate::trial::{Control, Test, TestKind};
use meso_concrete::OutOfRange;
use meso_mesh::materials::{Elastic, LawName};
use std::f64::consts::FRAC_PI_4;

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

/// Reason why a value of a named test has no effect.
const OWN: &str = "supports of the file take the place of those of the named test; leave it out, or the supports";

/// Overhang of a plate beyond the rollers of one pair, over its shorter side; width of its load over its thickness.
const OVERHANG: f64 = 0.1;
const LOAD: f64 = 0.5;
/// Thicknesses of a plate in its length and width at least; others are beams.
const PLATE: f64 = 3.0;

/// Whether a falling mass bends the specimen, which then lies on rollers.
fn bends(geometry: &Geometry) -> bool {
    0.9 * geometry.size_mm[0] > geometry.size_mm[2]
}

/// Whether a bent specimen is a plate, which lies on rollers along all four edges and is struck in its middle.
fn is_plate(geometry: &Geometry) -> bool {
    let [x, y, z] = geometry.size_mm;
    x.min(y) >= PLATE * z
}

impl TestKind {
    /// Whether a pulse comes along a bar.
    fn has_pulse(self) -> bool {
        matches!(self, Self::Hopkinson | Self::HopkinsonSplitting | Self::Spall)
    }

    /// Whether strips press a specimen apart.
    pub(super) fn splits(self) -> bool {
        matches!(self, Self::Splitting | Self::HopkinsonSplitting)
    }

    /// Whether it is one in real time.
    pub(super) fn is_fast(self) -> bool {
        self.has_pulse() || matches!(self, Self::Drop | Self::Impact)
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
            TestKind::Hopkinson | TestKind::HopkinsonSplitting => 2e-5,
            _ => 1e-5,
        })
    }

    /// Time of a named test in real time, s.
    pub(super) fn fast_duration_s(&self, geometry: &Geometry) -> f64 {
        let height = geometry.size_mm[if self.kind.splits() { 0 } else { 2 }];
        let (transit, pulse) = (height / SLOWEST, self.pulse_s() + self.rise_s());
        match self.kind {
            TestKind::Impact => self.rise_s() + CRUSHED * height / (1e3 * self.speed_m_per_s()),
            TestKind::Drop if bends(geometry) => PERIODS * self.period_s(geometry),
            _ => pulse + TRANSITS * transit,
        }
    }

    /// The rig of a named test in real time.
    pub(super) fn fast_rig(&self, geometry: &Geometry) -> Result<Rig, TrialError> {
        let (friction, v) = (self.friction(), self.speed_m_per_s());
        let driven = |name, on, drive| SupportSpec { friction, drive: Some(drive), ..SupportSpec::new(name, on) };
        let [pulse, rise] = [self.pulse_s(), self.rise_s()];
        // Bars of a split specimen have its diameter.
        let area_mm2 = self.kind.splits().then(|| FRAC_PI_4 * geometry.size_mm[0] * geometry.size_mm[0]);
        let bar = |speed| Drive::bar(STEEL, area_mm2, speed);
        let base = SupportSpec { friction, ..SupportSpec::new("base", Side::ZMin) };
        // A striker of the same bar gives it half of its speed.
        let wave = || Speed::Over(vec![[0.0, 0.0], [rise, 0.5 * v], [pulse, 0.5 * v], [pulse + rise, 0.0]]);
        let supports = match self.kind {
            TestKind::HopkinsonSplitting => {
                let split = self.split(geometry)?;
                let ends = [("input", wave()), ("output", Speed::default())];
                let supports = split.supports.into_iter().zip(ends).map(|(strip, (name, speed))| SupportSpec {
                    name: name.to_owned(),
                    moves: 0.0,
                    drive: Some(bar(speed)),
                    ..strip
                });
                let ends = [("lower", Side::ZMin), ("upper", Side::ZMax)];
                let pressed = ends.into_iter().filter_map(|(name, on)| self.pressed(name, on));
                return Ok(Rig { supports: supports.chain(pressed).collect(), ..split });
            }
            TestKind::Hopkinson => {
                let output = driven("output", Side::ZMax, bar(Speed::default()));
                let bars = [driven("input", Side::ZMin, bar(wave())), output];
                bars.into_iter().chain(self.pressed("mantle", Side::Mantle)).collect()
            }
            TestKind::Spall => {
                let rows = vec![[0.0, 0.0], [rise, 0.5 * v], [2.0 * pulse, 0.0]];
                vec![SupportSpec { friction: 0.0, ..driven("input", Side::ZMin, bar(Speed::Over(rows))) }]
            }
            TestKind::Drop => {
                let mass = Drive::Mass { mass_kg: self.mass_kg.unwrap_or(1.0), speed_m_per_s: v };
                if bends(geometry) {
                    // Rollers and strips of a bent beam; the loading one falls.
                    let bent = self.bent(geometry)?;
                    let supports = bent.supports.into_iter().map(|support| {
                        let drive = (support.moves != 0.0).then(|| mass.clone());
                        SupportSpec { moves: 0.0, drive, ..support }
                    });
                    let supports = supports.collect();
                    let supports = if is_plate(geometry) { self.on_edges(geometry, supports)? } else { supports };
                    return Ok(Rig { supports, ..bent });
                }
                vec![base, driven("load", Side::ZMax, mass)]
            }
            _ => {
                let rows = Speed::Over(vec![[0.0, 0.0], [rise, v]]);
                vec![base, driven("plate", Side::ZMax, Drive::Speed { speed_m_per_s: rows })]
            }
        };
        let section_mm2 = geometry.section_mm2;
        Ok(Rig { supports, axis: 2, length_mm: geometry.size_mm[2], section_mm2, breaking_mm2: section_mm2 })
    }

    /// Distance of the rollers of a plate on its edges along x, unless it is given, mm; none of another specimen.
    pub(super) fn plate_span_mm(&self, geometry: &Geometry) -> Option<f64> {
        let [x, y, _] = geometry.size_mm;
        (self.kind == TestKind::Drop && is_plate(geometry)).then(|| x - OVERHANG * x.min(y))
    }

    /// The supports of a bent plate: rollers along the other two edges, too, as far from them, and a square load.
    fn on_edges(&self, geometry: &Geometry, mut supports: Vec<SupportSpec>) -> Result<Vec<SupportSpec>, TrialError> {
        let [x, y, z] = geometry.size_mm;
        let span = y - (x - self.span_mm(geometry));
        let accepted =
            format!("rollers as far from the other edges would be less than {z} mm apart; take a larger one");
        TEST.require("span_mm", self.span_mm(geometry), span >= z, accepted)?;
        let mut more = Vec::new();
        for support in &mut supports {
            let Some(strip) = &mut support.strip else { continue };
            if support.drive.is_some() {
                strip.width_mm = self.strip_mm.unwrap_or(LOAD * z);
                strip.length_mm = Some(strip.width_mm);
            } else {
                let name = if strip.at_mm < 0.0 { "front" } else { "back" };
                let strip = Strip::new(Along::Y, 0.5 * span * strip.at_mm.signum(), strip.width_mm);
                more.push(SupportSpec { strip: Some(strip), ..SupportSpec::new(name, Side::ZMin) });
            }
        }
        supports.extend(more);
        Ok(supports)
    }

    /// The test's pressure on a side, if it has one.
    fn pressed(&self, name: &str, on: Side) -> Option<SupportSpec> {
        let spec = |pressure_mpa| SupportSpec { rule: Rule::Pressure, pressure_mpa, ..SupportSpec::new(name, on) };
        self.pressure_mpa.map(spec)
    }

    /// Checks the values of a named test in real time, which others do not have.
    pub(super) fn validate_named_fast(&self) -> Result<(), OutOfRange> {
        use TestKind::{Drop, Impact};
        let (kind, is_own) = (self.kind, !self.supports.is_empty());
        let pulsed = kind.has_pulse();
        for (key, value, [least, most], has, of) in [
            (
                "speed_m_per_s",
                self.speed_m_per_s,
                [1e-3, FASTEST],
                kind.is_fast(),
                "hopkinson, hopkinson-splitting, spall, drop and impact",
            ),
            ("pulse_s", self.pulse_s, [1e-9, 1.0], pulsed, "hopkinson, hopkinson-splitting and spall"),
            (
                "rise_s",
                self.rise_s,
                [1e-9, 1.0],
                pulsed || kind == Impact,
                "hopkinson, hopkinson-splitting, spall and impact",
            ),
            ("mass_kg", self.mass_kg, MASSES_KG, kind == Drop, "drop"),
        ] {
            let Some(value) = value else { continue };
            TEST.positive(key, value)?;
            TEST.require(key, value, (least..=most).contains(&value), format!("it must be {least:?} to {most:?}"))?;
            let accepted = format!("only {of} tests take it; leave it out, or take that kind of test");
            TEST.require(key, value, has, accepted)?;
            TEST.require(key, value, !is_own, OWN)?;
        }
        for (key, value) in
            [("pressure_mpa", self.pressure_mpa), ("span_mm", self.span_mm), ("strip_mm", self.strip_mm)]
        {
            TEST.require(key, value.unwrap_or_default(), value.is_none() || !is_own || !kind.is_fast(), OWN)?;
        }
        let is_timed = !kind.is_fast() || self.is_fast();
        let drives = "none of the supports has a drive, which this test needs; give one, or take another kind";
        TEST.require("kind", word(&kind), is_timed, drives)?;
        let is_short = !pulsed || self.rise_s() < self.pulse_s();
        TEST.require("rise_s", self.rise_s(), is_short, "it must be shorter than the pulse; take a tenth of pulse_s")
    }

    /// Refuses a specimen that a falling mass bends but no roller can bear, and rollers of one that stands on a base.
    pub(super) fn suits_drop(&self, geometry: &Geometry, is_round: bool) -> Result<(), OutOfRange> {
        let falls = self.kind == TestKind::Drop && self.supports.is_empty();
        let bends = bends(geometry);
        let plane = "the specimen has no plane sides for its rollers; take a prism, or one that is higher than long";
        TEST.require("kind", "drop", !falls || !bends || !is_round, plane)?;
        for (key, value) in [("span_mm", self.span_mm), ("strip_mm", self.strip_mm)] {
            let stands = "the specimen stands on a base and has no rollers; leave it out, or take a prism that lies";
            TEST.require(key, value.unwrap_or_default(), !falls || bends || value.is_none(), stands)?;
        }
        Ok(())
    }
}

impl SupportSpec {
    /// Checks its drive, and refuses a rule and a strip that cannot have it.
    pub(super) fn validate_drive(&self) -> Result<(), OutOfRange> {
        let named = |key: &str| format!("supports.{}.{key}", self.name);
        let Some(drive) = &self.drive else { return Ok(()) };
        drive.validate(&named)?;
        let held = "a pressure has no plate that a drive moves; take rule = \"plate\" or \"glued\"";
        TEST.require(named("drive"), "given", self.rule != Rule::Pressure, held)?;
        let is_bar = matches!(drive, Drive::Bar { area_mm2: None, .. });
        let whole = "a bar stands on a whole side; give its area_mm2 for one on a strip";
        TEST.require(named("strip"), "given", !is_bar || self.strip.is_none(), whole)
    }
}

impl Test {
    /// Largest strain of a test in real time, plate against plate: strains are small ones.
    pub const LARGEST_STRAIN: f64 = 0.02;

    /// Whether its supports move in real time, without a path.
    pub fn is_fast(&self) -> bool {
        let is_driven = self.supports.iter().any(|support| support.drive.is_some());
        is_driven || self.kind.is_fast() && self.supports.is_empty()
    }

    /// Whether two opposite plates, and no other support, strain the specimen from the first moment: glued ones where they pull.
    fn is_stretched(&self) -> bool {
        let first = |support: &SupportSpec| match &support.drive {
            Some(Drive::Speed { speed_m_per_s }) if support.strip.is_none() => Some(speed_m_per_s.at(0.0)),
            _ => None,
        };
        let [one, other] = &self.supports[..] else { return false };
        let faces = one.on.bit().zip(other.on.bit()).is_some_and(|(one, other)| one ^ other == 1);
        let holds = |presses: bool| presses || [one, other].iter().all(|plate| plate.rule == Rule::Glued);
        first(one).zip(first(other)).is_some_and(|(a, b)| faces && a + b != 0.0 && holds(a + b > 0.0))
    }

    /// Refuses steps in real time that no mesh of about this size is stable with, since no mass is added, and a duration of too
    /// many of them.
    ///
    /// # Errors
    /// A step in which waves run two elements of `mortar` far, and a duration of 1e9 of these.
    pub fn suits_waves(&self, element_size_mm: f64, mortar: &Elastic) -> Result<(), OutOfRange> {
        let (step, crossed) = (self.time_step_s.unwrap_or_default(), element_size_mm / mortar.wave_speed_mm_per_s());
        let why =
            format!("waves cross an element in {crossed:.3e} s, and a test in real time adds no mass; leave it out");
        TEST.require("time_step_s", step, step <= 2.0 * crossed, why)?;
        let (duration, most) = (self.duration_s.unwrap_or_default(), 2e9 * crossed);
        let why =
            format!("these are more than 1e9 steps in elements of {element_size_mm} mm; take {most:.0e} s at most");
        TEST.require("duration_s", duration, duration <= most, why)
    }

    /// Refuses keys of a quasi-static test in one in real time: its time would be artificial.
    pub(super) fn validate_fast(&self) -> Result<(), OutOfRange> {
        let timed = "the time of a quasi-static test is artificial; leave it out, or give the supports a drive";
        TEST.require("rate_effect", true, !self.rate_effect || self.is_fast(), timed)?;
        let moving = "it needs two opposite plates that strain the specimen from time 0, glued if they pull, alone; leave it out";
        TEST.require("starts_moving", true, !self.starts_moving || self.is_stretched(), moving)?;
        let has_law = !self.rate_effect || self.law == LawName::Meso;
        TEST.require("law", word(&self.law), has_law, "only meso has a rate_effect; take it, or leave that out")?;
        if !self.is_fast() {
            return Ok(());
        }
        let steady = "a test in real time keeps its speed; take control = \"steady\", or leave it out";
        let control = self.control();
        TEST.require("control", word(&control), control == Control::Steady, steady)?;
        let lasts = "a test in real time lasts as long as you say; give duration_s, as in duration_s = 2e-4";
        let has_end = self.duration_s.is_some() || self.kind.is_fast();
        TEST.require("duration_s", "absent", has_end, lasts)?;
        let ends = "a test in real time ends with its duration; leave it out";
        TEST.require("strain", self.strain.unwrap_or_default(), self.strain.is_none(), ends)?;
        TEST.require("turns", self.turns.len(), self.turns.is_empty(), ends)?;
        TEST.require("expansion", "given", self.expansion.is_none(), "a test in real time has none; leave it out")?;
        for SupportSpec { name, rule, moves, pressure_mpa, stress_ratio, drive, .. } in &self.supports {
            let key = |key: &str| format!("supports.{name}.{key}");
            let [no_path, no_servo] = match drive {
                Some(_) => ["a drive moves this plate; leave it out, or the drive"; 2],
                None => [
                    "another support has a drive, so the test has no path; give this one a drive, too",
                    "a servo's plate is slow, and this test is fast; press the sides with rule = \"pressure\"",
                ],
            };
            TEST.require(key("moves"), moves, *moves == 0.0, no_path)?;
            TEST.require(key("stress_ratio"), stress_ratio.unwrap_or_default(), stress_ratio.is_none(), no_servo)?;
            let has_servo = *rule != Rule::Pressure && *pressure_mpa != 0.0;
            TEST.require(key("pressure_mpa"), pressure_mpa, !has_servo, no_servo)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(edit: impl Fn(&mut Test)) -> String {
        let drive = Some(Drive::Mass { mass_kg: 1.0, speed_m_per_s: 5.0 });
        let striker = SupportSpec { drive, ..SupportSpec::new("striker", Side::ZMax) };
        let supports = vec![SupportSpec::new("base", Side::ZMin), striker];
        let mut test = Test { supports, duration_s: Some(1e-4), ..Test::default() };
        test.validate().unwrap();
        edit(&mut test);
        test.validate().unwrap_err().to_string()
    }

    #[test]
    fn keys_of_a_quasi_static_test_are_refused_in_real_time() {
        let bar = |modulus, rows| Drive::bar([modulus, 7.85e-9], None, Speed::Over(rows));
        let sent = |travel_mm, poisson_ratio, speed_m_per_s| Drive::Bar {
            youngs_modulus_mpa: 2.1e5,
            density_t_per_mm3: 7.85e-9,
            area_mm2: None,
            speed_m_per_s,
            travel_mm,
            poisson_ratio,
        };
        let wave = || Speed::Over(vec![[0.0, 0.0], [1e-5, 1.0]]);
        let drive = |test: &mut Test, drive: Drive| test.supports[1].drive = Some(drive);
        let start = |test: &mut Test, speeds: [f64; 2], rule| {
            test.starts_moving = true;
            for (support, speed) in test.supports.iter_mut().zip(speeds) {
                (support.rule, support.drive) = (rule, Some(Drive::Speed { speed_m_per_s: Speed::Steady(speed) }));
            }
        };
        type Edit<'a> = &'a dyn Fn(&mut Test);
        let edits: [(Edit, &str); 24] = [
            (&|test| (test.rate_effect, test.law) = (true, LawName::Cdp), "only meso has a rate_effect"),
            (&|test| test.starts_moving = true, "test.starts_moving is true; it needs two opposite plates"),
            (&|test| start(test, [1.0, -1.0], Rule::Glued), "two opposite plates that strain the specimen"),
            (&|test| start(test, [-1.0, -1.0], Rule::Plate), "glued if they pull"),
            (&|test| (test.rate_effect, test.supports) = (true, Vec::new()), "a quasi-static test is artificial"),
            (&|test| test.control = Some(Control::CrackMouth), "test.control is crack-mouth"),
            (&|test| test.control = Some(Control::Servo), "test.control is servo; a test in real time keeps its speed"),
            (&|test| test.duration_s = None, "test.duration_s is absent"),
            (&|test| test.strain = Some(0.01), "test.strain is 0.01"),
            (&|test| test.supports[0].moves = 0.5, "test.supports.base.moves is 0.5"),
            (&|test| test.supports[0].pressure_mpa = 2.0, "test.supports.base.pressure_mpa is 2"),
            (&|test| test.supports[1].stress_ratio = Some(1.0), "test.supports.striker.stress_ratio is 1"),
            (&|test| test.supports[1].rule = Rule::Pressure, "no plate that a drive moves"),
            (&|test| drive(test, Drive::Mass { mass_kg: f64::NAN, speed_m_per_s: 1.0 }), "drive.mass_kg is NaN"),
            (&|test| drive(test, Drive::Mass { mass_kg: 1.0, speed_m_per_s: 5000.0 }), "speed_m_per_s is 5000"),
            (&|test| drive(test, bar(210.0, vec![[0.0, 1.0]])), "drive.youngs_modulus_mpa is 210"),
            (&|test| drive(test, bar(2.1e5, vec![[1.0, 1.0], [0.5, 1.0]])), "drive.speed_m_per_s is 0.5; times"),
            (&|test| drive(test, sent(Some(f64::NAN), None, wave())), "drive.travel_mm is NaN; it must be 0 to 1e5"),
            (&|test| drive(test, sent(Some(10.0), Some(0.6), wave())), "drive.poisson_ratio is 0.6"),
            (
                &|test| drive(test, sent(Some(9e4), None, wave())),
                "2.5e-5 s apart, and the wave changes within 1.0e-5 s",
            ),
            (&|test| drive(test, sent(None, Some(0.3), wave())), "without a travel_mm does not disperse"),
            (&|test| drive(test, sent(Some(10.0), None, Speed::Steady(1.0))), "a wave of rows of time and speed"),
            (&|test| drive(test, bar(2.1e5, vec![])), "give a row of a time and a speed"),
            (
                &|test| drive(test, Drive::Speed { speed_m_per_s: Speed::Table("a.csv".to_owned()) }),
                "only a TEST.toml and Python",
            ),
        ];
        for (edit, why) in edits {
            let error = refusal(edit);
            assert!(error.contains(why), "{error}");
        }
    }
}
