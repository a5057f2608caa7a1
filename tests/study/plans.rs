//! Every combination, once, with a hash of its complete spec.

use crate::plan;
use meso_core::specimen::Specimen;
use meso_files::Beside;
use meso_study::{Axis, Design, Plan, PlanError, Sampling, digest};
use serde_json::json;
use std::path::Path;

#[test]
fn every_combination_is_a_case_and_the_last_axis_runs_fastest() {
    let plan = plan(&[("seed", json!([1, 2, 3])), ("fraction", json!([0.2, 0.3]))]).unwrap();
    let found: Vec<_> = plan.cases.iter().map(|case| (case.spec.seed, case.spec.fraction)).collect();
    assert_eq!(found, [(1, 0.2), (1, 0.3), (2, 0.2), (2, 0.3), (3, 0.2), (3, 0.3)]);
    let folders: std::collections::BTreeSet<_> = plan.cases.iter().map(|case| &case.folder).collect();
    assert_eq!(folders.len(), 6);
    assert!(plan.cases[1].folder.starts_with("seed-1_fraction-0.3_"), "{}", plan.cases[1].folder);
}

/// Cases share the texts of their specs.
#[test]
fn the_hash_of_each_case_is_that_of_its_whole_tree() {
    let (seeds, fractions) = (("seed", json!([1, 12, 2])), ("fraction", json!([0.2, 0.25])));
    for axes in [[seeds.clone(), fractions.clone()], [fractions, seeds]] {
        for case in plan(&axes).unwrap().cases {
            let whole = json!({ "mesocrete": env!("CARGO_PKG_VERSION"), "spec": case.spec, "task": case.task });
            assert_eq!(case.hash, digest(whole.to_string().as_bytes()));
        }
    }
}

#[test]
fn no_axes_are_one_case() {
    assert_eq!(plan(&[]).unwrap().cases.len(), 1);
}

#[test]
fn a_changed_limit_keeps_the_classes_that_follow_from_it() {
    let plan = plan(&[("grading.d_max_mm", json!([10, 12]))]).unwrap();
    let largest = |i: usize| *plan.cases[i].spec.grading.classes_mm.last().unwrap();
    assert_eq!((largest(0), largest(1)), (10.0, 12.0));
}

#[test]
fn sections_are_axes_and_another_kind_replaces_them() {
    let values = json!([{ "kind": "sphere", "diameter_mm": 30 }, { "side_mm": 40 }]);
    let plan = plan(&[("specimen", values)]).unwrap();
    assert_eq!(plan.cases[0].spec.specimen.kind(), "sphere");
    assert!((plan.cases[1].spec.specimen.volume() - 64e3).abs() < 1e-6);
    assert!(plan.cases[0].folder.starts_with("specimen-sphere_"));
}

#[test]
fn a_part_of_the_specimen_changes_the_usual_one_where_the_base_has_none() {
    let axis = Axis::new("specimen.side_mm", vec![json!(40)]);
    let plan = Plan::new(&json!({ "fraction": 0.2 }), &[axis], &json!({}), &mut Beside(Path::new(""))).unwrap();
    assert_eq!(plan.cases[0].spec.specimen, Specimen::cube(40.0));
}

#[test]
fn a_kind_and_its_size_are_axes_in_any_order() {
    let (kind, size) = (("specimen.kind", json!(["sphere"])), ("specimen.diameter_mm", json!([30, 40])));
    for axes in [[kind.clone(), size.clone()], [size, kind]] {
        let plan = plan(&axes).unwrap();
        let kinds: Vec<_> = plan.cases.iter().map(|case| case.spec.specimen.kind()).collect();
        assert_eq!(kinds, ["sphere", "sphere"]);
        assert!(plan.cases[0].spec.specimen.volume() < plan.cases[1].spec.specimen.volume());
    }
}

#[test]
fn a_law_and_its_limits_are_axes_in_any_order() {
    let (law, low) = (("shape.elongation.law", json!(["uniform"])), ("shape.elongation.min", json!([0.5, 0.6])));
    let high = ("shape.elongation.max", json!([0.9]));
    let [first, last] = [[law.clone(), low.clone(), high.clone()], [low, high, law]].map(|axes| plan(&axes).unwrap());
    assert_eq!(first.cases.len(), 2);
    assert!(first.cases.iter().zip(&last.cases).all(|(a, b)| a.hash == b.hash));
}

#[test]
fn the_hash_is_of_the_complete_spec() {
    let one = |values| plan(&[("fraction", values)]).unwrap().cases[0].clone();
    // A whole number is the same number.
    assert_eq!(plan(&[("specimen.side_mm", json!([30]))]).unwrap().cases[0].hash, one(json!([0.2])).hash);
    assert_ne!(one(json!([0.2])).hash, one(json!([0.21])).hash);
    assert_eq!(one(json!([0.2])).hash.len(), 64);
    // The one of FIPS 180-2.
    assert!(digest(b"abc").starts_with("ba7816bf8f01cfea414140de5dae2223"));
}

#[test]
fn a_longer_axis_keeps_the_folders_there_are() {
    let folders = |values| -> Vec<String> {
        plan(&[("seed", values)]).unwrap().cases.into_iter().map(|case| case.folder).collect()
    };
    let (few, many) = (folders(json!([2, 3])), folders(json!([1, 2, 3, 4])));
    assert!(few.iter().all(|folder| many.contains(folder)));
}

