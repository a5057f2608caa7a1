//! The law `meso` against an oracle of other arithmetic, and the properties that it promises.

use crate::subject::{Number, along, close, peak};
use meso_core::materials::{Materials, Mesoscale, Strength};
use meso_element::law::point::{HeldStress, ramp, work};
use meso_element::law::{Law, LawName, Meso, Rated, Scaled, Tensor};
use meso_element::real::Real;
use std::path::Path;

/// Crack band of the oracle, mm.
const WIDTH: f64 = 4.0;

/// Values of `tests/oracles/meso.py`.
fn values() -> Materials {
    let mut materials = Materials::default();
    materials.mortar.youngs_modulus_mpa = 20_000.0;
    materials.mortar_strength = Strength {
        compressive_mpa: 40.0,
        peak_strain: 0.003,
        tensile_mpa: 3.5,
        fracture_energy_n_per_mm: 0.08,
        crushing_energy_n_per_mm: 1.5,
    }
    .into();
    materials.meso = Mesoscale {
        biaxial_ratio: 1.16,
        meridian_ratio: 2.0 / 3.0,
        meridian_bend: 0.8,
        dilation_angle_deg: 30.0,
        confined_ductility: 10.0,
        crushing_length_mm: 5.0,
    };
    materials
}

pub(crate) fn meso<R: Real>() -> Meso<R> {
    law(&values())
}

/// The law with strengths that grow with the rate of strain, in steps of `dt_s`.
pub(crate) fn rated<R: Real>(dt_s: f64) -> Rated<R> {
    let of = values();
    Rated::new(&of.mortar, &of.mortar_strength.of(LawName::Meso), &of.meso, [dt_s, 1.0])
}

/// Largest factor of strengths that scatter.
const MOST: f64 = 2.0;

/// The law with strengths that scatter: of 9 registers, or of 11 if they grow, too, in steps of `dt_s`.
pub(crate) fn scattered<R: Real, const N: usize>(dt_s: f64) -> Scaled<R, N> {
    let of = values();
    Scaled::new(&of.mortar, &of.mortar_strength.of(LawName::Meso), &of.meso, [dt_s, MOST])
}

/// The law without scatter, of a mortar that is `factor` as strong; of 10 registers if its strengths grow.
pub(crate) fn as_strong<const N: usize>(factor: f64, dt_s: f64) -> (Meso<f64>, Scaled<f64, N>) {
    let of = values();
    let usual = of.mortar_strength.of(LawName::Meso);
    let strength = Strength {
        compressive_mpa: factor * usual.compressive_mpa,
        peak_strain: factor * usual.peak_strain,
        tensile_mpa: factor * usual.tensile_mpa,
        fracture_energy_n_per_mm: factor * usual.fracture_energy_n_per_mm,
        crushing_energy_n_per_mm: factor * usual.crushing_energy_n_per_mm,
    };
    let own = &of.meso;
    (Meso::new(&of.mortar, &strength, own), Scaled::new(&of.mortar, &strength, own, [dt_s, 1.0]))
}

/// The mortar of the defaults, but for its biaxial ratio.
pub(crate) fn with_biaxial_ratio(biaxial_ratio: f64) -> Meso<f64> {
    let usual = Materials::default();
    law(&Materials { meso: Mesoscale { biaxial_ratio, ..usual.meso }, ..usual })
}

fn law<R: Real>(of: &Materials) -> Meso<R> {
    Meso::new(&of.mortar, &of.mortar_strength.of(LawName::Meso), &of.meso)
}

/// Strain, then stress, xx yy zz xy yz zx.
type Row = [f64; 12];

fn rows(name: &str) -> Vec<Row> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/oracles/meso");
    let text = std::fs::read_to_string(folder.join(format!("{name}.csv"))).unwrap();
    let row = |line: &str| -> Row {
        line.split(',').map(|cell| cell.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap()
    };
    text.lines().skip(2).map(row).collect()
}

/// Steps of the oracle from one row to the next, and of paths whose sides bend as a crack begins.
const STEPS: [usize; 2] = [50, 5];

