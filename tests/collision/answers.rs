//! Every yes, no and distance against references in integers.

use super::dice::Dice;
use super::families;
use super::reference;
use meso_collision::gjk::{self, Algorithm, Verdict};
use meso_collision::math::Vec3;

#[test]
fn every_answer_is_the_exact_one_in_every_family() {
    for (name, family) in families::ALL {
        let count = if *name == "fine spheres" { 6 } else { 250 };
        for seed in 0..count {
            let (a, b) = family(&mut Dice::new(seed));
            let truth = reference::intersects(&a, &b);
            for method in Algorithm::ALL {
                let answer = method.intersects(&a, &b).unwrap();
                assert_eq!(answer, truth, "{name}, seed {seed}, {method:?}\na = {a:?}\nb = {b:?}");
            }
        }
    }
}

#[test]
fn every_search_proves_its_answers_about_ordinary_pairs_itself() {
    for method in [Algorithm::Enhanced, Algorithm::Classical, Algorithm::SignedVolumes] {
        let is_left_open = |seed: &u64| {
            let (a, b) = families::random_bodies(&mut Dice::new(*seed));
            let (Verdict::Separated { is_exact, .. } | Verdict::Intersecting { is_exact, .. }) =
                method.verdict(&a, &b).unwrap();
            is_exact
        };
        let open: Vec<u64> = (0..3000).filter(is_left_open).collect();
        assert_eq!(open, [0; 0], "{method:?}");
    }
}

#[test]
fn distance_is_right_to_4e_16_of_the_size_and_zero_only_on_contact() {
    for (name, family) in families::ALL.iter().filter(|(name, _)| *name != "fine spheres") {
        for seed in 0..60 {
            let (mut a, mut b) = family(&mut Dice::new(seed));
            a.truncate(6);
            b.truncate(5);
            let distance = gjk::distance(&a, &b).unwrap();
            let truth = if reference::intersects(&a, &b) { 0.0 } else { reference::distance_of_disjoint(&a, &b) };
            assert_eq!(distance == 0.0, truth == 0.0, "{name}, seed {seed}: {distance:e} for {truth:e}");
            let size = a.iter().chain(&b).map(|p| (p - a[0]).norm()).fold(0.0, f64::max);
            assert!(
                (distance - truth).abs() <= 4e-16 * size.min(distance.max(truth)),
                "{name}, seed {seed}: {distance:e} for {truth:e}"
            );
        }
    }
}

#[test]
fn a_point_meets_itself_and_nothing_else() {
    let p = Vec3::new(0.1, -1e60, 1e-60);
    assert!(gjk::intersects(&[p], &[p]).unwrap());
    assert!(!gjk::intersects(&[p], &[Vec3::new(0.1, -1e60, 1.0000000000000002e-60)]).unwrap());
}
