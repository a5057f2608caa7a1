//! Uniaxial curves of the concrete damaged plasticity model.
//!
//! Compression: fib Model Code 2010, eq. 5.1-26, up to the peak; beyond it exponential softening whose energy per crack
//! band of width h is the crushing energy, so that results do not hang on the element size. Tension: the bilinear
//! stress-crack opening law of fib Model Code 2010, 5.1.8.2, over displacement, which Abaqus spreads over its
//! characteristic length: shorter than a crack band, so that openings are less by as much. Damage beyond the peak:
//! d = 1 - s / f.

use meso_mesh::materials::{Elastic, Strength};

/// A row of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// MPa.
    pub(super) stress: f64,
    /// Inelastic strain, or crack opening in mm.
    pub(super) inelastic: f64,
    /// 0 to 1.
    pub(super) damage: f64,
}

/// The crack band of a mesh's elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Band {
    /// Over which the crushing energy is spent, mm.
    pub(super) width_mm: f64,
    /// Openings in the deck over those of the crack: Abaqus' characteristic length over the width.
    pub(super) opening: f64,
}

const ELASTIC_LIMIT: f64 = Strength::ELASTIC_LIMIT;
/// Rows of the rising branch.
const RISING: usize = 8;

/// The widest crack band's share of the width at which plastic strain would fall: beyond the peak, at the share s of the
/// strength f, it is larger by -ln(s) G / (width f) - (1 - s) f / E, which rises from s = 1 on where G is f^2 width / E.
const SNAP_BACK: f64 = 0.98;

/// Width of the widest crack band that spends its crushing energy, mm; wider ones spend more, as in our engine.
pub(super) fn widest_mm(elastic: &Elastic, strength: &Strength) -> f64 {
    SNAP_BACK * strength.crushing_energy_n_per_mm * elastic.youngs_modulus_mpa / strength.compressive_mpa.powi(2)
}

/// Compression hardening for crack bands `width` mm wide.
pub(super) fn compression(elastic: &Elastic, strength: &Strength, width: f64) -> Vec<Row> {
    let (e, fc) = (elastic.youngs_modulus_mpa, strength.compressive_mpa);
    // The rising branch needs k > 1, a peak strain beyond the elastic one: the limits see to it.
    let peak_strain = strength.peak_strain;
    let k = e * peak_strain / fc;
    let stress = |eta: f64| fc * (k * eta - eta * eta) / (1.0 + (k - 2.0) * eta);
    let start = limit_share(k);
    let mut rows = vec![Row { stress: ELASTIC_LIMIT * fc, inelastic: 0.0, damage: 0.0 }];
    for step in 1..=RISING {
        let eta = start + (1.0 - start) * step as f64 / RISING as f64;
        let inelastic = eta * peak_strain - stress(eta) / e;
        rows.push(Row { stress: stress(eta), inelastic, damage: 0.0 });
    }
    let peak = peak_strain - fc / e;
    let stretch = strength.crushing_energy_n_per_mm / (width.min(widest_mm(elastic, strength)) * fc);
    for share in [0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1, 0.05] {
        rows.push(Row { stress: share * fc, inelastic: peak - libm::log(share) * stretch, damage: 1.0 - share });
    }
    rows
}

/// The inelastic strain at which softening has come to half the compressive strength.
pub(super) fn half_strength_strain(elastic: &Elastic, strength: &Strength, width: f64) -> f64 {
    let rows = compression(elastic, strength, width);
    rows.iter().find(|row| row.damage >= 0.5).map_or(f64::INFINITY, |row| row.inelastic)
}

/// The eta at which the rising branch passes the elastic limit: eta^2 + (L (k - 2) - k) eta + L = 0, the smaller root.
fn limit_share(k: f64) -> f64 {
    let b = ELASTIC_LIMIT * (k - 2.0) - k;
    (-b - (b * b - 4.0 * ELASTIC_LIMIT).sqrt()) / 2.0
}

/// Tension stiffening over crack opening, mm, times `opening`.
pub(super) fn tension(strength: &Strength, opening: f64) -> Vec<Row> {
    let ft = strength.tensile_mpa;
    let w1 = opening * strength.fracture_energy_n_per_mm / ft;
    let share = |w: f64| if w <= 1.0 { 1.0 - 0.8 * w } else { 0.25 - 0.05 * w };
    let row = |w: f64| Row { stress: ft * share(w), inelastic: w * w1, damage: 1.0 - share(w) };
    [0.0, 0.25, 0.5, 0.75, 1.0, 2.0, 3.0, 4.0, 4.8].map(row).to_vec()
}

#[cfg(test)]
mod tests {
    use super::super::LAW;
    use super::*;
    use meso_mesh::cells::{Phase, PhaseNames};
    use meso_mesh::materials::Materials;

    fn energy(rows: &[Row]) -> f64 {
        rows.windows(2).map(|w| (w[0].stress + w[1].stress) / 2.0 * (w[1].inelastic - w[0].inelastic)).sum()
    }

    #[test]
    fn tension_spends_the_fracture_energy() {
        let materials = Materials::default();
        let strength = materials.itz_strength(LAW);
        for opening in [1.0, 0.35] {
            let rows = tension(&strength, opening);
            let spent = energy(&rows) / (opening * strength.fracture_energy_n_per_mm);
            assert!((spent - 1.0).abs() < 0.01, "{rows:?}");
        }
    }

    #[test]
    fn softening_spends_the_crushing_energy_on_any_width() {
        let materials = Materials::default();
        for width in [0.3, 1.0, 3.0] {
            let strength = materials.mortar_strength.of(LAW);
            let rows = compression(&materials.mortar, &strength, width);
            let spent = energy(&rows[RISING..]) * width / strength.crushing_energy_n_per_mm;
            // Points below 5 % of the strength, or within 1 % of the straight lines between rows, are left out.
            assert!((0.94..0.98).contains(&spent), "{spent}");
        }
    }

    #[test]
    fn inelastic_strain_and_damage_rise_and_plastic_strain_never_falls() {
        let materials = Materials::default();
        for phase in [Phase::Mortar, Phase::Itz] {
            let (elastic, strength) = (
                &materials.elastic(phase, PhaseNames::COMMON),
                materials.strength(phase, PhaseNames::COMMON, LAW).unwrap(),
            );
            for (rows, length) in [(compression(elastic, &strength, 2.0), 1.0), (tension(&strength, 0.35), 1.0)] {
                let plastic = |r: &Row| {
                    r.inelastic - r.damage / (1.0 - r.damage) * r.stress / elastic.youngs_modulus_mpa * length
                };
                for pair in rows.windows(2) {
                    assert!(pair[1].inelastic > pair[0].inelastic && pair[1].damage >= pair[0].damage, "{pair:?}");
                    assert!(plastic(&pair[1]) >= plastic(&pair[0]) - 1e-12, "{pair:?}");
                }
            }
        }
    }
}
