//! A study runs once: its folder is locked, and every case leaves its record.

use crate::plan;
use meso_files::lock::{LockError, hold};
use meso_study::{Again, CaseOutcome, RunError, Status, StudyRun};
use serde_json::{Map, json};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A run of the seeds 1 to 5.
fn open(out: &Path, again: Again) -> Result<StudyRun, RunError> {
    StudyRun::open(Arc::new(plan(&[("seed", json!([1, 2, 3, 4, 5]))]).unwrap()), "", out, again)
}

/// Results of a case, of which the third fails.
fn outcome(number: usize) -> CaseOutcome {
    let results = Map::from_iter([("n".to_owned(), json!(number))]);
    if number == 2 { Err("no room".to_owned()).into() } else { Ok(results).into() }
}

#[test]
fn every_case_runs_once_on_any_number_of_threads() {
    for jobs in [1, 2, 7] {
        let folder = tempfile::tempdir().unwrap();
        let run = open(folder.path(), Again::None).unwrap();
        let (starts, calls) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let work = |number| {
            calls.fetch_add(1, Ordering::SeqCst);
            Some(outcome(number))
        };
        run.drive(
            jobs,
            (),
            &|_| {
                starts.fetch_add(1, Ordering::SeqCst);
            },
            &work,
        )
        .unwrap();
        assert_eq!((starts.into_inner(), calls.into_inner()), (5, 5));
        let tally = run.tally();
        assert_eq!((tally.cases, tally.before, tally.done, tally.failed), (5, 0, 4, 1));
        assert_eq!(run.save_tables(()).unwrap().rows(), 5);
        assert!(run.left().is_empty());
    }
}

#[test]
fn finished_cases_run_again_on_request() {
    let folder = tempfile::tempdir().unwrap();
    open(folder.path(), Again::None).unwrap().drive(2, (), &|_| (), &|number| Some(outcome(number))).unwrap();
    assert!(open(folder.path(), Again::None).unwrap().left().is_empty());
    assert_eq!(open(folder.path(), Again::Failed).unwrap().left(), [2]);
    assert_eq!(open(folder.path(), Again::All).unwrap().left(), [0, 1, 2, 3, 4]);
}

#[test]
fn a_run_stops_where_its_work_does_and_the_next_one_continues() {
    let folder = tempfile::tempdir().unwrap();
    let run = open(folder.path(), Again::None).unwrap();
    run.drive(1, (), &|_| (), &|number| (number < 3).then(|| outcome(number))).unwrap();
    assert_eq!(run.left(), [3, 4]);
    drop(run);
    let run = open(folder.path(), Again::None).unwrap();
    assert_eq!((run.left(), run.tally().before), (vec![3, 4], 3));
}

/// The shared case study_two_processes.py: 6 of 8 pairs of processes had false failures.
#[test]
fn a_folder_with_a_run_refuses_a_second_one() {
    let folder = tempfile::tempdir().unwrap();
    let run = open(folder.path(), Again::None).unwrap();
    let refused = |again| matches!(open(folder.path(), again), Err(RunError::Lock(LockError::Busy { .. })));
    assert!(refused(Again::None) && refused(Again::Failed) && refused(Again::All));
    run.drive(3, (), &|_| (), &|number| {
        assert!(refused(Again::All));
        Some(outcome(number))
    })
    .unwrap();
    run.close();
    assert!(!refused(Again::None));
    let held = hold(folder.path()).unwrap();
    assert!(refused(Again::None));
    drop(held);
    assert!(!refused(Again::None));
}

#[test]
fn a_case_that_cannot_be_recorded_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let run = open(folder.path(), Again::None).unwrap();
    let case = plan(&[("seed", json!([2]))]).unwrap().cases.remove(0);
    std::fs::write(folder.path().join(&case.folder), "a file").unwrap();
    let error = run.drive(1, (), &|_| (), &|number| Some(outcome(number))).unwrap_err();
    assert!(matches!(&error, RunError::File { path, .. } if path.ends_with(&case.folder)), "{error}");
    assert_eq!(run.records().iter().map(|record| record.status).collect::<Vec<_>>(), [Status::Done]);
}
