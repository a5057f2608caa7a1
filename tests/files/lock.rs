//! A folder has one holder. The faults came from two processes that wrote into one folder of results.

use meso_files::lock::{LOCK, LockError, hold, join};
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn a_second_holder_is_refused_with_the_number_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let held = hold(folder.path()).unwrap();
    assert!(held.is_exclusive() && held.path() == folder.path().join(LOCK));
    let error = hold(folder.path()).unwrap_err();
    assert!(matches!(error, LockError::Busy { .. }), "{error:?}");
    if cfg!(unix) {
        let number = format!(" is in use by process {}; wait until it ends", std::process::id());
        assert!(error.to_string().contains(&number), "{error}");
    }
    drop(held);
    assert!(!folder.path().join(LOCK).exists());
    hold(folder.path()).unwrap();
}

#[test]
fn a_lock_file_without_a_process_is_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    for left in ["4194305\n", "", "not a number", "\u{fffd}"] {
        std::fs::write(folder.path().join(LOCK), left).unwrap();
        drop(hold(folder.path()).unwrap());
        assert!(!folder.path().join(LOCK).exists(), "{left:?}");
    }
}

#[test]
fn a_folder_that_is_absent_is_named() {
    let error = hold(Path::new("none/here")).unwrap_err();
    assert!(error.to_string().contains("none/here") && matches!(error, LockError::File { .. }), "{error}");
}

#[test]
fn at_most_one_of_eight_threads_holds_a_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (inside, refused) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        for _ in 0..25 {
            let held = loop {
                match hold(folder.path()) {
                    Ok(held) => break held,
                    Err(LockError::Busy { .. }) => refused.fetch_add(1, Ordering::SeqCst),
                    Err(error) => panic!("{error}"),
                };
                std::thread::yield_now();
            };
            assert_eq!(inside.fetch_add(1, Ordering::SeqCst), 0);
            std::thread::yield_now();
            assert_eq!(inside.fetch_sub(1, Ordering::SeqCst), 1);
            drop(held);
        }
    };
    std::thread::scope(|scope| (0..8).for_each(|_| drop(scope.spawn(work))));
    // Somebody came while the folder was held, so the trial was one.
    assert!(refused.load(Ordering::SeqCst) > 0, "{refused:?}");
}

#[test]
fn equal_works_share_a_folder_and_another_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let files = || std::fs::read_dir(folder.path()).unwrap().count();
    // The file of a killed process.
    std::fs::write(folder.path().join(".mesocrete-c0.lock"), "4194305\n").unwrap();
    let held = [join(folder.path(), "a1").unwrap(), join(folder.path(), "a1").unwrap()];
    assert_eq!(files(), 1);
    let [first, second] = held;
    drop(first);
    assert!(matches!(join(folder.path(), "b2"), Err(LockError::Busy { .. })));
    // The lock of moments is another one.
    drop(hold(folder.path()).unwrap());
    drop(second);
    assert_eq!(files(), 0);
    drop(join(folder.path(), "b2").unwrap());
    assert_eq!(files(), 0);
}

/// The case: in two containers both processes had the number 1, and one took the other's lock for its own.
#[test]
fn a_lock_is_not_this_process_s_own_for_its_number() {
    let folder = tempfile::tempdir().unwrap();
    let held = hold(folder.path()).unwrap();
    assert!(matches!(hold(folder.path()), Err(LockError::Busy { is_own: true, .. })));
    drop(held);
    // A lock of this process that the list of its own does not have: as another machine's with the same number.
    let file = std::fs::File::create(folder.path().join(LOCK)).unwrap();
    file.lock().unwrap();
    std::fs::write(folder.path().join(LOCK), format!("{}\n", std::process::id())).unwrap();
    assert!(matches!(hold(folder.path()), Err(LockError::Busy { is_own: false, .. })));
}
