//! Elastic bodies against closed forms: waves, a bar, and the energies along the way.

use crate::samples::Meshed;
use meso_core::materials::Materials;
use meso_core::mesh::Method;
use meso_solve::{LawName, Test, TestKind};

const E: f64 = 20_000.0;
const RHO: f64 = 2.2e-9;

fn materials(poisson_ratio: f64) -> Materials {
    let mut materials = Materials::default();
    materials.mortar.poisson_ratio = poisson_ratio;
    assert_eq!((materials.mortar.youngs_modulus_mpa, materials.mortar.density_t_per_mm3), (E, RHO));
    materials
}

fn elastic() -> Test {
    Test { law: LawName::Elastic, friction: Some(0.0), ..Test::default() }
}

#[test]
fn a_wave_runs_down_a_bar_at_its_speed_and_carries_rho_c_v() {
    for method in [Method::VOXEL, Method::FITTED] {
        let meshed = Meshed::mortar([6.0, 6.0, 120.0], method, 2.0);
        let c = (E / RHO).sqrt();
        let duration = 1.6 * 120.0 / c;
        // Without a Poisson effect the bar is one-dimensional; a short step adds no mass.
        let test = Test {
            strain: Some(1e-4),
            duration_s: Some(duration),
            time_step_s: Some(8e-8),
            ramp: 0.15,
            rows: 1000,
            ..elastic()
        };
        let response = meshed.solve(&materials(0.0), &test);
        assert!(response.result.added_mass_percent < 1e-9, "{}", response.result.added_mass_percent);
        let speed = 1e-4 * 120.0 / (duration * (1.0 - 0.075));
        // Each plate sends half of the stress. The plate below feels its own and then, doubled, the other's: half of that
        // has come with the middle of the ramp.
        let carried = RHO * c * speed;
        let arrived = response.curve.iter().find(|row| row.stress_bottom_mpa > carried).unwrap().time_s;
        let expected = 120.0 / c + 0.075 * duration;
        assert!((arrived / expected - 1.0).abs() < 0.01, "{method:?} {arrived:e} {expected:e}");
        let plateau = response.curve.iter().find(|row| row.time_s > 0.5 * duration).unwrap().stress_top_mpa;
        assert!((plateau / (0.5 * carried) - 1.0).abs() < 0.03, "{method:?} {plateau} {carried}");
    }
}

#[test]
fn a_bar_between_smooth_plates_has_youngs_modulus() {
    for method in [Method::VOXEL, Method::FITTED] {
        let meshed = Meshed::mortar([12.0, 12.0, 24.0], method, 3.0);
        let test = Test { duration_s: Some(6e-4), strain: Some(1e-3), ..elastic() };
        let response = meshed.solve(&materials(0.2), &test);
        let modulus = response.result.figures.stress_at_end_mpa / response.curve.last().unwrap().strain;
        assert!((modulus / E - 1.0).abs() < 1e-3, "{method:?} {modulus}");
        assert!(response.result.energy_balance_error < 1e-3, "{:?}", response.result);
        // All energy is elastic: half of stress times strain.
        let row = response.curve.last().unwrap();
        let stored = 0.5 * row.stress_mpa * row.strain * 12.0 * 12.0 * 24.0;
        assert!((row.internal / stored - 1.0).abs() < 0.01, "{} {stored}", row.internal);
        assert!(row.dissipated == 0.0 && row.hourglass.abs() < 1e-4 * row.internal, "{row:?}");
    }
}

#[test]
fn rough_plates_hold_the_ends_and_smooth_ones_let_them_go() {
    let meshed = Meshed::mortar([12.0, 12.0, 12.0], Method::VOXEL, 2.0);
    let modulus = |friction: f64| {
        let test = Test { friction: Some(friction), strain: Some(1e-3), duration_s: Some(3e-4), ..elastic() };
        let response = meshed.solve(&materials(0.3), &test);
        (response.result.figures.modulus_mpa, response.curve.last().unwrap().friction_work)
    };
    let ((smooth, none), (some, rubbed), (rough, held)) = (modulus(0.0), modulus(0.1), modulus(5.0));
    assert!(smooth < some && some < rough, "{smooth} {some} {rough}");
    assert!(none.abs() < 1e-12 && rubbed > 0.0 && held.abs() < 0.02 * rubbed, "{none} {rubbed} {held}");
}

#[test]
fn a_bar_glued_to_its_plates_keeps_its_energy_balance_to_rounding() {
    // Nothing strikes: the work of a step equals the energy that it adds.
    for method in [Method::VOXEL, Method::FITTED] {
        let meshed = Meshed::mortar([6.0, 6.0, 12.0], method, 3.0);
        let test =
            Test { kind: TestKind::Tension, strain: Some(1e-3), duration_s: Some(2e-4), friction: None, ..elastic() };
        let result = meshed.solve(&materials(0.2), &test).result;
        assert!(result.energy_balance_error < 1e-10, "{method:?}: {}", result.energy_balance_error);
    }
}

/// Case `ramp.py`: with ramp = 1 no row lay after the ramp, and a test at the speed of sound had no error.
#[test]
fn a_ramp_as_long_as_the_test_does_not_hide_its_speed() {
    let meshed = Meshed::mortar([6.0; 3], Method::FITTED, 3.0);
    let result = |ramp, duration_s| {
        let test = Test { law: LawName::Elastic, ramp, duration_s: Some(duration_s), ..Test::default() };
        meshed.solve(&Materials::default(), &test).result
    };
    for ramp in [0.3, 0.9, 0.99, 1.0] {
        let fast = result(ramp, 4e-6);
        assert!(fast.kinetic_over_internal_max > 0.05, "{ramp}: {}", fast.kinetic_over_internal_max);
        assert!(fast.errors.iter().any(|error| error.contains("kinetic energy")), "{ramp}: {:?}", fast.errors);
        let slow = result(ramp, 3e-4);
        assert!(slow.kinetic_over_internal_max < 0.01 && slow.errors.is_empty(), "{ramp}: {:?}", slow.errors);
    }
}
