//! Properties of grains with nested shells, against the exact sphere that stands for a coated one.

use crate::bodies::{aggregate, cube, entry, phases, sphere};
use crate::dents::angle;
use meso_concrete::{Parts, PhaseNames};
use meso_core::Silent;
use meso_core::aggregate::{Aggregate, Shell};
use meso_core::geometry::{Polyhedron, Round};
use meso_core::math::Vec3;
use meso_core::specimen::Specimen;
use meso_effective::{
    EffectiveOptions, GivenModuli, PhaseModuli, Phases, Property, StiffnessOptions, effective, effective_in_tetrahedra,
    stiffness, stiffness_in_tetrahedra,
};
use std::borrow::Cow;

const SIDE: f64 = 20.0;
const RADIUS: f64 = 8.0;

/// A ball in a periodic cube, with shells of some thicknesses, whose phases are called `a`, `b` and so on.
fn coated<'a>(specimen: &'a Specimen, thicknesses: &[f64]) -> Parts<'a> {
    coated_body(specimen, sphere(Vec3::repeat(SIDE / 2.0 + 0.1), RADIUS, 3), thicknesses)
}

fn coated_body<'a>(specimen: &'a Specimen, body: Polyhedron, thicknesses: &[f64]) -> Parts<'a> {
    let shell = |(own, &thickness_mm): (usize, &f64)| Shell { own: own as u8, thickness_mm, outward: false };
    let body = aggregate(body, 0.0);
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

/// Value of the sphere that stands for a core with a shell whose value at the radius r is `law(r)`.
///
/// With Y = k r f' / f for a potential f(r) cos(theta), (r^2 k f')' = 2 k f becomes Y' = (2 k - Y - Y^2 / k) / r, and a ball of
/// the value Y is alike from outside. Integrated by the classical method of Runge and Kutta, in 4,000 steps.
fn graded(core: (f64, f64), outer: f64, law: impl Fn(f64) -> f64) -> f64 {
    let slope = |r: f64, y: f64| (2.0 * law(r) - y - y * y / law(r)) / r;
    let (mut r, mut y, steps) = (core.0, core.1, 4000);
    let h = (outer - core.0) / f64::from(steps);
    for _ in 0..steps {
        let a = slope(r, y);
        let b = slope(r + 0.5 * h, y + 0.5 * h * a);
        let c = slope(r + 0.5 * h, y + 0.5 * h * b);
        let d = slope(r + h, y + h * c);
        (r, y) = (r + h, y + h / 6.0 * (a + 2.0 * b + 2.0 * c + d));
    }
    y
}

