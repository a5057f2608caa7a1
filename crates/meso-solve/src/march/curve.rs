//! The stress-strain curve and its figures.

use crate::error::TEST;
use meso_concrete::OutOfRange;
use meso_trial::{Gauge, OF_PLATES, Test};
use serde::{Deserialize, Serialize};

/// A row of the curve: means over the steps since the row before, energies at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Mean axial strain, positive in the test's sense.
    pub strain: f64,
    /// Mean of both plates over the gross section, MPa, positive in the test's sense.
    pub stress_mpa: f64,
    /// Kinetic energy, mJ.
    pub kinetic: f64,
    /// Work of the elements' forces, mJ: stored, dissipated and hourglass energy.
    pub internal: f64,
    /// Work of the plates, mJ.
    pub external: f64,
    /// Dissipated by friction on the plates, mJ.
    pub friction_work: f64,
    /// In and through hourglass modes, mJ.
    pub hourglass: f64,
    /// Dissipated in cracks, crushing and plastic flow, mJ.
    pub dissipated: f64,
    /// Stress on the lower plate, MPa.
    pub stress_bottom_mpa: f64,
    /// Stress on the upper plate, MPa.
    pub stress_top_mpa: f64,
    /// Time, s.
    pub time_s: f64,
}

impl Row {
    /// Names of [`values`](Self::values).
    pub const COLUMNS: [&'static str; 11] = [
        "strain",
        "stress_mpa",
        "kinetic",
        "internal",
        "external",
        "friction_work",
        "hourglass",
        "dissipated",
        "stress_bottom_mpa",
        "stress_top_mpa",
        "time_s",
    ];

    /// Its values, in the order of [`COLUMNS`](Self::COLUMNS).
    pub fn values(&self) -> [f64; 11] {
        [
            self.strain,
            self.stress_mpa,
            self.kinetic,
            self.internal,
            self.external,
            self.friction_work,
            self.hourglass,
            self.dissipated,
            self.stress_bottom_mpa,
            self.stress_top_mpa,
            self.time_s,
        ]
    }

    /// Row of these [`values`](Self::values).
    pub fn from_values(values: [f64; 11]) -> Self {
        let [strain, stress_mpa, kinetic, internal, external, friction_work, hourglass, dissipated, ..] = values;
        let [.., stress_bottom_mpa, stress_top_mpa, time_s] = values;
        Self {
            strain,
            stress_mpa,
            kinetic,
            internal,
            external,
            friction_work,
            hourglass,
            dissipated,
            stress_bottom_mpa,
            stress_top_mpa,
            time_s,
        }
    }
}

/// Checks that no gauge is named like a column that every curve has.
pub(crate) fn validate_columns(test: &Test) -> Result<(), OutOfRange> {
    let is_taken = |name: &&str| Row::COLUMNS.contains(name) || test.is_fast() && OF_PLATES.contains(name);
    let own = test.gauges.iter().map(Gauge::name).find(is_taken);
    own.map_or(Ok(()), |name| Err(TEST.error("gauges.name", name, "the curve has this column; take another name")))
}

/// The columns of the curve after those of every test: gauges, and forces of supports.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Extra {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Values, row by row: means over the steps since the row before.
    pub values: Vec<f64>,
}

impl Extra {
    /// Values of a row.
    pub fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.names.len()..][..self.names.len()]
    }
}

/// Share of the peak whose secant is the modulus.
const SECANT: f64 = 0.3;
/// A curve that falls below this share of its peak has softened.
const SOFTENED: f64 = 0.8;
/// A peak is followed by a fall by this share of it.
const FALL: f64 = 0.005;
/// Share of the peak to which a descending curve means something: CEB-FIP Model Code 1990, 2.1.4.4.1, ends it there.
const DESCENT: f64 = 0.5;

/// Figures of a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Secant to 30 % of the peak, MPa, from the stress and the strain at which the path begins.
    pub modulus_mpa: f64,
    /// Highest stress, MPa.
    pub peak_mpa: f64,
    /// The stress beyond half of the highest from which the curve first falls by 0.5 %, MPa; else the highest. In splitting it
    /// is the strength: the halves may carry more.
    #[serde(default)]
    pub first_peak_mpa: f64,
    /// Strain at the highest stress.
    pub peak_strain: f64,
    /// Stress of the last row, MPa.
    pub stress_at_end_mpa: f64,
    /// Whether the stress fell below 0.8 of the peak.
    pub softened: bool,
}

impl Figures {
    /// Figures of `rows`, whose path begins after `lead_s`; zeros where there are none.
    pub fn of(rows: &[Row], lead_s: f64) -> Self {
        let peak = peak(rows);
        let (Some(top), Some(last)) = (rows.get(peak), rows.last()) else { return Self::default() };
        Self {
            modulus_mpa: secant(begin(rows, lead_s), &rows[..=peak]),
            peak_mpa: top.stress_mpa,
            first_peak_mpa: first_peak(rows, top.stress_mpa),
            peak_strain: top.strain,
            stress_at_end_mpa: last.stress_mpa,
            softened: outermost(&rows[peak..]).any(|(_, row)| row.stress_mpa < SOFTENED * top.stress_mpa),
        }
    }
}

/// The rows of a lead of `lead_s`, before the path begins.
pub(crate) fn lead(rows: &[Row], lead_s: f64) -> &[Row] {
    &rows[..rows.iter().take_while(|row| row.time_s < lead_s).count()]
}

