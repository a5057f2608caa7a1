//! A study runs once: each case in hand is locked, and leaves its record.

use crate::plan;
use meso_ask::AskError;
use meso_files::lock::{LOCK, LockError};
use meso_study::{Again, Begun, CaseOutcome, Heard, RECORDS, RunError, Share, Status, StudyLayout, StudyRun};
use serde_json::{Map, json};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A run of the seeds 1 to 5.
fn open(out: &Path, again: Again) -> Result<StudyRun, RunError> {
    open_share(out, again, Share::ALL)
}

/// The cases of this run of the seeds 1 to 5.
fn open_share(out: &Path, again: Again, share: Share) -> Result<StudyRun, RunError> {
    StudyRun::open(Arc::new(plan(&[("seed", json!([1, 2, 3, 4, 5]))]).unwrap()), "", out, again, share, None)
}

/// Names of the hidden files in the folder and in those of its cases.
fn hidden(out: &Path) -> Vec<String> {
    let names = |folder: &Path| -> Vec<String> {
        let entries = std::fs::read_dir(folder).into_iter().flatten();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    };
    let all = names(out);
    let of_cases: Vec<String> = all.iter().flat_map(|name| names(&out.join(name))).collect();
    all.into_iter().chain(of_cases).filter(|name| name.starts_with('.')).collect()
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
            Ok(Some(outcome(number)))
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
    open(folder.path(), Again::None).unwrap().drive(2, (), &|_| (), &|number| Ok(Some(outcome(number)))).unwrap();
    assert!(open(folder.path(), Again::None).unwrap().left().is_empty());
    assert_eq!(open(folder.path(), Again::Failed).unwrap().left(), [2]);
    assert_eq!(open(folder.path(), Again::All).unwrap().left(), [0, 1, 2, 3, 4]);
}

#[test]
fn a_run_stops_where_its_work_does_and_the_next_one_continues() {
    let folder = tempfile::tempdir().unwrap();
    let run = open(folder.path(), Again::None).unwrap();
    run.drive(1, (), &|_| (), &|number| Ok((number < 3).then(|| outcome(number)))).unwrap();
    assert_eq!(run.left(), [3, 4]);
    drop(run);
    let run = open(folder.path(), Again::None).unwrap();
    assert_eq!((run.left(), run.tally().before), (vec![3, 4], 3));
}

/// The shared case study_two_processes.py: 6 of 8 pairs of processes had false failures. A second run of the same study takes
/// the cases that are free; other work is refused.
#[test]
fn two_runs_in_one_folder_share_the_cases_and_do_none_twice() {
    let folder = tempfile::tempdir().unwrap();
    let runs = [open(folder.path(), Again::None).unwrap(), open(folder.path(), Again::None).unwrap()];
    let refused = |again| matches!(open(folder.path(), again), Err(RunError::Lock(LockError::Busy { .. })));
    assert!(refused(Again::All) && !refused(Again::Failed));
    let calls = AtomicUsize::new(0);
    for run in &runs {
        let work = |number| {
            calls.fetch_add(1, Ordering::SeqCst);
            Ok(Some(outcome(number)))
        };
        run.drive(3, (), &|_| (), &work).unwrap();
        assert_eq!((run.tally().done, run.tally().failed), (4, 1));
    }
    assert_eq!(calls.into_inner(), 5);
    drop(runs);
    assert!(!refused(Again::All));
    assert_eq!(hidden(folder.path()), [""; 0]);
}

/// The case: a second `study --force` deleted the finished cases of the first, whose table then had 2 rows of 3.
#[test]
fn repeated_cases_belong_to_one_process_for_each_part() {
    for again in [Again::All, Again::Failed] {
        let folder = tempfile::tempdir().unwrap();
        let share = |shard, of| open_share(folder.path(), again, Share { shard, of });
        let first = share(1, 2).unwrap();
        assert!(matches!(share(1, 2), Err(RunError::Lock(_))), "{again:?}");
        let second = share(2, 2).unwrap();
        // Whoever writes the tables takes nothing from them.
        let plan = Arc::new(plan(&[("seed", json!([1, 2, 3, 4, 5]))]).unwrap());
        assert_eq!(StudyRun::look(plan, "", folder.path()).unwrap().tally().cases, 5);
        assert_eq!(open(folder.path(), Again::None).is_ok(), again == Again::Failed);
        drop((first, second));
        drop(share(1, 1).unwrap());
        assert_eq!(hidden(folder.path()), Vec::<String>::new());
    }
}

