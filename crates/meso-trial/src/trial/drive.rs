//! Plates in real time: at a given speed, at the end of an elastic bar, or of a mass of their own.
//!
//! The end of a long bar with the modulus E, the density rho and the section A has the force Z (2 v_i - v): Z = A
//! sqrt(E rho), v is the speed of the end, and v_i the particle speed of the wave that comes along the bar. It is exact
//! where sections of the bar stay plane (Kolsky 1963, Stress Waves in Solids, Chapter II). On its way along the bar a wave is
//! dispersed as in a round bar (`dispersion`).

use crate::error::TEST;
use crate::trial::dispersion;
use meso_concrete::OutOfRange;
use meso_mesh::materials::{DENSITY, MODULUS};
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
        /// Way along the bar to the specimen that the wave takes, mm: it arrives later, and dispersed. Absent, it comes as it is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 1e5)))]
        travel_mm: Option<f64>,
        /// Poisson's ratio of the bar, by which it disperses [default: 0.29, that of steel]
        #[serde(default, skip_serializing_if = "Option::is_none")]
        #[cfg_attr(feature = "schema", schemars(range(min = 0.0, max = 0.5)))]
        poisson_ratio: Option<f64>,
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

/// Poisson's ratio of steel.
const STEEL_RATIO: f64 = 0.29;

/// Fastest plates and waves, m/s: in steel 100 m/s is a stress of 4 GPa, in mortar a strain of 0.03.
pub(super) const FASTEST: f64 = 100.0;
/// Masses that strike, kg.
pub(super) const MASSES_KG: [f64; 2] = [1e-6, 1e6];

/// The reason why no row of a speed over time can follow the time `before`.
pub(super) fn unfit_row(before: f64, [time, speed]: [f64; 2]) -> Option<(usize, &'static str)> {
    if !(time >= before && time.is_finite()) {
        return Some((0, "times must be finite, 0 or more, and not descend"));
    }
    let why = "it must be -100 to 100 m/s; strains are small, and mm/s are no m/s";
    (!(-FASTEST..=FASTEST).contains(&speed)).then_some((1, why))
}

