//! Changes that leave every answer as it is, and proofs that every witness must give.

use super::dice::Dice;
use super::families;
use super::reference;
use meso_collision::gjk::{self, Algorithm, GjkError, Operand, Verdict};
use meso_collision::math::Vec3;

type Map = fn(&[Vec3]) -> Vec<Vec3>;

/// Maps that are exact in floating point and keep every relation of two bodies.
const MAPS: [(&str, Map); 6] = [
    ("reversed", |s| s.iter().rev().copied().collect()),
    ("duplicated", |s| s.iter().chain(s).copied().collect()),
    ("axes permuted", |s| s.iter().map(|p| Vec3::new(p.z, p.x, p.y)).collect()),
    ("reflected", |s| s.iter().map(|p| Vec3::new(-p.x, p.y, p.z)).collect()),
    ("doubled 12 times", |s| s.iter().map(|p| p * 4096.0).collect()),
    ("halved 20 times", |s| s.iter().map(|p| p / 1_048_576.0).collect()),
];

#[test]
fn answers_do_not_change_under_exact_maps_and_swapping() {
    for (name, family) in families::ALL.iter().filter(|(name, _)| !name.contains("magnitudes")) {
        for seed in 0..60 {
            let (a, b) = family(&mut Dice::new(1000 + seed));
            let answer = gjk::intersects(&a, &b).unwrap();
            assert_eq!(gjk::intersects(&b, &a).unwrap(), answer, "{name}, seed {seed}, swapped");
            for (map_name, map) in MAPS {
                assert_eq!(gjk::intersects(&map(&a), &map(&b)).unwrap(), answer, "{name}, seed {seed}, {map_name}");
            }
        }
    }
}

#[test]
fn distances_scale_with_powers_of_two_to_the_last_bit_and_swap() {
    for (name, family) in families::ALL.iter().filter(|(name, _)| !name.contains("magnitudes")) {
        for seed in 0..20 {
            let (a, b) = family(&mut Dice::new(2000 + seed));
            let d = gjk::distance(&a, &b).unwrap();
            assert_eq!(gjk::distance(&b, &a).unwrap(), d, "{name}, seed {seed}, swapped");
            for (factor, (_, map)) in [4096.0, 1.0 / 1_048_576.0].into_iter().zip(&MAPS[4..]) {
                assert_eq!(gjk::distance(&map(&a), &map(&b)).unwrap(), d * factor, "{name}, seed {seed}");
            }
        }
    }
}

#[test]
fn a_separating_direction_separates_and_overlap_points_belong_to_the_bodies() {
    for (name, family) in families::ALL.iter().filter(|(name, _)| !name.contains("magnitudes")) {
        for seed in 0..40 {
            let (a, b) = family(&mut Dice::new(3000 + seed));
            match Algorithm::default().verdict(&a, &b).unwrap() {
                Verdict::Separated { direction, is_exact: false } => {
                    let height = |p: &Vec3| (p - a[0]).dot(&direction);
                    let top = a.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
                    let bottom = b.iter().map(height).fold(f64::INFINITY, f64::min);
                    assert!(top < bottom, "{name}, seed {seed}: {top:e} {bottom:e}");
                }
                Verdict::Separated { direction, is_exact: true } => assert!(direction.norm() > 0.0),
                Verdict::Intersecting { points, .. } => {
                    let pairs: (Vec<Vec3>, Vec<Vec3>) = points.iter().map(|&(i, j)| (a[i], b[j])).unzip();
                    assert!(!pairs.0.is_empty() && gjk::intersects(&pairs.0, &pairs.1).unwrap(), "{name}, seed {seed}");
                }
            }
        }
    }
}

#[test]
fn a_body_without_points_is_named() {
    let point = [Vec3::zeros()];
    assert_eq!(gjk::intersects(&[], &point), Err(GjkError::Empty { body: Operand::A }));
    assert_eq!(gjk::distance(&point, &[]), Err(GjkError::Empty { body: Operand::B }));
    let many = Algorithm::Enhanced.intersects_many(&point, [&point[..], &[]]);
    assert_eq!(many.unwrap_err().to_string(), "bodies[1] has no points; a body needs at least one");
}

#[test]
fn every_finite_number_gets_the_exact_answer() {
    let powers = [-1074, -1050, -1022, -700, -300, 0, 300, 700, 1000];
    let mut overlaps = 0;
    for (i, power) in powers.into_iter().enumerate() {
        let scaled = |v: &Vec3| v.map(|x| libm::scalbn(x, power));
        for (seed, mixed) in (0..40).zip([false, true].into_iter().cycle()) {
            let mut dice = Dice::new(5000 + seed);
            let [a, mut b] = [0, 1].map(|_| (0..5).map(|_| dice.integers(3)).collect::<Vec<_>>());
            b.iter_mut().for_each(|p| *p += Vec3::new(3.0, 2.0, 0.0));
            let truth = reference::intersects(&a, &b);
            if !mixed {
                let (a, b): (Vec<_>, Vec<_>) = (a.iter().map(scaled).collect(), b.iter().map(scaled).collect());
                assert_eq!(gjk::intersects(&a, &b), Ok(truth), "2^{power}, seed {seed}");
                let distance = gjk::distance(&a, &b).unwrap();
                assert_eq!(distance == 0.0, truth, "2^{power}, seed {seed}: {distance:e}");
                overlaps += u32::from(truth);
            } else {
                // One far point: magnitudes side by side that no scale brings together.
                b.push(Vec3::new(0.5, f64::MAX, libm::scalbn(1.0, power)));
                let far = reference::intersects(&a, &b);
                for method in Algorithm::ALL {
                    assert_eq!(method.intersects(&a, &b), Ok(far), "power {i}, seed {seed}");
                }
            }
        }
    }
    assert!((18..=162).contains(&overlaps), "{overlaps} of 180 overlap");
}

#[test]
fn the_largest_and_the_smallest_numbers_have_a_distance() {
    let [low, high] = [-f64::MAX, f64::MAX].map(|x| [Vec3::new(x, 0.0, 0.0)]);
    assert_eq!(gjk::distance(&low, &high), Ok(f64::INFINITY));
    assert_eq!(gjk::distance(&[Vec3::zeros()], &high), Ok(f64::MAX));
    assert_eq!(gjk::distance(&[Vec3::zeros()], &[Vec3::new(0.0, 5e-324, 0.0)]), Ok(5e-324));
    assert_eq!(gjk::intersects(&[Vec3::zeros()], &[Vec3::new(0.0, 5e-324, 0.0)]), Ok(false));
}

#[test]
fn coordinates_that_are_not_finite_are_named() {
    let a = [Vec3::zeros()];
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(gjk::distance(&[Vec3::new(bad, 0.0, 0.0)], &a), Err(GjkError::NotFinite { index: 0, .. })));
    }
    assert!(gjk::intersects(&[Vec3::new(-0.0, 1e60, 1e-60)], &[Vec3::new(0.0, 1e60, 1e-60)]).unwrap());
}

#[test]
fn methods_are_known_by_their_names() {
    for method in Algorithm::ALL {
        assert_eq!(method.name().parse(), Ok(method));
    }
    assert!("gjk".parse::<Algorithm>().unwrap_err().to_string().contains("\"enhanced\""));
}