#[test]
fn a_gradient_in_1_4_and_16_shells_nears_its_differential_equation_at_least_as_1_over_n() {
    const THICK: f64 = 4.0;
    let core = (RADIUS - THICK, 0.02);
    let law = |r: f64| 4.0 * libm::pow(r / RADIUS, 4.0);
    let exact = graded(core, RADIUS, law);
    // One value is one shell, in the equation as in Hashin's formula.
    assert!((graded(core, RADIUS, |_| 3.0) / equivalent(core, &[(RADIUS, 3.0)]) - 1.0).abs() < 1e-9);
    let alone = diffusivity(&[], exact, &[], 0.5);
    let [one, four, sixteen] = [1, 4, 16].map(|n: u32| {
        let own = THICK / f64::from(n);
        // From outside, each with the value at the middle of its depth.
        let shells: Vec<f64> = (0..n).map(|i| law(RADIUS - (f64::from(i) + 0.5) * own)).collect();
        let outer = (0..n).rev().map(|i| RADIUS - f64::from(i) * own);
        let ball = equivalent(core, &outer.zip(shells.iter().rev().copied()).collect::<Vec<_>>());
        let polarity = |value: f64| (value - 1.0) / (value + 2.0);
        let found = diffusivity(&vec![own; n as usize], core.1, &shells, 0.5) / alone - 1.0;
        let formula = polarity(ball) / polarity(exact) - 1.0;
        [found.abs(), formula.abs()]
    });
    // Voxels of 0.5 mm, which are two of the thinnest shells, add 0.3 %; the formula has no grid.
    for k in 0..2 {
        assert!(
            four[k] < one[k] / 4.0 && sixteen[k] < one[k] / 16.0 && sixteen[k] < 0.005,
            "{one:?} {four:?} {sixteen:?}"
        );
    }
    assert!(sixteen[1] < four[1] / 4.0, "{four:?} {sixteen:?}");
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
fn a_specimen_whose_shells_shrink_as_all_else_does_shrinks_so() {
    let eigenstrain = Some(-2e-4);
    let all = GivenModuli { eigenstrain, ..GivenModuli::default() };
    let rim = GivenModuli { youngs_modulus_mpa: Some(8e3), poisson_ratio: Some(0.25), eigenstrain };
    let moduli = PhaseModuli { mortar: all, aggregate: all, own: [(name(0), rim)].into(), ..PhaseModuli::default() };
    let specimen = cube(SIDE, true);
    let found = stiffness(coated(&specimen, &[2.0]), &moduli, &StiffnessOptions::new(2.0), &Silent).unwrap().0;
    assert!((found.expansion[0] / -2e-4 - 1.0).abs() < 1e-6, "{:?}", found.expansion);
}

/// Properties in tetrahedra of some edge, with the error along x.
fn in_tetrahedra(thicknesses: &[f64], core: f64, shells: &[f64], edge: f64) -> Result<[f64; 2], String> {
    let (specimen, options) = (cube(SIDE, true), EffectiveOptions::new(Property::Diffusivity, 1.0));
    let (parts, values) = (coated(&specimen, thicknesses), values(core, shells));
    let found = effective_in_tetrahedra(parts, &values, &options, edge, &Silent).map_err(|error| error.to_string())?.0;
    Ok([entry(&found, 0, 0), found.error[0][0].unwrap()])
}

#[test]
fn tetrahedra_have_shells_by_the_centres_of_their_cells() {
    let (thicknesses, shells) = ([2.0, 2.0], [5.0, 0.2]);
    let radii = (RADIUS - 4.0, RADIUS - 2.0);
    let equal = equivalent((radii.0, 0.5), &[(radii.1, 0.2), (RADIUS, 5.0)]);
    let exact = diffusivity(&[], equal, &[], 0.5);
    let [found, error] = in_tetrahedra(&thicknesses, 0.5, &shells, 0.8).unwrap();
    assert!(
        (found - exact).abs() < error.max(0.002) && error < 0.05 && (exact - 1.0).abs() > 0.1,
        "{found} {error} {exact}"
    );
    // Impermeable shells close their core in.
    let [closed, _] = in_tetrahedra(&[2.0], 3.0, &[0.0], 1.0).unwrap();
    let [sealed, error] = in_tetrahedra(&[], 0.0, &[], 1.0).unwrap();
    assert!((closed - sealed).abs() < 1e-6 + error, "{closed} {sealed}");
    let thin = in_tetrahedra(&[0.2], 0.1, &[3.0], 2.0).unwrap_err();
    assert!(thin.starts_with("the phase a takes ") && thin.ends_with("or the method voxel"), "{thin}");
    let [one, two] = [&[4.0][..], &[2.0; 2]].map(|own| in_tetrahedra(own, 0.1, &vec![3.0; own.len()], 1.0).unwrap());
    assert!((two[0] / one[0] - 1.0).abs() < 1e-6, "{one:?} {two:?}");
    let given = GivenModuli { youngs_modulus_mpa: Some(8e3), poisson_ratio: Some(0.25), eigenstrain: None };
    let moduli = PhaseModuli { own: [(name(0), given)].into_iter().collect(), ..PhaseModuli::default() };
    let specimen = cube(SIDE, true);
    let options = StiffnessOptions::new(1.0);
    let voxels = stiffness(coated(&specimen, &[2.0]), &moduli, &options, &Silent).unwrap().0;
    let tetrahedra = stiffness_in_tetrahedra(coated(&specimen, &[2.0]), &moduli, &options, 1.0, &Silent).unwrap().0;
    let off = tetrahedra.tensor[0][0] - voxels.tensor[0][0];
    assert!(off.abs() < tetrahedra.error[0][0] + voxels.error[0][0], "{off} {tetrahedra:?} {voxels:?}");
}

#[test]
fn shares_of_shells_are_their_volumes_and_closed_shells_are_refused_in_voxels() {
    let (specimen, options) = (cube(SIDE, true), EffectiveOptions::new(Property::Diffusivity, 2.0));
    let found = effective(coated(&specimen, &[2.0, 1.0]), &values(0.1, &[3.0, 2.0]), &options, &Silent).unwrap().0;
    let body = sphere(Vec3::zeros(), RADIUS, 3);
    let inside = |depth: f64| body.inward_offset(depth).unwrap().unwrap().volume() / SIDE.powi(3);
    let exact = [inside(3.0), inside(0.0) - inside(2.0), inside(2.0) - inside(3.0)];
    for (place, exact) in [2, 5, 6].into_iter().zip(exact) {
        assert!((found.phases[place].volume_fraction - exact).abs() < 1e-12, "{:?}", found.phases);
    }
    let closed = effective(coated(&specimen, &[1.0]), &values(0.1, &[0.0]), &options, &Silent);
    assert!(closed.err().unwrap().to_string().contains("diffusivity.a is 0; a shell lets something pass"));
}

#[test]
fn shells_of_a_ball_with_dents_and_of_an_ellipsoid_conduct_as_those_of_a_ball() {
    let (specimen, options) = (cube(SIDE, true), EffectiveOptions::new(Property::Diffusivity, 0.5));
    let (thicknesses, shells) = ([1.5, 1.0], [3.0, 0.2]);
    let of = |body: Polyhedron| {
        let parts = coated_body(&specimen, body, &thicknesses);
        let voxels = effective(parts.clone(), &values(0.5, &shells), &options, &Silent).unwrap().0;
        let shares: Vec<f64> = voxels.phases.iter().map(|phase| phase.volume_fraction).collect();
        let tetrahedra = effective_in_tetrahedra(parts, &values(0.5, &shells), &options, 0.8, &Silent).unwrap().0;
        ([&voxels, &tetrahedra].map(|found| entry(found, 0, 0)), shares)
    };
    let middle = Vec3::repeat(SIDE / 2.0 + 0.1);
    let ball = sphere(middle, RADIUS, 3);
    let exact = of(ball.clone());
    let ends = Round::of_semi_axes(&Vec3::new(RADIUS, RADIUS, RADIUS - 1e-6)).ends().map(|end| end + middle);
    for body in [ball.with_dents(), Polyhedron::of_ends(&ends)] {
        let (values, shares) = of(body);
        assert!(
            values.iter().zip(exact.0).all(|(one, other)| (one / other - 1.0).abs() < 0.002),
            "{values:?} {exact:?}"
        );
        let is_near = |(one, other): (&f64, &f64)| (one - other).abs() <= 0.005 * other;
        assert!(shares.iter().zip(&exact.1).all(is_near), "{shares:?} {exact:?}");
    }
    let thick = effective(coated_body(&specimen, angle(), &[0.5, 1.2]), &values(0.5, &shells), &options, &Silent);
    let said = thick.err().unwrap().to_string();
    assert!(said.contains("thinner than two of its ITZ with shells (1.700 mm); take the method lattice"), "{said}");
}
