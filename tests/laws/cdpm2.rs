//! CDPM2 against closed forms of its equations, in f64 and in the f32 of the solver.

use crate::subject::{Number, along, cdpm2, close, from_peak, inelastic_energy, mortar, peak, slope};
use meso_core::materials::Materials;
use meso_element::law::point::{HeldStress, Reading, curve, ramp};
use meso_element::law::{Law, cdpm2 as law};

const UNIAXIAL: HeldStress = HeldStress::Lateral(0.0);
const E: f64 = 26_000.0;

fn strengths<R: Number>() {
    let of = cdpm2::<R>(&mortar(), &law::Options::default());
    close(peak(&along(&of, UNIAXIAL, &[-0.004], 2e-6)).stress, -40.0, 1e-3);
    close(peak(&along(&of, UNIAXIAL, &[0.0004], 1e-7)).stress, 3.0, 1e-3);
    close(peak(&along(&of, HeldStress::Third(0.0), &[-0.004], 2e-6)).stress, -1.16 * 40.0, 1e-3);
}

#[test]
fn strengths_are_those_given() {
    strengths::<f64>();
    strengths::<f32>();
}

/// On the compressive meridian r is 1, and the surface at its peak (q1 = q2 = 1) is 9 u^2 + m0 (u + s) = 1 with
/// u = (sigma - p) / (3 f_c) and u + s = -p / f_c: the strength under lateral pressure p is p + f_c sqrt(1 + m0 p / f_c).
fn confined<R: Number>() {
    let (fc, ft, fb) = (40.0, 3.0, 46.4);
    let share = ft * (fb * fb - fc * fc) / (fb * (fc * fc - ft * ft));
    let e: f64 = (1.0 + share) / (2.0 - share);
    let m0 = 3.0 * (fc * fc - ft * ft) / (fc * ft) * e / (e + 1.0);
    for pressure in [5.0, 10.0, 20.0] {
        let strength = pressure + fc * (1.0 + m0 * pressure / fc).sqrt();
        // H_p raises it further as plastic strain grows.
        let of = cdpm2::<R>(&mortar(), &law::Options { hardening_modulus: 0.0, ..Default::default() });
        close(peak(&along(&of, HeldStress::Lateral(-pressure), &[-0.04], 1e-5)).stress, -strength, 1e-3);
    }
}

#[test]
fn confined_strength_is_the_surfaces_closed_form() {
    confined::<f64>();
    confined::<f32>();
}

/// Both laws begin at the peak: hardening before it is plastic strain beside them, in tension 3e-4 of G_f per mm of width.
/// The crack law ends at w_f; the stress beyond is the least integrity's. The exponential one has 6e-6 beyond 12 widths.
fn energies<R: Number>(width: f64, options: &law::Options) {
    let of = cdpm2::<R>(&mortar(), options);
    let spent = |peak_within: f64, end: f64, step: f64| {
        let steps = |length: f64, step: f64| (length.abs() / step).ceil() as usize;
        let rise = ramp(0.0, peak_within, steps(peak_within, 0.1 * step));
        let strains: Vec<f64> = rise.chain(ramp(peak_within, end, steps(end - peak_within, step))).collect();
        inelastic_energy(from_peak(&curve(&of, width, UNIAXIAL, &strains)), E, width)
    };
    close(spent(2e-4, 0.06 / (0.225 * 3.0) / width, 1e-5), 0.06, 1e-3);
    close(spent(-0.003, -(0.003 + 12.0 * 0.5 / 40.0 / width), 1e-5), 0.5, 1e-3);
}

#[test]
fn both_energies_are_spent_on_any_width() {
    let rigid = law::Options { hardening_modulus: 0.0, ..Default::default() };
    energies::<f64>(2.0, &rigid);
    for width in [0.5, 2.0, 6.0] {
        energies::<f64>(width, &law::Options::default());
        energies::<f32>(width, &law::Options::default());
    }
}

fn stiffness<R: Number>() {
    let of = cdpm2::<R>(&mortar(), &law::Options::default());
    for (corners, side) in [([0.001, 0.00096], 0), ([0.005, 0.00492], 0), ([-0.006, -0.0055], 1), ([-0.02, -0.0192], 1)]
    {
        let path = along(&of, UNIAXIAL, &corners, 1e-5);
        let turn = path.iter().position(|s| s.strain == corners[0]).unwrap();
        let damage = path[turn].damage[side];
        assert!((0.3..0.999).contains(&damage), "{damage}");
        close(slope([path[turn], path[path.len() - 1]]), (1.0 - damage) * E, 1e-3);
    }
}