/// Largest distance of a stress from the oracle's along its own strains, over the largest stress of the path.
fn error<R: Number>(name: &str, steps: usize) -> f64 {
    let law = meso::<R>();
    let (mut history, mut from) = (Meso::<R>::virgin(), [0.0; 6]);
    let (mut apart, mut size) = (0.0_f64, 0.0_f64);
    for row in rows(name) {
        let to: Tensor<f64> = row[..6].try_into().unwrap();
        let mut stress = [R::splat(0.0); 6];
        for share in ramp(0.0, 1.0, steps) {
            let strain = std::array::from_fn(|i| R::splat(from[i] + (to[i] - from[i]) * share));
            stress = law.stress(&strain, &mut history, R::splat(WIDTH)).stress;
        }
        for (own, theirs) in stress.into_iter().zip(&row[6..]) {
            apart = apart.max((own.into() - theirs).abs());
            size = size.max(theirs.abs());
        }
        from = to;
    }
    apart / size
}

#[test]
fn stress_follows_an_oracle_of_other_arithmetic() {
    let [far, close] = STEPS;
    for (names, within, steps) in [
        (&["wander", "crush", "ended"][..], 5e-5, far),
        // Between rows the engine's sides go straight, and the oracle's bend.
        (&["tension", "cracked_crushed_cracked"][..], 5e-4, close),
        (&["compression", "biaxial", "crushed_unloaded_crushed"][..], 1e-3, far),
        (&["confined_5", "confined_10"][..], 1e-3, far),
    ] {
        for name in names {
            let (fine, coarse) = (error::<f64>(name, steps), error::<f32>(name, steps));
            assert!(fine < within && coarse < within, "{name}: {fine} in f64, {coarse} in f32");
        }
    }
}

/// Largest stress along x with these stresses held, MPa, and the strain there.
fn strength(held: HeldStress, to: f64) -> [f64; 2] {
    let top = peak(&along(&meso::<f64>(), held, &[to], 5e-6));
    [top.stress.abs(), top.strain.abs()]
}

#[test]
fn strengths_are_those_of_tests() {
    close(strength(HeldStress::Lateral(0.0), -0.006)[0], 40.0, 1e-3);
    close(strength(HeldStress::Lateral(0.0), 0.0005)[0], 3.5, 1e-3);
    close(strength(HeldStress::Third(0.0), -0.006)[0], 1.16 * 40.0, 1e-3);
    // Richart et al. 1928: f + 4.1 p.
    for pressure in [5.0, 10.0] {
        close(strength(HeldStress::Lateral(-pressure), -0.02)[0], 40.0 + 4.1 * pressure, 0.04);
    }
}

#[test]
fn default_mortar_gains_less_from_pressure_than_confined_concrete_by_20_percent_at_most() {
    let own = law::<f64>(&Materials::default());
    for pressure in [5.0, 10.0] {
        let top = peak(&along(&own, HeldStress::Lateral(-pressure), &[-0.02], 5e-6)).stress.abs();
        let free = Materials::default().mortar_strength.of(LawName::Meso).compressive_mpa;
        let richart = free + 4.1 * pressure;
        assert!((0.8..1.0).contains(&(top / richart)), "{top} beside {richart}");
    }
}

#[test]
fn confinement_makes_crushing_cost_more() {
    let work = |pressure: f64| {
        let curve = along(&meso::<f64>(), HeldStress::Lateral(-pressure), &[-0.04], 2e-5);
        let free = curve.iter().find(|sample| sample.damage[1] > 0.5).unwrap();
        free.strain.abs()
    };
    assert!(work(5.0) > 1.8 * work(0.0) && work(10.0) > 2.6 * work(0.0), "{} {} {}", work(0.0), work(5.0), work(10.0));
}

#[test]
fn crushed_mortar_keeps_friction_and_stops_dilating() {
    let pressure = 5.0;
    let curve = along(&meso::<f64>(), HeldStress::Lateral(-pressure), &[-0.3], 5e-5);
    let end = curve[curve.len() - 1];
    // The cone of K_c = 2/3 has 4.83 p at low pressure and bends with it.
    close(end.stress.abs(), 4.45 * pressure, 0.02);
    let volume = |at: usize| curve[at].strain + 2.0 * curve[at].lateral_strain;
    let (last, before) = (curve.len() - 1, curve.len() - 1001);
    assert!((volume(last) - volume(before)).abs() < 0.02 * (curve[before].strain - end.strain).abs());
}

