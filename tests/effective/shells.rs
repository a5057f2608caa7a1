//! Properties of grains with nested shells, against the exact sphere that stands for a coated one.

use crate::bodies::{aggregate, cube, entry, phases, sphere};
use meso_concrete::{Parts, PhaseNames};
use meso_core::Silent;
use meso_core::aggregate::{Aggregate, Shell};
use meso_core::math::Vec3;
use meso_core::specimen::Specimen;
use meso_effective::{
    EffectiveOptions, GivenModuli, PhaseModuli, Phases, Property, StiffnessOptions, effective, effective_in_tetrahedra,
    stiffness,
};
use std::borrow::Cow;

const SIDE: f64 = 20.0;
const RADIUS: f64 = 8.0;

/// A ball in a periodic cube, with shells of some thicknesses, whose phases are called `a`, `b` and so on.
fn coated<'a>(specimen: &'a Specimen, thicknesses: &[f64]) -> Parts<'a> {
    let shell = |(own, &thickness_mm): (usize, &f64)| Shell { own: own as u8, thickness_mm };
    let body = aggregate(sphere(Vec3::repeat(SIDE / 2.0 + 0.1), RADIUS, 3), 0.0);
    let body = Aggregate { shells: thicknesses.iter().enumerate().map(shell).collect(), ..body };
    let names: PhaseNames = (0..thicknesses.len()).map(name).collect();
    Parts { bodies: Cow::Owned(vec![body]), specimen, phases: names }
}

fn name(own: usize) -> String {
    char::from(b'a' + own as u8).to_string()
}

fn values(core: f64, shells: &[f64]) -> Phases {
    let mut values = phases(1.0, core, 1.0);
    values.diffusivity.own = shells.iter().enumerate().map(|(own, value)| (name(own), Some(*value))).collect();
    values
}

fn diffusivity(thicknesses: &[f64], core: f64, shells: &[f64], h: f64) -> f64 {
    let (specimen, options) = (cube(SIDE, true), EffectiveOptions::new(Property::Diffusivity, h));
    let found = effective(coated(&specimen, thicknesses), &values(core, shells), &options, &Silent).unwrap().0;
    entry(&found, 0, 0)
}

/// Value of the sphere that stands for a core of radius `core_mm` with shells of these outer radii and values, from inside
/// (Hashin 1962, applied shell by shell).
fn equivalent(core: (f64, f64), shells: &[(f64, f64)]) -> f64 {
    let (mut radius, mut inside) = core;
    for &(outer, value) in shells {
        let share = (radius / outer).powi(3);
        let polarity = (inside - value) / (inside + 2.0 * value);
        inside = value * (1.0 + 2.0 * share * polarity) / (1.0 - share * polarity);
        radius = outer;
    }
    inside
}

#[test]
fn a_ball_with_three_shells_is_worth_its_equivalent_ball() {
    let (thicknesses, shells) = ([1.5, 1.0, 0.8], [3.0, 0.2, 6.0]);
    let outer = [RADIUS - 2.5, RADIUS - 1.5, RADIUS];
    let equal = equivalent((RADIUS - 3.3, 0.5), &[(outer[0], 6.0), (outer[1], 0.2), (outer[2], 3.0)]);
    let [with, alone] = [diffusivity(&thicknesses, 0.5, &shells, 0.5), diffusivity(&[], equal, &[], 0.5)];
    let mortar_alone = 1.0;
    assert!((with / alone - 1.0).abs() < 0.01, "{with} {alone}");
    assert!((alone - mortar_alone).abs() > 0.05, "a ball of the mortar's value would show nothing: {alone}");
}

#[test]
fn shells_of_equal_values_are_worth_one_thick_shell() {
    let one = diffusivity(&[2.0], 0.1, &[3.0], 1.0);
    let four = diffusivity(&[0.5; 4], 0.1, &[3.0; 4], 1.0);
    assert!((four / one - 1.0).abs() < 1e-6, "{four} {one}");
    let stiff = |thicknesses: &[f64]| {
        let given = |own: usize| {
            let moduli = GivenModuli { youngs_modulus_mpa: Some(8e3), poisson_ratio: Some(0.25), eigenstrain: None };
            (name(own), moduli)
        };
        let moduli = PhaseModuli { own: (0..thicknesses.len()).map(given).collect(), ..PhaseModuli::default() };
        let specimen = cube(SIDE, true);
        let parts = coated(&specimen, thicknesses);
        stiffness(parts, &moduli, &StiffnessOptions::new(1.0), &Silent).unwrap().0.tensor[0][0]
    };
    let [one, four] = [stiff(&[2.0]), stiff(&[0.5; 4])];
    assert!((four / one - 1.0).abs() < 1e-3, "{four} {one}");
}

#[test]
fn shares_of_shells_are_their_volumes_and_tetrahedra_and_closed_shells_are_refused() {
    let (specimen, options) = (cube(SIDE, true), EffectiveOptions::new(Property::Diffusivity, 2.0));
    let found = effective(coated(&specimen, &[2.0, 1.0]), &values(0.1, &[3.0, 2.0]), &options, &Silent).unwrap().0;
    let body = sphere(Vec3::zeros(), RADIUS, 3);
    let inside = |depth: f64| body.inward_offset(depth).unwrap().unwrap().volume() / SIDE.powi(3);
    let exact = [inside(3.0), inside(0.0) - inside(2.0), inside(2.0) - inside(3.0)];
    for (place, exact) in [2, 5, 6].into_iter().zip(exact) {
        assert!((found.phases[place].volume_fraction - exact).abs() < 1e-12, "{:?}", found.phases);
    }
    let tetrahedra = effective_in_tetrahedra(coated(&specimen, &[1.0]), &values(0.1, &[3.0]), &options, 2.0, &Silent);
    assert!(tetrahedra.err().unwrap().to_string().contains("take voxel"));
    let closed = effective(coated(&specimen, &[1.0]), &values(0.1, &[0.0]), &options, &Silent);
    assert!(closed.err().unwrap().to_string().contains("diffusivity.a is 0; a shell lets something pass"));
}
