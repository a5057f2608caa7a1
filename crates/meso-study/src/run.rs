//! Runs a study in its folder: the cases that are left, the record of each, the tables at the end.
//!
//! Several processes may share a folder: a case belongs to the process that has locked its folder. [`CaseTurn`] is that of one
//! process on one case. [`StudyRun`] has the cases of one process; [`StudyRun::drive`] does them in threads, and a front with
//! executors of its own takes the turns on their workers.

use crate::case::{Case, digest};
use crate::ensemble::{REPLICATE, ensemble};
use crate::plan::Plan;
use crate::record::{CaseOutcome, CaseState, Record, Status, save};
use crate::table::{Table, tabulate};
use meso_files::lock::{Held, LOCK, LockError, hold, hold_as, join, patiently};
use meso_files::whole::{Keeper, Unit};
use serde::{Deserialize, Serialize};
use std::collections::{HashSet, VecDeque};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Names of the tables: all cases, then the ensembles.
pub const TABLES: [&str; 2] = ["table.csv", "ensemble.csv"];
/// Looks at the lock of the tables, which is held as long as it takes to write them: a minute in all.
const TRIES: u32 = 12_000;
/// Time between two looks at a case that another process works on.
const PAUSE: Duration = Duration::from_millis(50);
/// Digits of the hash in the name of a work.
const WORK: usize = 16;

/// Finished cases that run again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Again {
    /// No case.
    #[default]
    None,
    /// Cases that failed.
    Failed,
    /// Every case.
    All,
}

/// The cases of a process: number `shard` of `of` parts of a study, each with every `of`-th case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Share {
    /// Number of the part, from 1 on.
    pub shard: usize,
    /// Number of parts.
    pub of: usize,
}

impl Share {
    /// Every case.
    pub const ALL: Self = Self { shard: 1, of: 1 };

    fn has(self, number: usize) -> bool {
        number % self.of == self.shard - 1
    }
}

/// What a front hears of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Heard {
    /// A case begins.
    Starts(usize),
    /// Nothing is left but a case that another process works on.
    Waits(usize),
}

/// Why a study cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Another process does other work in the folder.
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
    /// Cases of this run.
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

/// Work of this process on a case, whose folder is locked until this is dropped.
pub struct CaseTurn {
    path: PathBuf,
    held: Held,
    is_packed: bool,
}

/// A case before the work.
pub enum Begun {
    /// Nobody else works on it, and it is not over.
    Turn(CaseTurn),
    /// It is over.
    Over(Status),
    /// Another process works on it.
    Busy,
}

impl CaseTurn {
    /// Locks and prepares the folder of `case` in `out`, unless it is over; `then` is the field of [`Record`].
    ///
    /// # Errors
    /// Errors of the file system, and [`RunError::Lock`] where this process works on the case already.
    pub fn begin(case: &Case, then: &str, out: &Path, again: Again, keeper: &impl Keeper) -> Result<Begun, RunError> {
        let path = out.join(&case.folder);
        let file = |error| RunError::File { path: path.clone(), error };
        std::fs::create_dir_all(&path).map_err(file)?;
        let taken = keeper.hold(|hidden| hold(&path).inspect(|held| hidden.push(held.path().to_owned())));
        let held = match taken {
            Err(LockError::Busy { is_own: false, .. }) => return Ok(Begun::Busy),
            taken => taken?,
        };
        let mut turn = Self { path: path.clone(), held, is_packed: false };
        let state = if again == Again::All { CaseState::Open } else { CaseState::of(case, then, &path) };
        match state {
            CaseState::Over(record) if record.status == Status::Done || again != Again::Failed => {
                turn.leave(keeper);
                return Ok(Begun::Over(record.status));
            }
            // A failed case starts from its packing, if it has one.
            CaseState::Over(record) => turn.is_packed = record.has_model(&path),
            CaseState::Packed => turn.is_packed = true,
            CaseState::Open => {}
        }
        let state = if turn.is_packed { CaseState::Packed } else { CaseState::Open };
        if let Err(error) = state.prepare(&path) {
            turn.leave(keeper);
            return Err(file(error));
        }
        Ok(Begun::Turn(turn))
    }

    /// The folder of the case.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether the packing is there, so that only the work on it is left.
    pub fn is_packed(&self) -> bool {
        self.is_packed
    }

    /// False on a file system without locks, where two processes may do a case at the same time.
    pub fn is_exclusive(&self) -> bool {
        self.held.is_exclusive()
    }

    /// Records the outcome of the case, and frees its folder.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn end(
        self,
        case: &Case,
        then: &str,
        outcome: CaseOutcome,
        keeper: impl Keeper + Copy,
    ) -> Result<Status, RunError> {
        let made = Record::new(case, then, outcome, &self.path);
        let saved = made.and_then(|record| record.save(&self.path, keeper).map(|()| record.status));
        let saved = saved.map_err(|error| RunError::File { path: self.path.clone(), error });
        self.leave(&keeper);
        saved
    }

    /// Frees the folder of the case, which stays open.
    pub fn leave(self, keeper: &impl Keeper) {
        keeper.hold(|hidden| {
            hidden.retain(|path| path != self.held.path());
            drop(self.held);
        });
    }

    /// Closes the lock in a forked process, where it belongs to the parent, and leaves it locked.
    pub fn leave_to_parent(self) {
        self.held.leave();
    }
}

