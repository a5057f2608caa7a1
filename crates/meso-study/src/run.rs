//! Runs a study in its folder: the cases that are left, the record of each, the tables at the end.
//!
//! A front gives the work on a case and shows the progress. [`StudyRun::drive`] does the cases in threads of this process; a
//! front with executors of its own calls [`StudyRun::begin`] and [`StudyRun::end`] around each case.

use crate::folder::save_tables;
use crate::plan::Plan;
use crate::record::{CaseOutcome, CaseState, Record, Status};
use crate::table::Table;
use meso_files::lock::{Held, LockError, hold};
use meso_files::whole::Keeper;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Finished cases that run again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Again {
    /// No case.
    #[default]
    None,
    /// Cases that failed.
    Failed,
    /// Every case.
    All,
}

/// Why a study cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Another process works in the folder.
    #[error(transparent)]
    Lock(#[from] LockError),
    /// A file that cannot be read or written.
    #[error("{}: {}", path.display(), meso_files::reason(error))]
    File {
        /// The file or its folder.
        path: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
}

/// Numbers of cases.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// All cases of the study.
    pub cases: usize,
    /// Cases that were over before this run.
    pub before: usize,
    /// Cases with results.
    pub done: usize,
    /// Cases with an error.
    pub failed: usize,
}

impl Tally {
    /// Number of cases that are done or failed.
    pub fn over(&self) -> usize {
        self.done + self.failed
    }
}

/// A case during a run.
enum Slot {
    Left { is_packed: bool },
    Over(Box<Record>),
}

/// A study while it runs; its folder is locked until this is dropped.
pub struct StudyRun {
    plan: Arc<Plan>,
    then: String,
    out: PathBuf,
    slots: Mutex<Vec<Slot>>,
    before: usize,
    held: Mutex<Option<Held>>,
}

impl StudyRun {
    /// Makes and locks the folder `out`, and looks which cases of `plan` are over; `then` is the field of [`Record`].
    ///
    /// # Errors
    /// [`RunError::Lock`] where another run works in `out`, and errors of the file system.
    pub fn open(plan: Arc<Plan>, then: &str, out: &Path, again: Again) -> Result<Self, RunError> {
        std::fs::create_dir_all(out).map_err(|error| RunError::File { path: out.to_owned(), error })?;
        let held = hold(out)?;
        let slots: Vec<Slot> = plan
            .cases
            .iter()
            .map(|case| {
                let folder = out.join(&case.folder);
                if again == Again::All {
                    Slot::Left { is_packed: false }
                } else {
                    slot(CaseState::of(case, then, &folder), again, &folder)
                }
            })
            .collect();
        let before = slots.iter().filter(|slot| matches!(slot, Slot::Over(_))).count();
        let (slots, held) = (Mutex::new(slots), Mutex::new(Some(held)));
        Ok(Self { plan, then: then.to_owned(), out: out.to_owned(), slots, before, held })
    }

    /// The study's folder.
    pub fn out(&self) -> &Path {
        &self.out
    }

    /// The lock's file, for a program that may end without dropping this.
    pub fn lock_file(&self) -> Option<PathBuf> {
        lock(&self.held).as_ref().map(|held| held.path().to_owned())
    }

    /// Frees the folder for other runs.
    pub fn close(&self) {
        drop(lock(&self.held).take());
    }

    /// Closes the lock in a forked process, where it belongs to the parent, and leaves it locked.
    pub fn leave_lock_to_parent(&self) {
        // Another thread of the parent may have held the mutex while the process was forked.
        if let Some(held) = self.held.try_lock().ok().and_then(|mut held| held.take()) {
            held.leave();
        }
    }

    /// Numbers of the cases that are not over, in order.
    pub fn left(&self) -> Vec<usize> {
        let slots = lock(&self.slots);
        (0..).zip(&*slots).filter(|(_, slot)| matches!(slot, Slot::Left { .. })).map(|(number, _)| number).collect()
    }

