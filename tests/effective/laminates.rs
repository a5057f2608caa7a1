//! Layers in series, in parallel, and at any angle to the grid.

use crate::bodies::{aggregate, cube, entry, phases, slabs, solve};
use meso_core::geometry::convex_hull;
use meso_core::math::Vec3;
use meso_core::specimen::{Periodic, Specimen};
use meso_effective::Effective;

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

/// Seven voxels a layer. With ten times the mortar's value the error is up to 4 %: docs/effective.md.
#[test]
fn laminates_at_any_angle_are_within_one_percent() {
    for value in [0.1, 0.3, 3.0] {
        for normal in [[1.0, 1.0, 0.0], [1.0, 2.0, 0.0], [2.0, -1.0, 1.0]] {
            let normal = Vec3::from(normal);
            let error = error(normal, SIDE / normal.norm(), 0.4, value, 0.5);
            assert!(error < 0.01, "{error} for {value} across {normal:?}");
        }
    }
}