/// Stress and integrity of a crack that opens along x to a strain, and further while z is pressed.
fn pressed_along_a_crack(to: f64) -> (Tensor<f64>, f64) {
    let law = meso::<f64>();
    let (mut history, mut stress, mut integrity) = (Meso::<f64>::virgin(), [0.0; 6], 1.0);
    for share in ramp(0.0, 1.0, 4000) {
        let along = 0.8 * to * share + 0.2 * to * (2.0 * share - 1.0).max(0.0);
        let answer = law.stress(&[along, 0.0, -0.0024 * (share - 0.5).max(0.0), 0.0, 0.0, 0.0], &mut history, WIDTH);
        (stress, integrity) = (answer.stress, answer.integrity);
    }
    (stress, integrity)
}

#[test]
fn an_open_crack_carries_no_tension_under_compression_along_it() {
    // The law ends at an opening of 5 G_f / f_t = 0.114 mm, a strain of 0.0286 here.
    let (stress, integrity) = pressed_along_a_crack(0.027);
    assert!(stress[0].abs() < 0.06 && stress[2] < -20.0 && integrity == 1.0, "{stress:?} {integrity}");
}

/// The case: tetrahedra across a crack locked, so that beams and bars of `meso` dissipated 1.4 to 1.9 G_f.
#[test]
fn a_crack_that_is_wider_than_its_law_takes_the_stiffness_with_it() {
    let (stress, integrity) = pressed_along_a_crack(0.04);
    assert!(integrity < 1.1e-3 && stress.iter().all(|s| s.abs() < 0.05), "{stress:?} {integrity}");
}

#[test]
fn energies_are_those_asked_for_on_every_width() {
    let materials = values();
    let Strength { fracture_energy_n_per_mm: gf, crushing_energy_n_per_mm: gc, .. } =
        materials.mortar_strength.of(LawName::Meso);
    for width in [2.0, 4.0, 8.0] {
        let strains: Vec<f64> = ramp(0.0, 0.5 / width, 40_000).collect();
        let cracked = meso_element::law::point::curve(&meso::<f64>(), width, HeldStress::Lateral(0.0), &strains);
        close(width * work(&cracked), gf, 0.04);
        let strains: Vec<f64> = ramp(0.0, -0.035, 14_000).collect();
        let crushed = meso_element::law::point::curve(&meso::<f64>(), width, HeldStress::Lateral(0.0), &strains);
        let top = crushed.iter().position(|sample| *sample == peak(&crushed)).unwrap();
        // Elastic energy of the peak is given back, but for the part that goes with the stiffness: up to a fifth of G_c here.
        let elastic = 0.5 * 40.0 * 40.0 / 20_000.0;
        // Elements below the crushing length share its curve.
        close(width.max(5.0) * (work(&crushed[top..]).abs() + elastic), gc, 0.2);
    }
}

/// The case: mortar lost 7 MPa for each MPa of lateral tension, as concrete does, and its grains cost it strength again.
#[test]
fn friction_is_one_for_both_signs_of_the_largest_stress() {
    let own = law::<f64>(&Materials::default());
    let at = |side: f64| peak(&along(&own, HeldStress::Lateral(side), &[-0.006], 5e-6)).stress.abs();
    // 1 + gamma = 2.909 with K_c of 0.72; the meridian bends under pressure, and nothing bends it under tension.
    close(at(0.0) - at(0.5), 0.5 * 2.909, 0.02);
    close(at(-0.5) - at(0.0), 0.5 * 2.909, 0.02);
    close(peak(&along(&own, HeldStress::Third(0.0), &[-0.006], 5e-6)).stress.abs(), 33.0, 1e-3);
}

#[test]
fn a_biaxial_ratio_below_1_is_refused_with_its_reason_and_so_are_values_that_are_no_numbers() {
    let refused = |change: fn(&mut Mesoscale)| {
        let mut materials = Materials::default();
        change(&mut materials.meso);
        meso_element::law::meso::validate(&materials).unwrap_err().to_string()
    };
    let text = refused(|own| own.biaxial_ratio = 0.94);
    assert!(text.contains("meso.biaxial_ratio is 0.94; it must be 1 to 2") && text.contains("return energy"), "{text}");
    for change in [
        (|own| own.biaxial_ratio = f64::NAN) as fn(&mut Mesoscale),
        |own| own.meridian_bend = f64::NAN,
        |own| own.meridian_bend = -0.1,
        |own| own.meridian_ratio = f64::NAN,
        |own| own.dilation_angle_deg = f64::NAN,
    ] {
        assert!(refused(change).contains("it must"), "{}", refused(change));
    }
}