#[test]
fn unloading_is_as_stiff_as_damage_leaves_it() {
    stiffness::<f64>();
    stiffness::<f32>();
}

/// Slope from the first to the last sample with a stress between `low` and `high`.
fn between(curve: &[Reading], low: f64, high: f64) -> f64 {
    let within: Vec<Reading> = curve.iter().copied().filter(|s| (low..high).contains(&s.stress)).collect();
    slope([within[0], within[within.len() - 1]])
}

/// A closed crack is sound in compression; crushed mortar keeps its tensile damage in tension.
fn recovery<R: Number>() {
    let of = cdpm2::<R>(&mortar(), &law::Options::default());
    let closed = along(&of, UNIAXIAL, &[0.001, -0.004], 1e-6);
    let opened = closed[999].damage[0];
    assert!(opened > 0.3, "{opened}");
    let pressed = closed.iter().position(|s| s.strain < 0.0 && s.stress < -10.0).unwrap();
    close(between(&closed[1000..=pressed], -10.0, -0.5), E, 1e-3);
    close(peak(&closed).stress, -40.0, 1e-3);
    let crushed = along(&of, UNIAXIAL, &[-0.01, -0.0075], 4e-6);
    let turn = crushed.iter().position(|s| s.strain == -0.01).unwrap();
    let left = 1.0 - crushed[turn].damage[0];
    assert!((0.3..0.95).contains(&left), "{left}");
    close(between(&crushed[turn..], 0.05, 0.9 * 3.0 * left), left * E, 1e-3);
}

#[test]
fn stiffness_comes_back_in_compression_and_not_in_tension() {
    recovery::<f64>();
    recovery::<f32>();
}

#[test]
fn a_band_too_wide_is_named() {
    let of = cdpm2::<f64>(&mortar(), &law::Options::default());
    // The crack law's first piece: 0.15 w_f E / (0.7 f_t); crushing: E G_c / f_c^2.
    let cracking = 0.98 * 0.15 * (0.06 / 0.675) * E / (0.7 * 3.0);
    let [cracked, crushed] = Law::<f64>::widest_mm(&of);
    close(cracked, cracking, 1e-9);
    close(crushed, 0.98 * 8.125, 1e-9);
    let given = law::Options { crushing_strain: Some(1e-4), ..Default::default() };
    // A crushing strain needs no width.
    let [cracked, crushed] = Law::<f64>::widest_mm(&cdpm2::<f64>(&mortar(), &given));
    close(cracked, cracking, 1e-9);
    assert!(crushed.is_infinite());
}

#[test]
fn values_that_cannot_be_are_named() {
    let with = |options: law::Options| Materials { cdpm2: options, ..mortar() };
    assert!(law::validate(&mortar()).is_ok());
    let error = |options: law::Options| law::validate(&with(options)).unwrap_err().to_string();
    let usual = law::Options::default();
    let refused = error(law::Options { dilation: 0.5, ..usual });
    assert!(refused.contains("cdpm2.dilation is 0.5; it must be 0.55 to 2"), "{refused}");
    let refused = error(law::Options { hardening_ductility: [0.002, 0.003, 2.0, 1e-6], ..usual });
    assert!(refused.contains("cdpm2.hardening_ductility[0] is 0.002"), "{refused}");
    let refused = error(law::Options { crushing_strain: Some(f64::NAN), ..usual });
    assert!(refused.contains("cdpm2.crushing_strain is NaN"), "{refused}");
    let refused = error(law::Options { hardening_modulus: 0.0, ..usual });
    assert!(refused.contains("cdpm2.hardening_modulus is 0; it must be 0.01 to 0.1"), "{refused}");
    let mut materials = mortar();
    materials.plasticity.biaxial_ratio = 1.0;
    let refused = law::validate(&materials).unwrap_err().to_string();
    assert!(refused.contains("plasticity.biaxial_ratio is 1; it must lie above 1"), "{refused}");
}

/// Case H_p = 0 of the report on the curve: a cube of 36 mm carried 45.6 MPa and 36.1 MPa with 0.01. A lateral tension of
/// half a MPa is 1/6400 of the squares of the principal stresses.
#[test]
fn crushing_under_a_little_lateral_tension_needs_hardening_beyond_the_peak() {
    let crushed = |hardening_modulus: f64| {
        let of = cdpm2::<f64>(&mortar(), &law::Options { hardening_modulus, ..Default::default() });
        along(&of, HeldStress::Lateral(0.5), &[-0.008], 1e-5).last().unwrap().damage[1]
    };
    assert_eq!(crushed(0.0), 0.0);
    assert!(crushed(0.01) > 0.5, "{}", crushed(0.01));
}
