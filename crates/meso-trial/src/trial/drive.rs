//! Plates in real time: at a given speed, at the end of an elastic bar, or of a mass of their own.
//!
//! The end of a long bar with the modulus E, the density rho and the section A has the force Z (2 v_i - v): Z = A
//! sqrt(E rho), v is the speed of the end, and v_i the particle speed of the wave that comes along the bar. It is exact
//! where sections of the bar stay plane (Kolsky 1963, Stress Waves in Solids, Chapter II).

use crate::error::TEST;
use crate::trial::load::SupportSpec;
use crate::trial::setup::word;
use crate::trial::{Control, Rule, Test};
use meso_concrete::OutOfRange;
use meso_mesh::materials::{DENSITY, LawName, MODULUS};
use serde::{Deserialize, Serialize};

/// What moves a plate in real time. Speeds are positive towards the specimen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case", tag = "kind", deny_unknown_fields)]
pub enum Drive {
    /// It has this speed.
    Speed {
        /// Its speed, m/s.
        speed_m_per_s: Speed,
    },
    /// It is the plane end of a long elastic bar, from which no wave returns.
    Bar {
        /// Young's modulus of the bar, MPa.
        #[cfg_attr(feature = "schema", schemars(range(min = 300.0, max = 2e6)))]
        youngs_modulus_mpa: f64,
        /// Density of the bar, tonne/mm3.
        #[cfg_attr(feature = "schema", schemars(range(min = 1e-11, max = 1e-7)))]
        density_t_per_mm3: f64,
        /// Section of the bar, mm2; absent, it is the area of the side.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[cfg_attr(feature = "schema", schemars(range(min = 1e-3, max = 1e8)))]
        area_mm2: Option<f64>,
        /// Particle speed of the wave that comes along the bar, m/s: half of the speed of a striker of the same bar. Absent,
        /// none comes.
        #[serde(default)]
        speed_m_per_s: Speed,
    },
    /// It is rigid, has a mass, and strikes the specimen.
    Mass {
        /// Its mass, kg.
        #[cfg_attr(feature = "schema", schemars(range(min = 1e-6, max = 1e6)))]
        mass_kg: f64,
        /// Its speed when the test begins, m/s.
        #[cfg_attr(feature = "schema", schemars(range(min = -100.0, max = 100.0)))]
        speed_m_per_s: f64,
    },
}

/// A speed over time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "it must be a speed, rows of a time and a speed: [[0, 0], [2e-5, 5]], or a CSV file")]
pub enum Speed {
    /// It is constant, m/s.
    Steady(#[cfg_attr(feature = "schema", schemars(range(min = -100.0, max = 100.0)))] f64),
    /// It goes straight from row to row of a time, s, and a speed, m/s. It is 0 before the first row and keeps the last one;
    /// two rows of one time are a jump.
    Over(Vec<[f64; 2]>),
    /// A CSV file with the rows: columns named `time_s` and `speed_m_per_s`. It lies beside the TEST.toml.
    Table(String),
}

impl Default for Speed {
    fn default() -> Self {
        Self::Steady(0.0)
    }
}

/// Fastest plates and waves, m/s: in steel 100 m/s is a stress of 4 GPa, in mortar a strain of 0.03.
const FASTEST: f64 = 100.0;

/// The reason why no row of a speed over time can follow the time `before`.
pub(super) fn unfit_row(before: f64, [time, speed]: [f64; 2]) -> Option<(usize, &'static str)> {
    if !(time >= before && time.is_finite()) {
        return Some((0, "times must be finite, 0 or more, and not descend"));
    }
    (!(speed.abs() <= FASTEST)).then_some((1, "it must be -100 to 100 m/s; strains are small, and mm/s are no m/s"))
}

impl Speed {
    /// The speed at a time, mm/s.
    pub fn at(&self, time_s: f64) -> f64 {
        1e3 * match self {
            Self::Steady(speed) => *speed,
            Self::Table(_) => 0.0,
            Self::Over(rows) => {
                let next = rows.partition_point(|row| row[0] <= time_s);
                match (next.checked_sub(1).map(|before| rows[before]), rows.get(next)) {
                    (None, _) => 0.0,
                    (Some([_, speed]), None) => speed,
                    (Some([t0, v0]), Some([t1, v1])) => v0 + (v1 - v0) * (time_s - t0) / (t1 - t0),
                }
            }
        }
    }