/// The case: a study beside the same one with --min-gap-mm; the table had the rows of whichever ended last.
#[test]
fn other_cases_in_a_folder_are_other_work() {
    let folder = tempfile::tempdir().unwrap();
    let first = open(folder.path(), Again::None).unwrap();
    let other = || {
        let plan = plan(&[("seed", json!([1, 2, 3]))]).unwrap();
        StudyRun::open(Arc::new(plan), "", folder.path(), Again::None, Share::ALL, None)
    };
    assert!(matches!(other(), Err(RunError::Lock(_))));
    drop(first);
    assert!(other().is_ok());
}

#[test]
fn shards_are_disjoint_and_together_the_study() {
    let folder = tempfile::tempdir().unwrap();
    let mut all = Vec::new();
    for shard in 1..=3 {
        let run = open_share(folder.path(), Again::None, Share { shard, of: 3 }).unwrap();
        all.extend(run.left());
        run.drive(1, (), &|_| (), &|number| Ok(Some(outcome(number)))).unwrap();
        assert_eq!((run.tally().cases, run.records().len()), (run.tally().over(), run.tally().cases));
    }
    assert_eq!(all, [0, 3, 1, 4, 2]);
    let collected = open(folder.path(), Again::None).unwrap();
    assert_eq!((collected.tally().before, collected.save_tables(()).unwrap().rows()), (5, 5));
}

/// A run of the seeds 1 to 5 whose records are in one file.
fn open_table(out: &Path, again: Again) -> StudyRun {
    let plan = Arc::new(plan(&[("seed", json!([1, 2, 3, 4, 5]))]).unwrap());
    StudyRun::open(plan, "", out, again, Share::ALL, Some(StudyLayout::Table)).unwrap()
}

/// A kill or a full disk tears the last line; the next record begins on a line of its own.
#[test]
fn a_torn_or_damaged_record_of_many_is_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join(RECORDS);
    let run = open_table(folder.path(), Again::None);
    run.drive(1, (), &|_| (), &|number| Ok((number < 4).then(|| outcome(number)))).unwrap();
    drop(run);
    let text = std::fs::read_to_string(&place).unwrap();
    std::fs::write(&place, text[..text.len() - 20].replacen("\"n\":1", "\"n\":7", 1)).unwrap();
    let run = open_table(folder.path(), Again::None);
    assert_eq!((run.left(), run.tally().before), (vec![1, 3, 4], 2));
    run.drive(2, (), &|_| (), &|number| Ok(Some(outcome(number)))).unwrap();
    assert_eq!(run.save_tables(()).unwrap().rows(), 5);
    let found: Vec<_> = run.records().iter().map(|record| record.results.get("n").cloned()).collect();
    assert_eq!(found, [Some(json!(0)), Some(json!(1)), None, Some(json!(3)), Some(json!(4))]);
    assert_eq!(std::fs::read_to_string(&place).unwrap().lines().count(), 5);
}

/// Two runs at the same time take each other's records into account, also where one has put them in order meanwhile.
#[test]
fn runs_with_records_in_one_file_do_no_case_twice_and_failed_ones_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let runs = [(); 2].map(|()| open_table(folder.path(), Again::None));
    let calls = AtomicUsize::new(0);
    let work = |number| {
        calls.fetch_add(1, Ordering::SeqCst);
        Ok(Some(outcome(number)))
    };
    for run in &runs {
        run.drive(3, (), &|_| (), &work).unwrap();
        run.save_tables(()).unwrap();
        assert_eq!((run.tally().done, run.tally().failed, calls.load(Ordering::SeqCst)), (4, 1, 5));
    }
    drop(runs);
    let again = open_table(folder.path(), Again::Failed);
    assert_eq!(again.left(), [2]);
    again.drive(1, (), &|_| (), &|_| Ok(Some(Ok(Map::new()).into()))).unwrap();
    assert_eq!((again.save_tables(()).unwrap().rows(), again.tally().done), (5, 5));
    drop(again);
    assert_eq!(open_table(folder.path(), Again::All).left(), [0, 1, 2, 3, 4]);
    assert!(open_table(folder.path(), Again::None).left().is_empty());
    let mut names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    names.sort_unstable();
    assert_eq!(names, ["ensemble.csv", "records.jsonl", "table.csv"]);
}

