//! What a folder says about its case, whole or torn.

use crate::plan;
use meso_study::{Case, MODEL, RECORD, Record, State, Status};
use serde_json::{Map, json};
use std::path::Path;

/// A folder with a case that is done.
fn done() -> (tempfile::TempDir, Case) {
    let folder = tempfile::tempdir().unwrap();
    let case = plan(&[("seed", json!([7]))]).unwrap().cases.remove(0);
    std::fs::write(folder.path().join(MODEL), "{...}").unwrap();
    let results = Map::from_iter([("fraction".to_owned(), json!(0.2))]);
    Record::new(&case, "f", Ok(results), folder.path()).unwrap().save(folder.path(), ()).unwrap();
    (folder, case)
}

fn is_over(case: &Case, then: &str, folder: &Path) -> bool {
    matches!(State::of(case, then, folder), State::Over(_))
}

#[test]
fn a_case_with_its_record_is_over() {
    let (folder, case) = done();
    let State::Over(record) = State::of(&case, "f", folder.path()) else { panic!("it is not over") };
    assert_eq!((record.status, record.files[MODEL]), (Status::Done, 5));
    assert_eq!(record.results["fraction"], 0.2);
}

#[test]
fn a_torn_case_is_open() {
    for torn in ["", "{\"mesocrete\": \"0.1.0\", \"ca"] {
        let (folder, case) = done();
        std::fs::write(folder.path().join(RECORD), torn).unwrap();
        assert_eq!(State::of(&case, "f", folder.path()), State::Open);
    }
    let (folder, case) = done();
    std::fs::write(folder.path().join(MODEL), "{").unwrap();
    assert_eq!(State::of(&case, "f", folder.path()), State::Open);
    std::fs::remove_file(folder.path().join(MODEL)).unwrap();
    assert!(!is_over(&case, "f", folder.path()));
}

#[test]
fn another_spec_is_open_and_another_function_keeps_the_packing() {
    let (folder, case) = done();
    let other = plan(&[("seed", json!([8]))]).unwrap().cases.remove(0);
    assert_eq!(State::of(&other, "f", folder.path()), State::Open);
    assert_eq!(State::of(&case, "g", folder.path()), State::Packed);
    State::Packed.prepare(folder.path()).unwrap();
    assert!(folder.path().join(MODEL).exists() && !folder.path().join(RECORD).exists());
}

#[test]
fn what_a_killed_run_left_goes_away() {
    let (folder, case) = done();
    let temporary = folder.path().join(".mesocrete-x1.tmp");
    std::fs::write(&temporary, "half").unwrap();
    std::fs::write(folder.path().join("notes.txt"), "mine").unwrap();
    State::Open.prepare(folder.path()).unwrap();
    assert!(!temporary.exists() && !folder.path().join(MODEL).exists());
    assert!(folder.path().join("notes.txt").exists());
    assert_eq!(State::of(&case, "f", folder.path()), State::Open);
}

#[test]
fn a_failure_keeps_its_message() {
    let (folder, case) = done();
    Record::new(&case, "", Err("no room".to_owned()), folder.path()).unwrap().save(folder.path(), ()).unwrap();
    let State::Over(record) = State::of(&case, "", folder.path()) else { panic!("it is not over") };
    assert_eq!((record.status, record.error.as_deref()), (Status::Failed, Some("no room")));
}
