//! CaseState of a case by its folder, whole, torn or damaged.

use crate::plan;
use meso_study::{CURVE, Case, CaseOutcome, CaseState, MODEL, RECORD, Record, Status};
use serde_json::{Map, json};
use std::path::Path;

/// A folder with a case that is done.
fn done() -> (tempfile::TempDir, Case) {
    let folder = tempfile::tempdir().unwrap();
    let case = plan(&[("seed", json!([7]))]).unwrap().cases.remove(0);
    std::fs::write(folder.path().join(MODEL), "{...}").unwrap();
    let results = Map::from_iter([("fraction".to_owned(), json!(0.2))]);
    Record::new(&case, "f", Ok(results).into(), folder.path()).unwrap().save(folder.path(), ()).unwrap();
    (folder, case)
}

fn is_over(case: &Case, then: &str, folder: &Path) -> bool {
    matches!(CaseState::of(case, then, folder), CaseState::Over(_))
}

#[test]
fn a_case_with_its_record_is_over() {
    let (folder, case) = done();
    let CaseState::Over(record) = CaseState::of(&case, "f", folder.path()) else { panic!("it is not over") };
    assert_eq!((record.status, record.files[MODEL]), (Status::Done, 5));
    assert_eq!(record.results["fraction"], 0.2);
}

#[test]
fn a_torn_case_is_open() {
    for torn in ["", "{\"mesocrete\": \"0.1.0\", \"ca"] {
        let (folder, case) = done();
        std::fs::write(folder.path().join(RECORD), torn).unwrap();
        assert_eq!(CaseState::of(&case, "f", folder.path()), CaseState::Open);
    }
    let (folder, case) = done();
    std::fs::write(folder.path().join(MODEL), "{").unwrap();
    assert_eq!(CaseState::of(&case, "f", folder.path()), CaseState::Open);
    std::fs::remove_file(folder.path().join(MODEL)).unwrap();
    assert!(!is_over(&case, "f", folder.path()));
}

#[test]
fn another_spec_is_open_and_another_function_keeps_the_packing() {
    let (folder, case) = done();
    let other = plan(&[("seed", json!([8]))]).unwrap().cases.remove(0);
    assert_eq!(CaseState::of(&other, "f", folder.path()), CaseState::Open);
    assert_eq!(CaseState::of(&case, "g", folder.path()), CaseState::Packed);
    CaseState::Packed.prepare(folder.path()).unwrap();
    assert!(folder.path().join(MODEL).exists() && !folder.path().join(RECORD).exists());
}

#[test]
fn remains_of_a_killed_run_are_removed() {
    let (folder, case) = done();
    let temporary = folder.path().join(".mesocrete-x1.tmp");
    std::fs::write(&temporary, "half").unwrap();
    std::fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    CaseState::Open.prepare(folder.path()).unwrap();
    assert!(!temporary.exists() && !folder.path().join(MODEL).exists());
    assert!(folder.path().join("notes.txt").exists());
    assert_eq!(CaseState::of(&case, "f", folder.path()), CaseState::Open);
}

#[test]
fn a_failure_keeps_its_message() {
    let (folder, case) = done();
    Record::new(&case, "", Err("no room".to_owned()).into(), folder.path()).unwrap().save(folder.path(), ()).unwrap();
    let CaseState::Over(record) = CaseState::of(&case, "", folder.path()) else { panic!("it is not over") };
    assert_eq!((record.status, record.error.as_deref()), (Status::Failed, Some("no room")));
}

#[test]
fn a_record_with_a_flipped_bit_never_counts() {
    let (folder, case) = done();
    let path = folder.path().join(RECORD);
    let whole = std::fs::read(&path).unwrap();
    let right = CaseState::of(&case, "f", folder.path());
    let mut refused = 0;
    // Every third bit of some 5,000: a digit of the result, a key, a blank, the hash itself.
    for bit in (0..8 * whole.len()).step_by(3) {
        let mut damaged = whole.clone();
        damaged[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(&path, &damaged).unwrap();
        match CaseState::of(&case, "f", folder.path()) {
            CaseState::Open => refused += 1,
            // A blank that became another blank.
            other => assert_eq!(other, right, "bit {bit}"),
        }
    }
    assert!(refused > 1200, "{refused}");
}

/// A fit reads the curve of a case: 500 flipped bits.
#[test]
fn a_curve_with_a_flipped_bit_is_not_the_recorded_one() {
    let (folder, case) = done();
    let path = folder.path().join(CURVE);
    let mut curve = b"strain,stress_mpa\n0.0,0.0\n0.001,31.25\n0.002,30.5\n0.003,12.75\n".to_vec();
    std::fs::write(&path, &curve).unwrap();
    let record = Record::new(&case, "", Ok(Map::new()).into(), folder.path()).unwrap();
    assert!(record.has_curve(folder.path()));
    for bit in 0..8 * curve.len() {
        curve[bit / 8] ^= 1 << (bit % 8);
        std::fs::write(&path, &curve).unwrap();
        assert!(!record.has_curve(folder.path()), "bit {bit}");
        curve[bit / 8] ^= 1 << (bit % 8);
    }
    std::fs::remove_file(&path).unwrap();
    assert!(!record.has_curve(folder.path()));
}

#[test]
fn a_damaged_packing_of_the_right_length_is_packed_anew() {
    let (folder, case) = done();
    std::fs::write(folder.path().join(MODEL), "{..,}").unwrap();
    assert_eq!(CaseState::of(&case, "g", folder.path()), CaseState::Open);
}

/// The shared case then_results.py: one of the two values was lost.
#[test]
fn results_with_one_name_in_the_table_fail_their_case() {
    let (folder, case) = done();
    let results = json!({ "a.b": 1, "a": { "b": 2 } });
    let outcome = Ok(results.as_object().unwrap().clone()).into();
    let record = Record::new(&case, "", outcome, folder.path()).unwrap();
    assert_eq!(record.status, Status::Failed);
    assert!(record.error.unwrap().contains("two results have the name \"a.b\""));
}

#[test]
fn a_record_has_the_warnings_of_its_spec_and_of_its_work() {
    let (folder, _) = done();
    let case = plan(&[("placement.attempts", json!([9])), ("placement.strategy", json!(["rearrange"]))])
        .unwrap()
        .cases
        .remove(0);
    let outcome = CaseOutcome { results: Ok(Map::new()), warnings: vec!["coarse".to_owned()] };
    let record = Record::new(&case, "", outcome, folder.path()).unwrap();
    assert!(record.warnings[0].starts_with("attempts count for"), "{:?}", record.warnings);
    assert_eq!(record.warnings[1], "coarse");
}
