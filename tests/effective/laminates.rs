//! Layers in series, in parallel, and at any angle to the grid.

use crate::bodies::{aggregate, cube, entry, phases, slabs, solve};
use meso_core::Silent;
use meso_core::geometry::convex_hull;
use meso_core::math::Vec3;
use meso_core::specimen::{Periodic, Specimen};
use meso_effective::{Effective, EffectiveOptions, Property, effective};

const SIDE: f64 = 20.0;

/// Largest error of a laminate's tensor, over the largest entry.
fn error(normal: Vec3, period: f64, share: f64, value: f64, h: f64) -> f64 {
    let bodies = slabs(normal, period, share * period, SIDE);
    off(&solve(&bodies, &cube(SIDE, true), &phases(1.0, value, 1.0), h), normal, share, value)
}

/// Largest difference of a tensor from the laminate's, over the largest entry.
pub(crate) fn off(found: &Effective, normal: Vec3, share: f64, value: f64) -> f64 {
    let parallel = 1.0 - share + share * value;
    let series = if value > 0.0 { 1.0 / (1.0 - share + share / value) } else { 0.0 };
    let n = normal.normalize();
    let exact = |a: usize, b: usize| parallel * f64::from(u8::from(a == b)) - (parallel - series) * n[a] * n[b];
    let off = |a: usize, b: usize| (entry(found, a, b) - exact(a, b)).abs();
    (0..9).map(|i| off(i / 3, i % 3)).fold(0.0, f64::max) / parallel
}

/// Layers across one axis, in a specimen that is periodic along it: the other axes have walls.
#[test]
fn laminates_along_the_grid_are_exact() {
    for value in [0.0, 0.3, 3.0, 1e4] {
        for axis in 0..3 {
            let mut periodic = [false; 3];
            periodic[axis] = true;
            let specimen = Specimen::Cube { side_mm: SIDE, periodic: Periodic(periodic) };
            let corner = |number: usize, a: usize| number >> a & 1;
            let at = |number: usize, a: usize| {
                if a == axis { 3.3 + 7.4 * corner(number, a) as f64 } else { -9.0 + 40.0 * corner(number, a) as f64 }
            };
            let slab: Vec<Vec3> = (0..8).map(|number| Vec3::new(at(number, 0), at(number, 1), at(number, 2))).collect();
            let bodies = [aggregate(convex_hull(&slab).unwrap(), 0.0)];
            let found = solve(&bodies, &specimen, &phases(1.0, value, 1.0), 2.0);
            let parallel = 0.63 + 0.37 * value;
            let series = if value > 0.0 { 1.0 / (0.63 + 0.37 / value) } else { 0.0 };
            for a in 0..3 {
                let exact = if a == axis { series } else { parallel };
                let error = (entry(&found, a, a) - exact).abs() / parallel;
                assert!(error < 1e-6, "{error} along {a} for {value} across {axis}");
            }
        }
    }
}

#[test]
fn impermeable_laminates_are_exact_at_any_angle() {
    for normal in [[1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [1.0, 1.0, 1.0], [3.0, -1.0, 2.0]] {
        let normal = Vec3::from(normal);
        let error = error(normal, SIDE / normal.norm(), 0.6, 0.0, 1.0);
        assert!(error < 2e-6, "{error} for {normal:?}");
    }
}

/// Seven voxels a layer.
#[test]
fn laminates_at_any_angle_are_within_four_in_a_thousand() {
    for value in [0.1, 0.3, 3.0, 10.0, 100.0, 1e4] {
        for normal in [[1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [2.0, -1.0, 1.0]] {
            let normal = Vec3::from(normal);
            let error = error(normal, SIDE / normal.norm(), 0.4, value, 0.5);
            assert!(error < 0.004, "{error} for {value} across {normal:?}");
        }
    }
}

/// Axes turn for the gradient between walls. Bodies end in both walls: at the upper one they counted as mortar, 4.7 % off.
#[test]
fn oblique_layers_between_walls_are_within_four_in_a_thousand() {
    for axis in 0..3 {
        let mut normal = Vec3::new(1.0, 1.0, 1.0);
        normal[axis] = 0.0;
        let mut periodic = [true; 3];
        periodic[axis] = false;
        let period = SIDE / normal.norm();
        let bodies = slabs(normal, period, 0.4 * period, SIDE);
        let specimen = Specimen::Cube { side_mm: SIDE, periodic: Periodic(periodic) };
        let found = solve(&bodies, &specimen, &phases(1.0, 10.0, 1.0), 0.5);
        let error = off(&found, normal, 0.4, 10.0);
        assert!(error < 0.004, "{error} across {normal:?}");
    }
}

/// Each flux at a voxel's centre is the mean of two links along each axis, so the mean over a period is that of the links.
#[test]
fn fields_of_oblique_layers_have_the_mean_flux_of_the_tensor() {
    let normal = Vec3::new(2.0, -1.0, 1.0);
    let period = SIDE / normal.norm();
    let bodies = slabs(normal, period, 0.4 * period, SIDE);
    let options = EffectiveOptions { fields: true, ..EffectiveOptions::new(Property::Diffusivity, 1.0) };
    let specimen = cube(SIDE, true);
    let (found, fields) = effective((&bodies[..], &specimen), &phases(1.0, 10.0, 1.0), &options, &Silent).unwrap();
    for (column, field) in fields.iter().enumerate() {
        for row in 0..3 {
            let flux = field.values.as_chunks::<3>().0;
            let sum: f64 = flux.iter().map(|flux| f64::from(flux[row])).sum();
            let (mean, entry) = (sum / flux.len() as f64, found.fine[row][column].unwrap());
            assert!((mean - entry).abs() < 1e-5, "{mean} {entry} in {row}, {column}");
        }
    }
}

#[test]
fn oblique_layers_have_the_same_bytes_on_any_number_of_threads() {
    let normal = Vec3::new(1.0, 2.0, 0.0);
    let period = SIDE / normal.norm();
    let (bodies, specimen) = (slabs(normal, period, 0.4 * period, SIDE), cube(SIDE, true));
    let [one, other, many] = [1, 2, 8].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| serde_json::to_vec(&solve(&bodies, &specimen, &phases(1.0, 10.0, 1.0), 0.5)).unwrap())
    });
    assert!(one == other && one == many);
}