/// A case during a run.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Slot {
    /// It belongs to another process.
    Elsewhere,
    Left,
    /// Left, and another process works on it or died at it.
    Touched,
    Over(Status),
}

/// The cases of a study that this process does. Until this is dropped no other work is done in the folder.
pub struct StudyRun {
    plan: Arc<Plan>,
    then: String,
    out: PathBuf,
    again: Again,
    slots: Mutex<Vec<Slot>>,
    before: usize,
    held: Mutex<Vec<Held>>,
}

impl StudyRun {
    /// Makes the folder `out` and looks which cases of `share` are over; `then` is the field of [`Record`]. Processes share the
    /// cases that were never over. What runs `again` belongs to one process for each part of a study: another one would do
    /// it once more.
    ///
    /// # Errors
    /// [`RunError::Lock`] where another process does other work in `out`, and errors of the file system.
    pub fn open(plan: Arc<Plan>, then: &str, out: &Path, again: Again, share: Share) -> Result<Self, RunError> {
        let fail = |error| RunError::File { path: out.to_owned(), error };
        std::fs::create_dir_all(out).map_err(fail)?;
        let Share { shard, of } = share;
        // The same cases by the same function; a run of all cases has none beside it but those of its parts.
        let parts = if again == Again::All { format!("all {of}") } else { String::new() };
        let cases: Vec<&str> = plan.cases.iter().map(|case| &*case.folder).collect();
        let mut held = vec![join(out, &digest(format!("{then} {parts} {}", cases.join(" ")).as_bytes())[..WORK])?];
        if again != Again::None {
            held.push(hold_as(out, &format!("{LOCK}-{shard}-of-{of}"))?);
        }
        Self::of(plan, then, out, again, share, held)
    }

