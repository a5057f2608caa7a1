//! The mortar that the tests strain, and figures of its curves.

use meso_core::materials::{Materials, Strength};
use meso_element::law::point::{HeldStress, Reading, curve, ramp};
use meso_element::law::{Cdp, Cdpm2, Law, LawName, cdpm2};
use meso_element::real::Real;

/// Crack band of most tests, mm.
pub(crate) const WIDTH: f64 = 2.0;

/// A number that can be looked at.
pub(crate) trait Number: Real + Into<f64> {}
impl<R: Real + Into<f64>> Number for R {}

/// f_c 40, f_t 3 MPa, G_f 0.06, G_c 0.5 N/mm; a value that the defaults may change is set here.
pub(crate) fn mortar() -> Materials {
    let mut materials = Materials::default();
    materials.mortar.youngs_modulus_mpa = 26_000.0;
    materials.mortar_strength = Strength {
        compressive_mpa: 40.0,
        peak_strain: 0.0022,
        tensile_mpa: 3.0,
        fracture_energy_n_per_mm: 0.06,
        crushing_energy_n_per_mm: 0.5,
    }
    .into();
    materials.plasticity.meridian_ratio = 0.8;
    materials
}

pub(crate) fn cdp<R: Real>(materials: &Materials) -> Cdp<R> {
    Cdp::new(&materials.mortar, &materials.mortar_strength.of(LawName::Cdp), &materials.plasticity)
}

pub(crate) fn cdpm2<R: Real>(materials: &Materials, options: &cdpm2::Options) -> Cdpm2<R> {
    let biaxial = materials.plasticity.biaxial_ratio;
    Cdpm2::new(&materials.mortar, &materials.mortar_strength.of(LawName::Cdpm2), biaxial, options)
}

/// Curve along a polygon of strains, in steps of at most `step`.
pub(crate) fn along<R: Number, L: Law<R>>(law: &L, held: HeldStress, corners: &[f64], step: f64) -> Vec<Reading> {
    let mut strains = Vec::new();
    let mut from = 0.0;
    for &to in corners {
        strains.extend(ramp(from, to, ((to - from).abs() / step).ceil() as usize));
        from = to;
    }
    curve(law, WIDTH, held, &strains)
}

/// The sample of largest stress along x, whatever its sign.
pub(crate) fn peak(curve: &[Reading]) -> Reading {
    *curve.iter().max_by(|a, b| a.stress.abs().total_cmp(&b.stress.abs())).unwrap()
}

/// The curve from there on.
pub(crate) fn from_peak(curve: &[Reading]) -> &[Reading] {
    let top = peak(curve);
    &curve[curve.iter().position(|sample| *sample == top).unwrap()..]
}

/// `what` is `expected` but for a share of `within`.
#[track_caller]
pub(crate) fn close(what: f64, expected: f64, within: f64) {
    assert!((what / expected - 1.0).abs() <= within, "{what} instead of {expected}");
}

/// Slope between two neighbours.
pub(crate) fn slope([a, b]: [Reading; 2]) -> f64 {
    (b.stress - a.stress) / (b.strain - a.strain)
}

/// Area under stress over inelastic strain, times the crack band's width, N/mm.
pub(crate) fn inelastic_energy(curve: &[Reading], modulus: f64, width: f64) -> f64 {
    let inelastic = |s: &Reading| s.strain - s.stress / modulus;
    let area = |w: &[Reading]| (w[0].stress + w[1].stress) / 2.0 * (inelastic(&w[1]) - inelastic(&w[0]));
    width * curve.windows(2).map(area).sum::<f64>()
}