/// The row at which the path begins: the last one of the lead, or the origin.
fn begin(rows: &[Row], lead_s: f64) -> Row {
    lead(rows, lead_s).last().copied().unwrap_or_default()
}

/// The rows whose strain is the largest so far, with their numbers: a path that turns back comes to its envelope again.
pub(crate) fn outermost(rows: &[Row]) -> impl Iterator<Item = (usize, &Row)> {
    let mut largest = f64::NEG_INFINITY;
    rows.iter().enumerate().filter(move |(_, row)| {
        let is_new = row.strain >= largest;
        largest = largest.max(row.strain);
        is_new
    })
}

/// Number of the row with the highest stress, the first of them.
pub(crate) fn peak(rows: &[Row]) -> usize {
    (0..rows.len()).fold(0, |best, i| if rows[i].stress_mpa > rows[best].stress_mpa { i } else { best })
}

/// [`Figures::first_peak_mpa`] of rows whose highest stress is `highest`.
fn first_peak(rows: &[Row], highest: f64) -> f64 {
    let mut top = 0.0_f64;
    for (_, row) in outermost(rows).skip_while(|(_, row)| row.stress_mpa < DESCENT * highest) {
        if row.stress_mpa < (1.0 - FALL) * top {
            break;
        }
        top = top.max(row.stress_mpa);
    }
    top
}

/// The rows before the stress has fallen to half its peak. Beyond, a brittle specimen collapses and its pieces fly.
pub(crate) fn to_half_peak(rows: &[Row]) -> &[Row] {
    let peak = peak(rows);
    let end = outermost(&rows[peak..]).find(|(_, row)| row.stress_mpa < DESCENT * rows[peak].stress_mpa);
    &rows[..end.map_or(rows.len(), |(end, _)| peak + end)]
}

/// Slope from `origin` to where the curve first reaches [`SECANT`] of its last stress, which is its peak, between rows along a
/// straight line.
fn secant(origin: Row, rows: &[Row]) -> f64 {
    let rise = SECANT * (rows.last().map_or(0.0, |top| top.stress_mpa) - origin.stress_mpa);
    let mut before = origin;
    for row in rows.iter().filter(|row| row.time_s > origin.time_s || origin.time_s == 0.0) {
        let (up, along) = (row.stress_mpa - origin.stress_mpa, row.strain - origin.strain);
        if up >= rise && along > 0.0 && rise > 0.0 {
            let t = (origin.stress_mpa + rise - before.stress_mpa) / (row.stress_mpa - before.stress_mpa);
            return rise / (before.strain - origin.strain + t * (row.strain - before.strain));
        }
        before = *row;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_a_parabola() {
        let stress = |strain: f64| 40.0 * (2.0 - strain / 0.002) * strain / 0.002;
        let row =
            |i: i32| Row { strain: 2e-5 * f64::from(i), stress_mpa: stress(2e-5 * f64::from(i)), ..Row::default() };
        let rows: Vec<Row> = (1..=180).map(row).collect();
        let figures = Figures::of(&rows, 0.0);
        assert_eq!((figures.peak_mpa, figures.peak_strain), (40.0, 2e-5 * 100.0));
        assert!(figures.softened && (figures.stress_at_end_mpa - 14.4).abs() < 1e-9, "{figures:?}");
        // 0.3 = x (2 - x) at x = 1 - sqrt(0.7); the secant is 40 (2 - x) / 0.002.
        let exact = 40.0 / 0.002 * (1.0 + 0.7_f64.sqrt());
        assert!((figures.modulus_mpa / exact - 1.0).abs() < 1e-3, "{figures:?}");
    }

    #[test]
    fn the_rows_to_half_the_peak_end_where_the_stress_first_falls_below_it() {
        let rows = |stresses: &[f64]| -> Vec<Row> {
            stresses.iter().map(|&stress_mpa| Row { stress_mpa, ..Row::default() }).collect()
        };
        for (stresses, left) in [
            (&[1.0, 20.0, 40.0, 30.0, 20.0, 19.9, 30.0, 0.0][..], 5),
            (&[1.0, 20.0, 40.0, 30.0], 4),
            (&[1.0, 20.0], 2),
            (&[0.0, 0.0], 2),
            (&[], 0),
        ] {
            assert_eq!(to_half_peak(&rows(stresses)).len(), left, "{stresses:?}");
        }
    }

    #[test]
    fn the_first_peak_is_followed_by_a_fall() {
        let rows = |stresses: &[f64]| -> Vec<Row> {
            let row = |(i, &stress_mpa): (usize, &f64)| Row { strain: i as f64, stress_mpa, ..Row::default() };
            stresses.iter().enumerate().map(row).collect()
        };
        for (stresses, first) in [
            // A dip below half of the highest stress is none, nor is one of a quarter of a percent.
            (&[1.0, 0.5, 20.0, 30.0, 29.0, 40.0, 10.0][..], 30.0),
            (&[1.0, 20.0, 19.95, 40.0, 10.0], 40.0),
            (&[1.0, 20.0], 20.0),
            (&[], 0.0),
        ] {
            assert_eq!(Figures::of(&rows(stresses), 0.0).first_peak_mpa, first, "{stresses:?}");
        }
    }

    #[test]
    fn a_row_survives_its_values() {
        let values: [f64; 11] = std::array::from_fn(|i| i as f64);
        assert_eq!(Row::from_values(values).values(), values);
    }
}