    /// The cases that are over in a folder that is there, of which nothing is locked: for the tables.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn look(plan: Arc<Plan>, then: &str, out: &Path) -> Result<Self, RunError> {
        Self::of(plan, then, out, Again::None, Share::ALL, Vec::new())
    }

    fn of(
        plan: Arc<Plan>,
        then: &str,
        out: &Path,
        again: Again,
        share: Share,
        held: Vec<Held>,
    ) -> Result<Self, RunError> {
        let fail = |error| RunError::File { path: out.to_owned(), error };
        let there = std::fs::read_dir(out).and_then(|entries| entries.map(|entry| Ok(entry?.file_name())).collect());
        let there: HashSet<_> = there.map_err(fail)?;
        let look = |(number, case): (usize, &Case)| {
            let folder = out.join(&case.folder);
            match () {
                () if !share.has(number) => Slot::Elsewhere,
                () if !there.contains(std::ffi::OsStr::new(&case.folder)) => Slot::Left,
                () if folder.join(LOCK).exists() => Slot::Touched,
                () if again == Again::All => Slot::Left,
                () => slot(CaseState::of(case, then, &folder), again),
            }
        };
        let slots: Vec<Slot> = plan.cases.iter().enumerate().map(|(number, case)| look((number, case))).collect();
        let before = slots.iter().filter(|slot| matches!(slot, Slot::Over(_))).count();
        let (slots, held, then, out) = (Mutex::new(slots), Mutex::new(held), then.to_owned(), out.to_owned());
        Ok(Self { plan, then, out, again, slots, before, held })
    }

    /// The study's folder.
    pub fn out(&self) -> &Path {
        &self.out
    }

    /// False on a file system without locks, where two processes may do a case at the same time.
    pub fn is_exclusive(&self) -> bool {
        lock(&self.held).iter().all(Held::is_exclusive)
    }

    /// Frees the folder for other work.
    pub fn close(&self) {
        lock(&self.held).clear();
    }

    /// Closes the lock in a forked process, where it belongs to the parent, and leaves it locked.
    pub fn leave_lock_to_parent(&self) {
        // Another thread of the parent may have held the mutex while the process was forked.
        if let Ok(mut held) = self.held.try_lock() {
            held.drain(..).for_each(Held::leave);
        }
    }

    /// Numbers of the cases that are not over, in order; last those that another process works on or died at.
    pub fn left(&self) -> Vec<usize> {
        let slots = lock(&self.slots);
        let like =
            |wanted: Slot| (0..).zip(&*slots).filter(move |(_, slot)| **slot == wanted).map(|(number, _)| number);
        like(Slot::Left).chain(like(Slot::Touched)).collect()
    }

    /// Counts the cases.
    pub fn tally(&self) -> Tally {
        let slots = lock(&self.slots);
        let count = |wanted: Slot| slots.iter().filter(|slot| **slot == wanted).count();
        let cases = slots.len() - count(Slot::Elsewhere);
        let (done, failed) = (count(Slot::Over(Status::Done)), count(Slot::Over(Status::Failed)));
        Tally { cases, before: self.before, done, failed }
    }

    /// Records of the cases of this run that are over, in order.
    pub fn records(&self) -> Vec<Record> {
        let numbers: Vec<usize> = {
            let slots = lock(&self.slots);
            (0..slots.len()).filter(|number| slots[*number] != Slot::Elsewhere).collect()
        };
        numbers.into_iter().filter_map(|number| self.record(&self.plan.cases[number])).collect()
    }

    fn record(&self, case: &Case) -> Option<Record> {
        match CaseState::of(case, &self.then, &self.out.join(&case.folder)) {
            CaseState::Over(record) => Some(*record),
            CaseState::Packed | CaseState::Open => None,
        }
    }

    /// Takes the turn of this process on case `number`.
    ///
    /// # Errors
    /// See [`CaseTurn::begin`].
    pub fn begin(&self, number: usize, keeper: &impl Keeper) -> Result<Begun, RunError> {
        let begun = CaseTurn::begin(&self.plan.cases[number], &self.then, &self.out, self.again, keeper)?;
        if let Begun::Over(status) = begun {
            self.note(number, status);
        }
        Ok(begun)
    }

    /// Records the outcome of case `number`.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn end(
        &self,
        number: usize,
        turn: CaseTurn,
        outcome: CaseOutcome,
        keeper: impl Keeper + Copy,
    ) -> Result<(), RunError> {
        let status = turn.end(&self.plan.cases[number], &self.then, outcome, keeper)?;
        self.note(number, status);
        Ok(())
    }

    /// Takes note of a case that is over.
    pub fn note(&self, number: usize, status: Status) {
        lock(&self.slots)[number] = Slot::Over(status);
    }

    /// Does the cases that are left, `jobs` at a time, until all are over, one cannot be recorded, or `work` gives `None`. It
    /// waits for cases of other processes, and takes over those of a process that ended. `hears` is told of every case.
    ///
    /// # Errors
    /// The first error of [`begin`](Self::begin) or [`end`](Self::end); other cases at work are recorded before.
    pub fn drive(
        &self,
        jobs: u16,
        keeper: impl Keeper + Copy + Sync,
        hears: &(dyn Fn(Heard) + Sync),
        work: &(dyn Fn(usize) -> Option<CaseOutcome> + Sync),
    ) -> Result<(), RunError> {
        let left = Mutex::new(VecDeque::from(self.left()));
        // Whether the run goes on.
        let one = |number: usize| -> Result<bool, RunError> {
            match self.begin(number, &keeper)? {
                Begun::Over(_) => Ok(true),
                Begun::Busy => {
                    lock(&left).push_back(number);
                    hears(Heard::Waits(number));
                    std::thread::sleep(PAUSE);
                    Ok(true)
                }
                Begun::Turn(turn) => {
                    hears(Heard::Starts(number));
                    match work(number) {
                        Some(outcome) => self.end(number, turn, outcome, keeper).map(|()| true),
                        None => {
                            turn.leave(&keeper);
                            Ok(false)
                        }
                    }
                }
            }
        };
        let turns = || -> Result<(), RunError> {
            loop {
                let Some(number) = lock(&left).pop_front() else { return Ok(()) };
                let ended = one(number);
                if !matches!(ended, Ok(true)) {
                    // The other threads find no case any more.
                    lock(&left).clear();
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

    /// Writes the tables of all cases that are over; returns the table of the cases.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn save_tables(&self, keeper: impl Keeper + Copy) -> Result<Table, RunError> {
        let records = || self.plan.cases.iter().filter_map(|case| self.record(case)).collect::<Vec<_>>();
        save_tables(&self.out, &self.plan.keys, &records, keeper)
    }
}

/// Writes the tables of `records` into `out`, each whole or not at all; returns the table of all cases. `keeper` removes
/// temporary files after a signal. Processes that end at the same time write one after the other, so that the last one
/// finds the records of all.
///
/// # Errors
/// Errors of the file system.
pub fn save_tables<K: Keeper + Copy>(
    out: &Path,
    keys: &[String],
    records: &dyn Fn() -> Vec<Record>,
    keeper: K,
) -> Result<Table, RunError> {
    let take = || keeper.hold(|hidden| hold(out).inspect(|held| hidden.push(held.path().to_owned())));
    let held = patiently(TRIES, take)?;
    let table = tabulate(keys, &records());
    let groups = ensemble(&table, keys, REPLICATE);
    let saved = save(out, TABLES[0], Unit::new(keeper), |file| table.write_csv(file))
        .and_then(|()| save(out, TABLES[1], Unit::new(keeper), |file| groups.write_csv(file)));
    keeper.hold(|hidden| {
        hidden.retain(|path| path != held.path());
        drop(held);
    });
    saved.map(|()| table).map_err(|error| RunError::File { path: out.to_owned(), error })
}

/// A case in `state`, where the cases `again` run once more.
fn slot(state: CaseState, again: Again) -> Slot {
    match state {
        CaseState::Over(record) if record.status == Status::Failed && again == Again::Failed => Slot::Left,
        CaseState::Over(record) => Slot::Over(record.status),
        CaseState::Packed | CaseState::Open => Slot::Left,
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
