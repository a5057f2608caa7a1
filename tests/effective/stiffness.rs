//! Stiffness and expansion against closed forms.

use crate::bodies::{aggregate, cube, slabs, sphere};
use meso_core::Silent;
use meso_core::aggregate::Aggregate;
use meso_core::geometry::convex_hull;
use meso_core::math::Vec3;
use meso_core::mesh::PhaseNames;
use meso_core::specimen::{Periodic, Specimen};
use meso_effective::{GivenModuli, Moduli, PhaseModuli, Stiffness, StiffnessOptions, stiffness};
use std::f64::consts::PI;

pub(crate) const MORTAR: Moduli = Moduli { youngs_modulus_mpa: 20_000.0, poisson_ratio: 0.2, eigenstrain: -4e-4 };
pub(crate) const STONE: Moduli = Moduli { youngs_modulus_mpa: 80_000.0, poisson_ratio: 0.3, eigenstrain: 1e-4 };

pub(crate) fn given(moduli: Moduli) -> GivenModuli {
    GivenModuli {
        youngs_modulus_mpa: Some(moduli.youngs_modulus_mpa),
        poisson_ratio: Some(moduli.poisson_ratio),
        eigenstrain: Some(moduli.eigenstrain),
    }
}

fn solve(bodies: &[Aggregate], specimen: &Specimen, stone: Moduli, h: f64) -> Stiffness {
    let phases =
        PhaseModuli { mortar: given(MORTAR), aggregate: given(stone), itz: given(MORTAR), ..Default::default() };
    stiffness((bodies, specimen), &phases, &StiffnessOptions::new(h), &Silent).unwrap().0
}

/// Lame's constant and the modulus of plane strain.
fn plane(of: &Moduli) -> (f64, f64) {
    let lame = of.bulk() - 2.0 / 3.0 * of.shear();
    (lame, lame + 2.0 * of.shear())
}

/// Share of stone in the laminates.
const SHARE: f64 = 0.37;

fn mixed(of: impl Fn(&Moduli) -> f64) -> f64 {
    (1.0 - SHARE) * of(&MORTAR) + SHARE * of(&STONE)
}

/// Stiffness of a laminate across `axis` (Backus, J. Geophys. Res. 67, 1962, 4427): three of its constants.
pub(crate) fn laminate() -> [f64; 3] {
    let across = 1.0 / mixed(|of| 1.0 / plane(of).1);
    let shear_across = 1.0 / mixed(|of| 1.0 / of.shear());
    [across, shear_across, mixed(Moduli::shear)]
}

/// A slab whose faces cut voxels. Layers across y have walls along y, which keep them from nothing.
#[test]
fn laminates_along_the_grid_have_the_exact_stiffness() {
    let [across, shear_across, shear_along] = laminate();
    for axis in 0..3 {
        let periodic = [true, axis != 1, true];
        let specimen = Specimen::Cube { side_mm: 20.0, periodic: Periodic(periodic) };
        let (low, high) = (Vec3::zeros(), Vec3::repeat(20.0));
        let at = |number: usize, a: usize| {
            let up = number >> a & 1 == 1;
            if a == axis {
                3.3 + if up { 7.4 } else { 0.0 }
            } else if up {
                high[a]
            } else {
                low[a]
            }
        };
        let slab: Vec<Vec3> = (0..8).map(|number| Vec3::new(at(number, 0), at(number, 1), at(number, 2))).collect();
        let bodies = [aggregate(convex_hull(&slab).unwrap(), 0.0)];
        let found = solve(&bodies, &specimen, STONE, 2.0);
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let close =
            |value: f64, exact: f64| assert!((value / exact - 1.0).abs() < 1e-6, "{value} {exact} across {axis}");
        close(found.fine[axis][axis], across);
        close(found.fine[3 + b][3 + b], shear_across);
        close(found.fine[3 + c][3 + c], shear_across);
        close(found.fine[3 + axis][3 + axis], shear_along);
        // In free layers the biaxial moduli weigh the strains.
        let biaxial = |of: &Moduli| of.youngs_modulus_mpa / (1.0 - of.poisson_ratio);
        let free = mixed(|of| of.eigenstrain * biaxial(of)) / mixed(biaxial);
        // Strains have the root of the energy's error.
        assert!((found.expansion[b] / free - 1.0).abs() < 1e-5 && (found.expansion[c] / free - 1.0).abs() < 1e-5);
    }
}

