//! Spheres in cubic arrays, few spheres, coated spheres.

use crate::bodies::{aggregate, cube, entry, phases, solve, sphere};
use meso_core::aggregate::Aggregate;
use meso_core::math::Vec3;
use meso_effective::Effective;
use std::f64::consts::PI;

/// A sphere in the middle of nothing in a periodic cube of 10 mm.
fn body(radius: f64, thickness: f64) -> Aggregate {
    aggregate(sphere(Vec3::new(5.1, 4.8, 5.3), radius, 4), thickness)
}

fn array(radius: f64, value: f64, h: f64) -> Effective {
    solve(&[body(radius, 0.0)], &cube(10.0, true), &phases(1.0, value, 1.0), h)
}

/// Value of a simple cubic array of spheres (McPhedran and McKenzie, Proc. R. Soc. A 359, 1978, 45, equation 28): multipoles of
/// orders 1, 3 and 5, within 1e-4 up to a fraction of 0.4.
pub(crate) fn cubic_array(fraction: f64, value: f64) -> f64 {
    let l = |order: f64| (1.0 - value) / (value + (order + 1.0) / order);
    let f = |power: f64| libm::pow(fraction, power);
    let (l1, l3, l5) = (l(1.0), l(3.0), l(5.0));
    let third = 1.3045 * f(10.0 / 3.0) * l3 / (1.0 - 0.4054 * f(7.0 / 3.0) * l3);
    1.0 - 3.0 * fraction * l1 / (1.0 + fraction * l1 - third * l1 - 0.07231 * f(14.0 / 3.0) * l5 * l1)
}

#[test]
fn spheres_in_a_cubic_array_have_the_published_values() {
    for value in [0.0, 0.3, 3.0, 10.0, 1e4] {
        let (found, exact) = (array(4.0, value, 0.5), cubic_array(4.0 / 3.0 * PI * 0.064, value));
        let diagonal = [0, 1, 2].map(|axis| entry(&found, axis, axis) / exact - 1.0);
        assert!(diagonal.iter().all(|error| error.abs() < 0.005), "{diagonal:?} for {value}");
    }
}

#[test]
fn few_impermeable_spheres_take_one_and_a_half_of_their_volume() {
    let fraction = 4.0 / 3.0 * PI * 0.001;
    let slope = (entry(&array(1.0, 0.0, 0.2), 0, 0) - 1.0) / fraction;
    assert!((slope / -1.5 - 1.0).abs() < 0.01, "{slope}");
}

/// A coated sphere conducts like a homogeneous one of this value: exact (Hashin's coated sphere).
pub(crate) fn coated(core: f64, shell: f64, ratio: f64) -> f64 {
    let c = ratio * ratio * ratio;
    let (sum, difference) = (core + 2.0 * shell, core - shell);
    shell * (sum + 2.0 * c * difference) / (sum - c * difference)
}

#[test]
fn a_thin_conductive_shell_is_exact_at_ten_voxels_a_radius() {
    for (core, shell) in [(0.0, 10.0), (0.0, 50.0), (2.0, 50.0)] {
        let (radius, thickness) = (3.0, 0.03);
        let found = solve(&[body(radius, thickness)], &cube(10.0, true), &phases(1.0, core, shell), 0.3125);
        let exact = cubic_array(4.0 / 3.0 * PI * 0.027, coated(core, shell, 1.0 - thickness / radius));
        let error = entry(&found, 0, 0) / exact - 1.0;
        assert!(error.abs() < 0.01, "{error} for {core}, {shell}");
    }
}

/// Seven voxels a radius: a simple cubic array is within 0.02 % of the bound.
#[test]
fn the_bounds_are_kept() {
    for value in [0.0, 0.1, 2.0, 10.0] {
        let found = array(4.2, value, 0.625);
        let (bounds, d) = (found.bounds, entry(&found, 0, 0));
        let (low, high) = (bounds.hashin_shtrikman_lower, bounds.hashin_shtrikman_upper);
        assert!(d > low && d < high, "{d} is outside {low} to {high} for {value}");
    }
}