    /// Speeds between which it stays, m/s.
    fn speeds(&self) -> Vec<f64> {
        match self {
            Self::Steady(speed) => vec![*speed],
            Self::Over(rows) => rows.iter().map(|row| row[1]).collect(),
            Self::Table(_) => Vec::new(),
        }
    }

    fn validate(&self, key: &str) -> Result<(), OutOfRange> {
        let mut before = 0.0;
        match self {
            Self::Steady(speed) => {
                let unfit = unfit_row(0.0, [0.0, *speed]);
                unfit.map_or(Ok(()), |(_, why)| Err(TEST.error(key, speed, why)))
            }
            Self::Table(name) => Err(TEST.error(key, name, "only a TEST.toml and Python read a table; give the rows")),
            Self::Over(rows) if rows.is_empty() => Err(TEST.error(key, "[]", "give a row of a time and a speed")),
            Self::Over(rows) => rows.iter().try_for_each(|row| {
                let unfit = unfit_row(before, *row);
                before = row[0];
                unfit.map_or(Ok(()), |(place, why)| Err(TEST.error(key, row[place], why)))
            }),
        }
    }
}

impl Drive {
    /// See [`speed`](Self::speed).
    pub(super) fn speed_mut(&mut self) -> Option<&mut Speed> {
        match self {
            Self::Speed { speed_m_per_s } | Self::Bar { speed_m_per_s, .. } => Some(speed_m_per_s),
            Self::Mass { .. } => None,
        }
    }

    /// Its speed over time, or that of the wave that comes along its bar; a mass has none.
    pub fn speed(&self) -> Option<&Speed> {
        match self {
            Self::Speed { speed_m_per_s } | Self::Bar { speed_m_per_s, .. } => Some(speed_m_per_s),
            Self::Mass { .. } => None,
        }
    }

    /// The speed of largest size that it gives to a plate, mm/s, signed.
    pub fn fastest(&self) -> f64 {
        let of = |speeds: Vec<f64>| {
            speeds.into_iter().fold(0.0, |most: f64, speed| if speed.abs() > most.abs() { speed } else { most })
        };
        1e3 * match self {
            Self::Speed { speed_m_per_s } => of(speed_m_per_s.speeds()),
            Self::Bar { speed_m_per_s, .. } => 2.0 * of(speed_m_per_s.speeds()),
            Self::Mass { speed_m_per_s, .. } => *speed_m_per_s,
        }
    }