impl Speed {
    /// The speed at a time, mm/s; 0 before the time 0.
    pub fn at(&self, time_s: f64) -> f64 {
        if time_s < 0.0 {
            return 0.0;
        }
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

    /// Rows of a time, s, and the speed, mm/s, for the table of a deck: times ascend from 0, and a jump takes `jump_s`.
    pub(crate) fn rows(&self, jump_s: f64) -> Vec<[f64; 2]> {
        let given: &[[f64; 2]] = match self {
            Self::Steady(speed) => &[[0.0, *speed]],
            Self::Over(rows) => rows,
            Self::Table(_) => &[],
        };
        let start = given.first().map(|row| [row[0], 0.0]);
        let mut rows: Vec<[f64; 2]> = vec![[0.0, 0.0]];
        for [time, speed] in start.iter().chain(given) {
            let (last, speed) = (rows[rows.len() - 1], 1e3 * speed);
            if last != [*time, speed] {
                rows.push([if *time > last[0] { *time } else { last[0] + jump_s }, speed]);
            }
        }
        rows
    }

    /// The time of its last change, s, and the shortest time in which it changes other than by a jump.
    fn changes(&self) -> [f64; 2] {
        let Self::Over(rows) = self else { return [0.0, f64::INFINITY] };
        let changes =
            rows.windows(2).filter(|pair| pair[0][1] != pair[1][1]).map(|pair| [pair[1][0], pair[1][0] - pair[0][0]]);
        let first = rows.first().map_or(0.0, |row| row[0]);
        changes.fold([first, f64::INFINITY], |[last, shortest], [at, within]| {
            [last.max(at), if within > 0.0 { shortest.min(within) } else { shortest }]
        })
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
    /// A bar of this modulus, MPa, density, tonne/mm3, and section, mm2, along which a wave comes as it is.
    pub fn bar([youngs_modulus_mpa, density_t_per_mm3]: [f64; 2], area_mm2: Option<f64>, speed_m_per_s: Speed) -> Self {
        let (travel_mm, poisson_ratio) = (None, None);
        Self::Bar { youngs_modulus_mpa, density_t_per_mm3, area_mm2, speed_m_per_s, travel_mm, poisson_ratio }
    }

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

    /// [Its speed](Self::speed) where it meets a specimen; a bar without an area of its own has `side_mm2`.
    pub fn arrived(&self, side_mm2: f64) -> Speed {
        let speed = self.speed().cloned().unwrap_or_default();
        let Self::Bar { youngs_modulus_mpa, density_t_per_mm3, area_mm2, travel_mm, poisson_ratio, .. } = self else {
            return speed;
        };
        let (way, ratio) = (travel_mm.unwrap_or_default(), poisson_ratio.unwrap_or(STEEL_RATIO));
        if way == 0.0 || speed.speeds().iter().all(|speed| *speed == 0.0) {
            return speed;
        }
        let sound = (youngs_modulus_mpa / density_t_per_mm3).sqrt();
        let radius = (area_mm2.unwrap_or(side_mm2) / std::f64::consts::PI).sqrt();
        let [last, _] = speed.changes();
        let wave = |time| 1e-3 * speed.at(time);
        Speed::Over(dispersion::dispersed((wave, last), way / sound, radius / sound, ratio))
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

    /// Checks every value against its range; `named` gives a key's full name.
    pub(super) fn validate(&self, named: &impl Fn(&str) -> String) -> Result<(), OutOfRange> {
        if let Some(speed) = self.speed() {
            speed.validate(&named("drive.speed_m_per_s"))?;
        }
        match *self {
            Self::Speed { .. } => Ok(()),
            Self::Bar {
                youngs_modulus_mpa: modulus,
                density_t_per_mm3: density,
                area_mm2,
                travel_mm,
                poisson_ratio,
                ..
            } => {
                let (way, ratio) = (travel_mm.unwrap_or_default(), poisson_ratio.unwrap_or(STEEL_RATIO));
                TEST.require(named("drive.travel_mm"), way, (0.0..=1e5).contains(&way), "it must be 0 to 1e5 mm")?;
                TEST.require(named("drive.poisson_ratio"), ratio, (0.0..=0.5).contains(&ratio), "it must be 0 to 0.5")?;
                let idle = "a bar without a travel_mm does not disperse; give that, or leave it out";
                TEST.require(named("drive.poisson_ratio"), ratio, poisson_ratio.is_none() || way > 0.0, idle)?;
                let comes = travel_mm.is_none() || matches!(self.speed(), Some(Speed::Over(_)));
                let still = "it disperses a wave of rows of time and speed; give those, or leave it out";
                TEST.require(named("drive.travel_mm"), way, comes, still)?;
                let [last, shortest] = self.speed().map_or([0.0, f64::INFINITY], Speed::changes);
                let apart = dispersion::sample_s(last, way / (modulus / density).sqrt());
                let coarse = format!(
                    "its samples would be {apart:.1e} s apart, and the wave changes within {shortest:.1e} s; take a shorter way or a shorter wave"
                );
                let is_seen = way == 0.0 || 4.0 * apart <= shortest;
                TEST.require(named("drive.travel_mm"), way, is_seen, coarse)?;
                for (key, value, range) in
                    [("youngs_modulus_mpa", modulus, MODULUS), ("density_t_per_mm3", density, DENSITY)]
                {
                    TEST.require(named(&format!("drive.{key}")), value, range.has(value), range.refusal(value))?;
                }
                let area = area_mm2.unwrap_or(1.0);
                TEST.require(named("drive.area_mm2"), area, (1e-3..=1e8).contains(&area), "it must be 1e-3 to 1e8 mm2")
            }
            Self::Mass { mass_kg, speed_m_per_s: speed } => {
                let met = (MASSES_KG[0]..=MASSES_KG[1]).contains(&mass_kg);
                TEST.require(named("drive.mass_kg"), mass_kg, met, "it must be 1e-6 to 1e6 kg")?;
                Speed::Steady(speed).validate(&named("drive.speed_m_per_s"))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_goes_straight_from_row_to_row_jumps_and_keeps_its_last_value() {
        let speed = Speed::Over(vec![[1.0, 0.0], [2.0, 4.0], [2.0, 1.0], [3.0, 1.0]]);
        let at = [0.0, 1.0, 1.25, 2.0, 9.0].map(|time| speed.at(time));
        assert_eq!(at, [0.0, 0.0, 1000.0, 1000.0, 1000.0]);
        assert_eq!([7.0, -1.0].map(|time| Speed::Steady(-2.0).at(time)), [-2000.0, 0.0]);
        let table = [[0.0, 0.0], [1.0, 0.0], [2.0, 4000.0], [2.25, 1000.0], [3.0, 1000.0]];
        assert_eq!(speed.rows(0.25), table);
        assert_eq!(Speed::Steady(-2.0).rows(0.25), [[0.0, 0.0], [0.25, -2000.0]]);
    }
}