/// A case in the hand of another process is waited for; the case of a killed one is taken over. Both come last, so that a case
/// that ends its process holds up no other.
#[test]
fn cases_of_other_processes_come_last_and_are_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let cases = plan(&[("seed", json!([1, 2]))]).unwrap().cases;
    let [of_killed, of_other] = [0, 1].map(|number: usize| folder.path().join(&cases[number].folder));
    for path in [&of_killed, &of_other] {
        std::fs::create_dir_all(path).unwrap();
    }
    std::fs::write(of_killed.join(LOCK), "4194305\n").unwrap();
    // As another process has it: its hidden file is not in the list of this one.
    let other = std::fs::File::create(of_other.join(LOCK)).unwrap();
    other.lock().unwrap();
    let other = std::sync::Mutex::new(Some(other));
    let run = open(folder.path(), Again::None).unwrap();
    assert_eq!(run.left(), [2, 3, 4, 0, 1]);
    let (waits, order) = (AtomicUsize::new(0), std::sync::Mutex::new(Vec::new()));
    let hears = |heard| match heard {
        Heard::Waits(number) => {
            assert_eq!(number, 1);
            // The other process ends at the second look.
            if waits.fetch_add(1, Ordering::SeqCst) == 1 {
                drop(other.lock().unwrap().take());
            }
        }
        Heard::Starts(number) => order.lock().unwrap().push(number),
    };
    run.drive(1, (), &hears, &|number| Ok(Some(outcome(number)))).unwrap();
    assert_eq!((order.into_inner().unwrap(), waits.into_inner()), (vec![2, 3, 4, 0, 1], 2));
}

#[test]
fn a_case_that_this_process_works_on_is_refused_and_not_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let runs = [open(folder.path(), Again::None).unwrap(), open(folder.path(), Again::None).unwrap()];
    let Begun::Turn(turn) = runs[0].begin(0, &()).unwrap() else { panic!("the case is free") };
    assert!(turn.is_exclusive() && !turn.is_packed() && turn.path().is_dir());
    assert!(matches!(runs[1].begin(0, &()), Err(RunError::Lock(LockError::Busy { .. }))));
    turn.leave(&());
    assert!(matches!(runs[1].begin(0, &()), Ok(Begun::Turn(_))));
}

#[test]
fn a_case_that_cannot_be_recorded_ends_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let run = open(folder.path(), Again::None).unwrap();
    let case = plan(&[("seed", json!([2]))]).unwrap().cases.remove(0);
    std::fs::write(folder.path().join(&case.folder), "a file").unwrap();
    let error = run.drive(1, (), &|_| (), &|number| Ok(Some(outcome(number)))).unwrap_err();
    assert!(matches!(&error, RunError::File { path, .. } if path.ends_with(&case.folder)), "{error}");
    assert_eq!(run.records().iter().map(|record| record.status).collect::<Vec<_>>(), [Status::Done]);
}

/// A disk without room is no fault of a case: it stays open, and so do those that would fail like it.
#[test]
fn a_full_disk_ends_the_run_and_fails_no_case() {
    let folder = tempfile::tempdir().unwrap();
    let full = || AskError::files("m.vtu: no room".to_owned(), &std::io::ErrorKind::StorageFull.into());
    let run = open(folder.path(), Again::None).unwrap();
    let work = |number: usize| if number == 1 { Err(full()) } else { Ok(Some(outcome(number))) };
    let error = run.drive(1, (), &|_| (), &work).unwrap_err();
    assert_eq!(error.to_string(), "m.vtu: no room; the same command then goes on");
    drop(run);
    let again = open(folder.path(), Again::None).unwrap();
    assert_eq!(again.left(), [1, 2, 3, 4]);
    again.drive(1, (), &|_| (), &|number| Ok(Some(outcome(number)))).unwrap();
    assert_eq!(again.tally().over(), 5);
}