#[test]
fn wrong_studies_are_named_before_the_work() {
    let wrong = |axes: &[(&str, serde_json::Value)]| plan(axes).unwrap_err();
    assert_eq!(wrong(&[("seed", json!([]))]), PlanError::Empty("seed".to_owned()));
    assert!(matches!(
        wrong(&[("specimen", json!([{}])), ("specimen.side_mm", json!([3]))]),
        PlanError::Overlapping(..)
    ));
    assert!(matches!(wrong(&[("seed", json!([1, 1]))]), PlanError::Twice(..)));
    assert!(matches!(wrong(&[("grading..d", json!([1]))]), PlanError::Key(_)));
    let error = wrong(&[("seed", json!([4])), ("fraction", json!([0.3, 1.5]))]).to_string();
    assert!(error.starts_with("case seed = 4, fraction = 1.5: fraction is 1.5"), "{error}");
    let error = wrong(&[("grading.d_maxmm", json!([4]))]).to_string();
    assert!(error.contains("grading.d_maxmm"), "{error}");
}

#[test]
fn flags_of_a_task_change_the_hash_and_not_the_spec() {
    let axes = [Axis::new("mesh.element-size-mm", vec![json!(2), json!(4)])];
    let plan = |task| Plan::new(&json!({ "fraction": 0.2 }), &axes, &task, &mut Beside(Path::new("")));
    let error = plan(json!({})).unwrap_err().to_string();
    assert_eq!(error, "mesh.element-size-mm changes [mesh], which is not there; add it");
    let plan = plan(json!({ "mesh": {} })).unwrap();
    assert_eq!(plan.cases[0].spec, plan.cases[1].spec);
    assert_eq!(plan.cases[1].task, json!({ "mesh": { "element-size-mm": 4 } }));
    assert_ne!(plan.cases[0].hash, plan.cases[1].hash);
}

#[test]
fn zipped_lists_change_together() {
    let lists =
        vec![("seed".to_owned(), vec![json!(1), json!(2)]), ("fraction".to_owned(), vec![json!(0.2), json!(0.3)])];
    let plan = of_axes(&[
        Axis::zipped(lists.clone()).unwrap(),
        Axis::new("placement.min_gap_mm", vec![json!(0.0), json!(1.0)]),
    ]);
    let found: Vec<_> =
        plan.cases.iter().map(|case| (case.spec.seed, case.spec.fraction, case.spec.placement.min_gap_mm)).collect();
    assert_eq!(found, [(1, 0.2, 0.0), (1, 0.2, 1.0), (2, 0.3, 0.0), (2, 0.3, 1.0)]);
    let uneven = vec![lists[0].clone(), ("fraction".to_owned(), vec![json!(0.2)])];
    let error = PlanError::Uneven("seed".to_owned(), 2, "fraction".to_owned(), 1);
    assert_eq!(Axis::zipped(uneven), Err(error));
}

#[test]
fn a_longer_random_draw_keeps_the_cases_of_a_shorter_one() {
    let over = json!({ "fraction": { "low": 0.1, "high": 0.3 }, "grading": { "d_max_mm": [8, 10] } });
    let draw = |cases, design| Sampling { cases, design, seed: 3, over: over.as_object().unwrap().clone() };
    let rows = |cases, design| Axis::drawn(&draw(cases, design), &[]).unwrap().rows;
    let (short, long) = (rows(10, Design::Random), rows(20, Design::Random));
    assert_eq!(short, long[..10]);
    let plan = of_axes(&[Axis::drawn(&draw(20, Design::Random), &[]).unwrap()]);
    assert_eq!(plan.keys, ["fraction", "grading.d_max_mm", "seed"]);
    assert!(plan.cases.iter().enumerate().all(|(number, case)| case.spec.seed == number as u64));
    assert!(plan.cases.iter().all(|case| (0.1..0.3).contains(&case.spec.fraction)));
    let strata = rows(20, Design::LatinHypercube);
    let mut found: Vec<_> = strata.iter().map(|row| ((row[0].as_f64().unwrap() - 0.1) * 100.0) as usize).collect();
    found.sort_unstable();
    assert_eq!(found, (0..20).collect::<Vec<_>>());
    assert_eq!(strata.iter().filter(|row| row[1] == 8).count(), 10);
}

#[test]
fn a_seed_that_is_an_axis_is_not_drawn() {
    let draw =
        Sampling { cases: 2, over: json!({ "fraction": [0.1] }).as_object().unwrap().clone(), ..Sampling::default() };
    let seeds = Axis::new("seed", vec![json!(5)]);
    assert_eq!(Axis::drawn(&draw, &[seeds]).unwrap().keys, ["fraction"]);
    let wrong =
        Sampling { over: json!({ "fraction": { "low": 2, "high": 1 } }).as_object().unwrap().clone(), ..draw.clone() };
    assert!(matches!(Axis::drawn(&wrong, &[]), Err(PlanError::Range(key, _)) if key == "fraction"));
    assert_eq!(Axis::drawn(&Sampling { cases: 0, ..draw }, &[]), Err(PlanError::NoCases));
}

#[test]
fn listed_specs_replace_the_base() {
    let listed = [(json!("a"), json!({ "fraction": 0.1 })), (json!("b"), json!({ "fraction": 0.3, "seed": 9 }))];
    let plan = of_axes(&[Axis::of_specs(listed.to_vec()), Axis::new("specimen.side_mm", vec![json!(30), json!(40)])]);
    let found: Vec<_> = plan.cases.iter().map(|case| (case.spec.fraction, case.spec.seed)).collect();
    assert_eq!(found, [(0.1, 1), (0.1, 1), (0.3, 9), (0.3, 9)]);
    assert!(plan.cases[2].folder.starts_with("spec-b_side_mm-30_"), "{}", plan.cases[2].folder);
}

/// A plan over the paper's specimen.
fn of_axes(axes: &[Axis]) -> Plan {
    Plan::new(&json!({}), axes, &json!({}), &mut Beside(Path::new(""))).unwrap()
}