/// Stiffness in the direction of the normal, across layers at an angle to the grid.
#[test]
fn laminates_at_any_angle_have_the_stiffness_within_one_percent() {
    let [across, ..] = laminate();
    for normal in [[1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [2.0, -1.0, 1.0]] {
        let normal = Vec3::from(normal);
        let period = 20.0 / normal.norm();
        let found = solve(&slabs(normal, period, SHARE * period, 20.0), &cube(20.0, true), STONE, 0.84);
        let n = normal.normalize();
        let strain = [n.x * n.x, n.y * n.y, n.z * n.z, 2.0 * n.y * n.z, 2.0 * n.z * n.x, 2.0 * n.x * n.y];
        let row = |i: usize| (0..6).map(|j| found.tensor[i][j] * strain[j]).sum::<f64>();
        let value: f64 = (0..6).map(|i| strain[i] * row(i)).sum();
        assert!((value / across - 1.0).abs() < 0.01, "{value} {across} for {normal:?}");
    }
}

pub(crate) fn array(radius: f64, stone: Moduli, h: f64) -> Stiffness {
    solve(&[aggregate(sphere(Vec3::new(5.1, 4.8, 5.3), radius, 3), 0.0)], &cube(10.0, true), stone, h)
}

/// A stiff sphere among many: the bulk modulus of a cubic array is nearly the lower bound at a small fraction, and bounds are kept.
#[test]
fn spheres_keep_the_bounds_of_their_moduli() {
    let soft = Moduli { youngs_modulus_mpa: 5_000.0, ..STONE };
    for (stone, is_stiff) in [(STONE, true), (soft, false)] {
        let found = array(3.0, stone, 0.5);
        let bulk = found.bounds.bulk_modulus_mpa;
        let k = found.isotropic.bulk_modulus_mpa;
        let near = if is_stiff { bulk.hashin_shtrikman_lower } else { bulk.hashin_shtrikman_upper };
        assert!((k / near - 1.0).abs() < 0.005, "{k} beside {near}");
        let shear = found.bounds.shear_modulus_mpa;
        let g = found.isotropic.shear_modulus_mpa;
        for (value, bounds) in [(k, bulk), (g, shear)] {
            let slack = 1e-3 * value;
            let (low, high) = (bounds.hashin_shtrikman_lower, bounds.hashin_shtrikman_upper);
            assert!(value > low - slack && value < high + slack, "{value} {bounds:?}");
        }
    }
}

/// The bulk modulus of spheres 100 times as stiff was 0.23 % below the lower bound with an error of 1.1 %, without a remark.
#[test]
fn a_modulus_whose_error_crosses_a_bound_is_remarked_on() {
    let found = array(3.0, Moduli { youngs_modulus_mpa: 2e6, ..STONE }, 0.42);
    let (k, error) = (found.isotropic.bulk_modulus_mpa, found.isotropic_error.bulk_modulus_mpa);
    let low = found.bounds.bulk_modulus_mpa.hashin_shtrikman_lower;
    assert!(k - error < low, "{k} {error} {low}");
    let words = ["bulk modulus", "lower Hashin-Shtrikman bound", "within its error of"];
    let is_remark = |warning: &&String| words.iter().all(|word| warning.contains(word));
    assert_eq!(found.warnings.iter().filter(is_remark).count(), 1, "{k} {error} {low} {:?}", found.warnings);
}

/// Levin (Mech. Solids 2, 1967, 58): two phases expand by a rule of their bulk moduli alone, for any geometry of cubic symmetry.
#[test]
fn expansion_follows_levin_from_the_bulk_modulus() {
    let found = array(3.5, STONE, 0.625);
    let inverse = |k: f64| 1.0 / k;
    let fraction = 4.0 / 3.0 * PI * 0.042_875;
    let mean = (1.0 - fraction) * MORTAR.eigenstrain + fraction * STONE.eigenstrain;
    let mean_inverse = (1.0 - fraction) * inverse(MORTAR.bulk()) + fraction * inverse(STONE.bulk());
    let slope = (STONE.eigenstrain - MORTAR.eigenstrain) / (inverse(STONE.bulk()) - inverse(MORTAR.bulk()));
    let exact = mean + slope * (inverse(found.isotropic.bulk_modulus_mpa) - mean_inverse);
    for axis in 0..3 {
        assert!((found.expansion[axis] - exact).abs() < 0.005 * exact.abs(), "{:?} {exact}", found.expansion);
        assert!(found.expansion[axis + 3].abs() < 1e-3 * exact.abs());
    }
}

/// A void is softer than any phase, and the walls of a specimen only stiffen it.
#[test]
fn voids_soften_and_walls_stiffen() {
    let void = |periodic: bool| {
        let mut body = aggregate(sphere(Vec3::repeat(5.0), 3.0, 2), 0.0);
        body.kind = meso_core::aggregate::Kind::Void;
        let found = solve(&[body], &cube(10.0, periodic), Moduli { eigenstrain: 0.0, ..STONE }, 1.0);
        (found.isotropic.bulk_modulus_mpa, found.bounds.bulk_modulus_mpa.hashin_shtrikman_upper, found)
    };
    let ((periodic, upper, _), (walled, _, found)) = (void(true), void(false));
    assert!(periodic < upper && periodic > 0.9 * upper, "{periodic} {upper}");
    assert!(walled > periodic && walled < MORTAR.bulk(), "{walled} {periodic}");
    assert_eq!(found.resolution.boundary, ["uniform-strain"; 3]);
}

#[test]
fn stiffness_is_the_same_on_any_number_of_threads() {
    let [one, other, many] = [1, 2, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| serde_json::to_string(&array(3.0, STONE, 0.42)).unwrap())
    });
    assert!(one == other && one == many);
}

