//! Figures of a curve with a gauge of lateral strain: Poisson's ratio, and the stress at which the volume is least.

use crate::march::curve::{Row, lead, peak};
use serde::{Deserialize, Serialize};

/// Lateral figures of a specimen that is pressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Lateral {
    /// Lateral over axial strain from the path's begin to 30 % of the peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub poisson_ratio: Option<f64>,
    /// Lateral strain at the peak, positive where the specimen widens.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lateral_strain_at_peak: Option<f64>,
    /// Stress at which the volume is least, over the peak; beyond it the specimen dilates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_volume_over_peak: Option<f64>,
}

/// Share of the peak at which Poisson's ratio is taken.
const ELASTIC: f64 = 0.3;

impl Lateral {
    /// Figures of `rows`, whose path begins after `lead_s`, with the lateral strain of each; none of a curve without a peak.
    pub fn of(rows: &[Row], lateral: &[f64], lead_s: f64) -> Self {
        let leads = lead(rows, lead_s);
        let (from, origin) = (leads.len().saturating_sub(1), leads.last().map_or(0.0, |row| row.stress_mpa));
        let (rows, lateral) = (&rows[from..], lateral.get(from..).unwrap_or_default());
        let top = peak(rows);
        let all: Vec<(&Row, f64)> = rows.iter().zip(lateral.iter().copied()).collect();
        let Some((highest, at_peak)) = all.get(top).filter(|(row, _)| row.stress_mpa > 0.0) else {
            return Self::default();
        };
        let volume = |(row, lateral): &(&Row, f64)| 2.0 * lateral - row.strain;
        let least = all.iter().min_by(|a, b| volume(a).total_cmp(&volume(b)));
        let (first, start) = all[0];
        let elastic =
            all[..top].iter().find(|(row, _)| row.stress_mpa - origin >= ELASTIC * (highest.stress_mpa - origin));
        let ratio = elastic.map(|(row, lateral)| (lateral - start) / (row.strain - first.strain));
        Self {
            poisson_ratio: ratio.filter(|ratio| ratio.is_finite()),
            lateral_strain_at_peak: Some(*at_peak),
            least_volume_over_peak: least.map(|(row, _)| row.stress_mpa / highest.stress_mpa),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola to the peak at 0.2 %; the sides move out by 0.2 times the strain, and beyond 0.15 % by 1 time as much.
    #[test]
    fn a_specimen_has_its_poisson_ratio_and_is_smallest_where_it_begins_to_dilate() {
        let strains: Vec<f64> = (1..=300).map(|i| 1e-5 * f64::from(i)).collect();
        let stress = |strain: f64| 40.0 * strain / 0.002 * (2.0 - strain / 0.002);
        let rows: Vec<Row> =
            strains.iter().map(|&strain| Row { strain, stress_mpa: stress(strain), ..Row::default() }).collect();
        let lateral: Vec<f64> = strains.iter().map(|strain| 0.2 * strain + 0.8 * (strain - 0.0015).max(0.0)).collect();
        let figures = Lateral::of(&rows, &lateral, 0.0);
        assert!((figures.poisson_ratio.unwrap() - 0.2).abs() < 1e-9, "{figures:?}");
        assert!((figures.lateral_strain_at_peak.unwrap() - 0.0008).abs() < 1e-9, "{figures:?}");
        // 0.75 (2 - 0.75) of the peak.
        assert!((figures.least_volume_over_peak.unwrap() - 0.9375).abs() < 1e-9, "{figures:?}");
        assert_eq!(Lateral::of(&[], &[], 0.0), Lateral::default());
        assert_eq!(Lateral::of(&rows, &[], 0.0), Lateral::default());
    }
}