    fn validate(&self, named: &impl Fn(&str) -> String) -> Result<(), OutOfRange> {
        if let Some(speed) = self.speed() {
            speed.validate(&named("drive.speed_m_per_s"))?;
        }
        match *self {
            Self::Speed { .. } => Ok(()),
            Self::Bar { youngs_modulus_mpa: modulus, density_t_per_mm3: density, area_mm2, .. } => {
                for (key, value, range) in
                    [("youngs_modulus_mpa", modulus, MODULUS), ("density_t_per_mm3", density, DENSITY)]
                {
                    TEST.require(named(&format!("drive.{key}")), value, range.has(value), range.refusal(value))?;
                }
                let area = area_mm2.unwrap_or(1.0);
                TEST.require(named("drive.area_mm2"), area, (1e-3..=1e8).contains(&area), "it must be 1e-3 to 1e8 mm2")
            }
            Self::Mass { mass_kg, speed_m_per_s: speed } => {
                let met = (1e-6..=1e6).contains(&mass_kg);
                TEST.require(named("drive.mass_kg"), mass_kg, met, "it must be 1e-6 to 1e6 kg")?;
                Speed::Steady(speed).validate(&named("drive.speed_m_per_s"))
            }
        }
    }
}

impl SupportSpec {
    /// Checks its drive, and refuses keys that contradict it.
    pub(super) fn validate_drive(&self) -> Result<(), OutOfRange> {
        let named = |key: &str| format!("supports.{}.{key}", self.name);
        let Some(drive) = &self.drive else { return Ok(()) };
        drive.validate(&named)?;
        let held = "a pressure has no plate that a drive moves; take rule = \"plate\" or \"glued\"";
        TEST.require(named("drive"), "given", self.rule != Rule::Pressure, held)?;
        let alone = "a drive moves this plate; leave it out, or the drive";
        TEST.require(named("moves"), self.moves, self.moves == 0.0, alone)?;
        TEST.require(named("pressure_mpa"), self.pressure_mpa, self.pressure_mpa == 0.0, alone)?;
        let ratio = self.stress_ratio.unwrap_or_default();
        TEST.require(named("stress_ratio"), ratio, self.stress_ratio.is_none(), alone)?;
        let is_bar = matches!(drive, Drive::Bar { .. });
        TEST.require(named("strip"), "given", !is_bar || self.strip.is_none(), "a bar stands on a whole side")
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

    /// Refuses keys of a quasi-static test in one in real time: its time would be artificial.
    pub(super) fn validate_fast(&self) -> Result<(), OutOfRange> {
        let timed = "the time of a quasi-static test is artificial; leave it out, or give the supports a drive";
        TEST.require("rate_effect", true, !self.rate_effect || self.is_fast(), timed)?;
        let has_law = !self.rate_effect || self.law == LawName::Meso;
        TEST.require("law", word(&self.law), has_law, "only meso has a rate_effect; take it, or leave that out")?;
        if !self.is_fast() {
            return Ok(());
        }
        let steady = "a test in real time keeps its speed; take control = \"steady\", or leave it out";
        let follows = matches!(self.control, Control::CrackMouth | Control::LateralStrain);
        TEST.require("control", word(&self.control), !follows, steady)?;
        let lasts = "a test in real time lasts as long as you say; give duration_s, as in duration_s = 2e-4";
        let has_end = self.duration_s.is_some() || self.kind.is_fast();
        TEST.require("duration_s", "absent", has_end, lasts)?;
        let ends = "a test in real time ends with its duration; leave it out";
        TEST.require("strain", self.strain.unwrap_or_default(), self.strain.is_none(), ends)?;
        TEST.require("turns", self.turns.len(), self.turns.is_empty(), ends)?;
        TEST.require("expansion", "given", self.expansion.is_none(), "a test in real time has none; leave it out")?;
        for SupportSpec { name, rule, moves, pressure_mpa, stress_ratio, .. } in &self.supports {
            let on_path = "another support has a drive, so the test has no path; give this one a drive, too";
            TEST.require(format!("supports.{name}.moves"), moves, *moves == 0.0, on_path)?;
            let has_servo = stress_ratio.is_some() || *rule != Rule::Pressure && *pressure_mpa != 0.0;
            let why = "a servo's plate is slow, and this test is fast; press the sides with rule = \"pressure\"";
            TEST.require(format!("supports.{name}.pressure_mpa"), pressure_mpa, !has_servo, why)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::Side;

    #[test]
    fn a_speed_goes_straight_from_row_to_row_jumps_and_keeps_its_last_value() {
        let speed = Speed::Over(vec![[1.0, 0.0], [2.0, 4.0], [2.0, 1.0], [3.0, 1.0]]);
        let at = [0.0, 1.0, 1.25, 2.0, 9.0].map(|time| speed.at(time));
        assert_eq!(at, [0.0, 0.0, 1000.0, 1000.0, 1000.0]);
        assert_eq!([Speed::Steady(-2.0).at(7.0), Speed::default().at(1.0)], [-2000.0, 0.0]);
    }

    fn refusal(edit: impl Fn(&mut Test)) -> String {
        let drive = Some(Drive::Mass { mass_kg: 1.0, speed_m_per_s: 5.0 });
        let striker = SupportSpec { drive, ..SupportSpec::new("striker", Side::ZMax) };
        let supports = vec![SupportSpec::new("base", Side::ZMin), striker];
        let mut test = Test { supports, control: Control::Steady, duration_s: Some(1e-4), ..Test::default() };
        test.validate().unwrap();
        edit(&mut test);
        test.validate().unwrap_err().to_string()
    }

    #[test]
    fn keys_of_a_quasi_static_test_are_refused_in_real_time() {
        let bar = |youngs_modulus_mpa, rows| Drive::Bar {
            youngs_modulus_mpa,
            density_t_per_mm3: 7.85e-9,
            area_mm2: None,
            speed_m_per_s: Speed::Over(rows),
        };
        let drive = |test: &mut Test, drive: Drive| test.supports[1].drive = Some(drive);
        type Edit<'a> = &'a dyn Fn(&mut Test);
        let edits: [(Edit, &str); 15] = [
            (&|test| (test.rate_effect, test.law) = (true, LawName::Cdp), "only meso has a rate_effect"),
            (&|test| (test.rate_effect, test.supports) = (true, Vec::new()), "a quasi-static test is artificial"),
            (&|test| test.control = Control::CrackMouth, "test.control is crack-mouth"),
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
