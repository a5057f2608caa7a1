//! Softening by displacement: beyond the peak a specimen fails in a band, and its height only changes the strain.
//!
//! Van Mier (1984) found one curve of stress over displacement beyond the peak for prisms of 50, 100 and 200 mm.

use crate::march::curve::{Row, outermost, peak};
use serde::{Deserialize, Serialize};

/// Figures of a curve beyond its peak.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BeyondPeak {
    /// Way of the supports from the peak until half of it is left, mm; `None` where it is not reached. A path that turns counts
    /// by its envelope.
    pub displacement_to_half_mm: Option<f64>,
    /// Work of the supports beyond the peak, N/mm: over the gross section, the ligament of a beam or of a sheared prism, or the
    /// plane that splits.
    pub energy_beyond_peak_n_per_mm: f64,
    /// Share of the peak that is left where this work ends: 0.2, or more where the test ends earlier.
    pub energy_beyond_peak_until: f64,
}

/// Share of the peak that ends the displacement.
const HALF: f64 = 0.5;
/// Share of the peak that ends the energy: beyond, what remains is friction of the debris between the plates.
const FIFTH: f64 = 0.2;

impl BeyondPeak {
    /// Figures of `rows`; zeros where there is no peak. Strain times `length_mm` is the way, and stress times `share` the force
    /// over the area that breaks.
    pub fn of(rows: &[Row], length_mm: f64, share: f64) -> Self {
        let falling = rows.get(peak(rows)..).unwrap_or_default();
        let Some(top) = falling.first().filter(|top| top.stress_mpa > 0.0) else { return Self::default() };
        let point = |(_, row): (usize, &Row)| [(row.strain - top.strain) * length_mm, row.stress_mpa];
        let points: Vec<[f64; 2]> = outermost(falling).map(point).collect();
        let to_fifth = until(&points, FIFTH * top.stress_mpa).unwrap_or_else(|| points.clone());
        Self {
            displacement_to_half_mm: until(&points, HALF * top.stress_mpa).and_then(|half| Some(half.last()?[0])),
            energy_beyond_peak_n_per_mm: share * work(&to_fifth),
            energy_beyond_peak_until: to_fifth.last().map_or(0.0, |end| end[1] / top.stress_mpa),
        }
    }
}

/// The falling curve, displacement and stress, until it first reaches `stress`, between rows along a straight line; `None`
/// where it stays above.
fn until(falling: &[[f64; 2]], stress: f64) -> Option<Vec<[f64; 2]>> {
    // The first point is the peak, unless a stress is infinite.
    let end = falling.iter().position(|point| point[1] <= stress).filter(|end| *end > 0)?;
    let ([from, above], [to, below]) = (falling[end - 1], falling[end]);
    let crossing = from + (above - stress) / (above - below) * (to - from);
    let mut kept = falling[..end].to_vec();
    kept.push([crossing, stress]);
    Some(kept)
}

/// Area under a curve of displacement and stress.
fn work(curve: &[[f64; 2]]) -> f64 {
    // A sum of nothing is -0.
    curve.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum::<f64>() + 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle: 40 MPa at 0.2 %, from there down by 200 MPa per mm of a specimen of 100 mm.
    fn triangle(end: f64) -> Vec<Row> {
        let stress =
            |strain: f64| if strain < 0.002 { 20_000.0 * strain } else { 40.0 - 200.0 * 100.0 * (strain - 0.002) };
        let strains = (1..).map(|i| 7e-5 * f64::from(i)).take_while(|strain| *strain < end);
        let mut strains: Vec<f64> = strains.chain([0.002]).collect();
        strains.sort_by(f64::total_cmp);
        strains.into_iter().map(|strain| Row { strain, stress_mpa: stress(strain), ..Row::default() }).collect()
    }

    #[test]
    fn a_triangle_has_its_displacement_and_its_area_beyond_the_peak() {
        let near = |x: f64, y: f64| (x - y).abs() < 1e-9;
        let figures = BeyondPeak::of(&triangle(0.0039), 100.0, 1.0);
        assert!(near(figures.displacement_to_half_mm.unwrap(), 0.1), "{figures:?}");
        // Until 8 MPa, after 0.16 mm.
        assert!(near(figures.energy_beyond_peak_n_per_mm, 0.5 * (40.0 + 8.0) * 0.16), "{figures:?}");
        assert!(near(figures.energy_beyond_peak_until, 0.2), "{figures:?}");
    }

    #[test]
    fn a_curve_that_ends_early_gives_the_energy_until_its_end() {
        let rows = triangle(0.0025);
        let left = rows.last().unwrap().stress_mpa;
        let figures = BeyondPeak::of(&rows, 100.0, 1.0);
        assert_eq!(figures.displacement_to_half_mm, None);
        assert!((figures.energy_beyond_peak_until - left / 40.0).abs() < 1e-12 && left > 20.0, "{figures:?}");
        assert_eq!(BeyondPeak::of(&[], 100.0, 1.0), BeyondPeak::default());
        assert_eq!(BeyondPeak::of(&[Row::default()], 100.0, 1.0), BeyondPeak::default());
    }
}