    /// Counts the cases.
    pub fn tally(&self) -> Tally {
        let slots = lock(&self.slots);
        let failed = over(&slots).filter(|record| record.status == Status::Failed).count();
        let done = over(&slots).count() - failed;
        Tally { cases: slots.len(), before: self.before, done, failed }
    }

    /// Records of the cases that are over, in order.
    pub fn records(&self) -> Vec<Record> {
        over(&lock(&self.slots)).cloned().collect()
    }

    /// Prepares the folder of case `number`; true where its packing is there, so that only the work on it is left.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn begin(&self, number: usize) -> Result<bool, RunError> {
        let is_packed = matches!(lock(&self.slots)[number], Slot::Left { is_packed: true });
        let state = if is_packed { CaseState::Packed } else { CaseState::Open };
        let path = self.folder(number);
        state.prepare(&path).map(|()| is_packed).map_err(|error| RunError::File { path, error })
    }

    /// Records the outcome of case `number`.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn end(&self, number: usize, outcome: CaseOutcome, keeper: impl Keeper) -> Result<(), RunError> {
        let path = self.folder(number);
        let made = Record::new(&self.plan.cases[number], &self.then, outcome, &path);
        let record = made.and_then(|record| record.save(&path, keeper).map(|()| record));
        let record = record.map_err(|error| RunError::File { path, error })?;
        lock(&self.slots)[number] = Slot::Over(Box::new(record));
        Ok(())
    }

    /// Does the cases that are left, `jobs` at a time, until all are over, one cannot be recorded, or `work` gives `None`.
    /// `starts` hears of every case before its work.
    ///
    /// # Errors
    /// The first error of [`begin`](Self::begin) or [`end`](Self::end); other cases at work are recorded before.
    pub fn drive(
        &self,
        jobs: u16,
        keeper: impl Keeper + Copy + Sync,
        starts: &(dyn Fn(usize) + Sync),
        work: &(dyn Fn(usize) -> Option<CaseOutcome> + Sync),
    ) -> Result<(), RunError> {
        let left = Mutex::new(self.left().into_iter());
        let one = |number: usize| -> Result<bool, RunError> {
            starts(number);
            self.begin(number)?;
            let Some(outcome) = work(number) else { return Ok(false) };
            self.end(number, outcome, keeper).map(|()| true)
        };
        let turns = || -> Result<(), RunError> {
            loop {
                let Some(number) = lock(&left).next() else { return Ok(()) };
                let ended = one(number);
                if !matches!(ended, Ok(true)) {
                    // The other threads find no case any more.
                    lock(&left).by_ref().for_each(drop);
                    return ended.map(drop);
                }
            }
        };
        std::thread::scope(|scope| {
            let others: Vec<_> = (1..jobs).map(|_| scope.spawn(turns)).collect();
            let own = turns();
            let join = |other: std::thread::ScopedJoinHandle<'_, _>| {
                other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            others.into_iter().map(join).fold(own, Result::and)
        })
    }

    /// Writes the tables of the cases that are over; returns the table of all cases.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn save_tables(&self, keeper: impl Keeper + Copy) -> Result<Table, RunError> {
        let table = save_tables(&self.out, &self.plan.keys, &self.records(), keeper);
        table.map_err(|error| RunError::File { path: self.out.clone(), error })
    }

    fn folder(&self, number: usize) -> PathBuf {
        self.out.join(&self.plan.cases[number].folder)
    }
}

/// A case in `state`, where the cases `again` run once more. A failed case starts from its packing, if it has one.
fn slot(state: CaseState, again: Again, folder: &Path) -> Slot {
    match state {
        CaseState::Over(record) if record.status == Status::Failed && again == Again::Failed => {
            Slot::Left { is_packed: record.has_model(folder) }
        }
        CaseState::Over(record) => Slot::Over(record),
        CaseState::Packed => Slot::Left { is_packed: true },
        CaseState::Open => Slot::Left { is_packed: false },
    }
}

fn over(slots: &[Slot]) -> impl Iterator<Item = &Record> {
    slots.iter().filter_map(|slot| if let Slot::Over(record) = slot { Some(&**record) } else { None })
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
