//! All named tests on small concrete: how quasi-static they are, and how long they take.

use crate::loads::all_kinds;
use crate::samples::{Meshed, brittle, options};
use meso_core::aggregate::Grading;
use meso_core::mesh::{ItzForm, Method};
use meso_core::specimen::Specimen;
use meso_core::{Silent, Spec};
use meso_solve::{Expansion, Test, TestKind};
use std::time::{Duration, Instant};

/// Concrete of 4 to `most` mm in a specimen, with a smeared ITZ.
fn concrete(specimen: Specimen, fraction: f64, most: f64, element_size_mm: f64) -> Meshed {
    let mut spec = Spec { specimen, fraction, seed: 1, ..Spec::default() };
    spec.grading = Grading { d_min_mm: 4.0, d_max_mm: most, classes_mm: vec![4.0, most], ..Grading::default() };
    spec.placement.min_gap_mm = 0.5;
    let model = meso_core::pack(&spec, &Silent).unwrap();
    let options = options(Method::FITTED, element_size_mm, ItzForm::Smeared);
    Meshed::of(&model.aggregates, model.spec.specimen.clone(), options)
}

fn notched([length_mm, width_mm, depth_mm]: [f64; 3], notches_mm: [f64; 2]) -> Specimen {
    let [notch_depth_mm, upper_notch_depth_mm] = notches_mm;
    Specimen::NotchedPrism {
        length_mm,
        width_mm,
        depth_mm,
        notch_depth_mm,
        notch_width_mm: 4.0,
        upper_notch_depth_mm,
        notch_at_mm: 0.0,
    }
}

/// Specimens of 24 mm with 30 % of 4 to 8 mm, and the tests that each can have.
fn smallest() -> Vec<(Specimen, Vec<Test>)> {
    let of = |kind| Test { kind, ..Test::default() };
    let brush = Test { friction: Some(0.005), ..Test::default() };
    let swelling = Expansion { aggregate: 1e-3.into(), ..Expansion::default() };
    let swollen = Test { expansion: Some(swelling), ..of(TestKind::Expansion) };
    let plated = [TestKind::Compression, TestKind::Tension, TestKind::Triaxial, TestKind::Biaxial, TestKind::Cyclic];
    vec![
        (Specimen::cube(24.0), plated.map(of).into_iter().chain([brush, swollen]).collect()),
        (Specimen::Cylinder { diameter_mm: 24.0, height_mm: 24.0 }, vec![of(TestKind::Splitting)]),
        (notched([88.0, 16.0, 24.0], [6.0, 0.0]), vec![of(TestKind::Bending)]),
        (Specimen::Prism { length_mm: 88.0, width_mm: 16.0, depth_mm: 24.0 }, vec![of(TestKind::FourPoint)]),
        (notched([32.0, 16.0, 32.0], [8.0, 8.0]), vec![of(TestKind::Shear)]),
    ]
}

/// The bars: 1 % of kinetic energy until half the peak, and 10 minutes for all on two cores.
#[test]
#[ignore = "slow tier: eleven tests of concrete, minutes of processor time"]
fn all_named_tests_are_quasi_static_until_half_their_peak_and_take_ten_minutes_together() {
    let begun = Instant::now();
    let mut fast = Vec::new();
    for (specimen, tests) in smallest() {
        let meshed = concrete(specimen, 0.3, 8.0, 2.0);
        for test in tests {
            let result = meshed.solve(&brittle(), &test).result;
            let (kinetic, seconds) = (100.0 * result.kinetic_over_internal_to_half_peak, begun.elapsed().as_secs_f64());
            eprintln!("{:?}, friction {}: {kinetic:.2} %, {seconds:.0} s so far", test.kind, test.friction());
            if kinetic > 1.0 && !result.is_free() {
                fast.push((test.kind, kinetic));
            }
        }
    }
    assert!(fast.is_empty(), "{fast:?}");
    assert!(begun.elapsed() < Duration::from_secs(600), "{:?}", begun.elapsed());
}

#[test]
fn every_named_test_has_a_small_specimen() {
    let named = |kinds: Vec<TestKind>| {
        let mut names: Vec<String> = kinds.iter().map(|kind| format!("{kind:?}")).collect();
        names.sort();
        names.dedup();
        names
    };
    let small = smallest();
    for (specimen, tests) in &small {
        tests.iter().for_each(|test| test.suits(specimen).unwrap());
    }
    // Tests in real time are not slow.
    let slow = all_kinds().into_iter().filter(|(_, test)| !test.is_fast());
    let all = named(slow.map(|(_, test)| test.kind).collect());
    assert_eq!(named(small.into_iter().flat_map(|(_, tests)| tests).map(|test| test.kind).collect()), all);
    assert_eq!(all.len(), 10);
}