#[test]
fn default_moduli_are_those_of_a_test() {
    let materials = meso_core::materials::Materials::default();
    let found = solve_defaults();
    let of = |name: &str| found.phases.iter().find(|phase| phase.name == name).unwrap();
    assert_eq!(of("mortar").youngs_modulus_mpa, materials.mortar.youngs_modulus_mpa);
    assert_eq!(of("itz").youngs_modulus_mpa, materials.itz.youngs_modulus_mpa);
    assert_eq!(of("aggregate").youngs_modulus_mpa, materials.aggregate.youngs_modulus_mpa);
}

fn solve_defaults() -> Stiffness {
    let options = StiffnessOptions::new(2.5);
    stiffness((&[][..], &cube(10.0, true)), &PhaseModuli::default(), &options, &Silent).unwrap().0
}

#[test]
fn moduli_out_of_range_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut PhaseModuli)| {
        let mut phases = PhaseModuli::default();
        change(&mut phases);
        phases.validate(PhaseNames::COMMON).unwrap_err().to_string()
    };
    let said = refused(&|phases| phases.mortar.youngs_modulus_mpa = Some(0.0));
    assert!(said.starts_with("stiffness.mortar.youngs_modulus_mpa is 0;"), "{said}");
    let said = refused(&|phases| phases.itz.poisson_ratio = Some(0.5));
    assert!(said.starts_with("stiffness.itz.poisson_ratio is 0.5;"), "{said}");
    let said = refused(&|phases| phases.void.eigenstrain = Some(f64::NAN));
    assert!(said.starts_with("stiffness.void.eigenstrain is NaN;"), "{said}");
}

#[test]
fn a_body_with_dents_that_is_thinner_than_its_itz_is_refused() {
    // A packing of torus.stl had a stiffness that took its rings for their planes' sections.
    let corners = [Vec3::repeat(2.0), Vec3::new(8.0, 2.0, 2.0), Vec3::new(2.0, 8.0, 2.0), Vec3::new(2.0, 2.0, 8.0)];
    let dented = convex_hull(&corners).unwrap().with_dents();
    let (specimen, moduli, options) = (cube(10.0, false), PhaseModuli::default(), StiffnessOptions::new(1.0));
    let of = |itz| stiffness((&[aggregate(dented.clone(), itz)][..], &specimen), &moduli, &options, &Silent);
    assert!(of(0.0).is_ok() && of(0.3).is_ok());
    assert!(of(3.0).unwrap_err().to_string().contains("aggregate 0 has dents"));
}
