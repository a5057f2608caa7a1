//! The sieve size of bodies whose square hole is known.

use crate::dice::Dice;
use crate::solids::block;
use meso_collision::geometry::convex_hull;
use meso_collision::geometry::principal_axes;
use meso_collision::math::{Mat3, Vec3};

#[test]
fn a_block_passes_a_square_as_wide_as_its_middle_edge() {
    let mut dice = Dice::new(40);
    for half in [[3.0, 2.0, 1.0], [5.0, 2.0, 2.0], [4.0, 1.0, 0.9]] {
        let turn = dice.rotation();
        let points: Vec<Vec3> = block(half).iter().map(|p| turn * p).collect();
        let size = convex_hull(&points).unwrap().sieve_size();
        // A flat cross-section (2b, 2c) fits a square turned by 45 degrees where that is smaller.
        let expected = (2.0 * half[1]).min((2.0 * half[1] + 2.0 * half[2]) / 2.0_f64.sqrt());
        assert!((size - expected).abs() < 1e-12 * expected, "{half:?}: {size}, not {expected}");
    }
}

#[test]
fn a_plank_passes_cornerwise() {
    let size = convex_hull(&block([10.0, 2.0, 0.1])).unwrap().sieve_size();
    assert!((size - 4.2 / 2.0_f64.sqrt()).abs() < 1e-12, "{size}");
}

#[test]
fn a_sieve_size_is_no_larger_than_the_longest_and_no_smaller_than_the_shortest_extent() {
    let mut dice = Dice::new(41);
    for _ in 0..200 {
        let body = convex_hull(&dice.grain(25)).unwrap();
        let axes = principal_axes(&body.mass_properties().inertia);
        let extent = |k: usize| {
            let along = body.vertices().iter().map(|v| v.dot(&axes.column(k)));
            along.clone().fold(f64::NEG_INFINITY, f64::max) - along.fold(f64::INFINITY, f64::min)
        };
        let size = body.sieve_size();
        assert!(size <= extent(1).max(extent(2)) * (1.0 + 1e-12), "{size}");
        assert!(size >= 0.7 * extent(2), "{size}");
    }
}

#[test]
fn principal_axes_are_an_orthonormal_eigenbasis() {
    let mut dice = Dice::new(42);
    for _ in 0..200 {
        let inertia = convex_hull(&dice.grain(25)).unwrap().mass_properties().inertia;
        let axes = principal_axes(&inertia);
        assert!((axes.transpose() * axes - Mat3::identity()).amax() < 1e-14);
        let diagonal = axes.transpose() * inertia * axes;
        let off_diagonal = diagonal - Mat3::from_diagonal(&diagonal.diagonal());
        assert!(off_diagonal.amax() < 1e-13 * inertia.amax());
        assert!(diagonal[(0, 0)] <= diagonal[(1, 1)] && diagonal[(1, 1)] <= diagonal[(2, 2)]);
    }
}
