//! Runs a study in its folder: the cases that are left, the record of each, the tables at the end.
//!
//! Several processes may share a folder: a case belongs to the process that has locked its folder. [`CaseTurn`] is that of one
//! process on one case. [`StudyRun`] has the cases of one process; [`StudyRun::drive`] does them in threads, and a front with
//! executors of its own takes the turns on their workers.

use crate::case::{Case, digest};
use crate::ensemble::{REPLICATE, ensemble};
use crate::journal::{self, Seen, StudyLayout};
use crate::plan::Plan;
use crate::record::{CaseOutcome, CaseState, RECORD, Record, Status, save};
use crate::table::{Table, tabulate};
use meso_ask::AskError;
use meso_files::lock::{Held, LOCK, LockError, hold, hold_as, join, patiently};
use meso_files::whole::{self, Keeper, Unit};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Names of the tables: all cases, then the ensembles.
pub const TABLES: [&str; 2] = ["table.csv", "ensemble.csv"];
/// Looks at the lock of the tables, which is held as long as it takes to write them: a minute in all.
const TRIES: u32 = 12_000;
/// Time between two looks at a case that another process works on.
const PAUSE: Duration = Duration::from_millis(50);
/// Digits of the hash in the name of a work.
pub(crate) const WORK: usize = 16;

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
    /// A disk that has no room for the files of a case, which stays open.
    #[error("{0}; the same command then goes on")]
    Full(AskError),
    /// A study of another layout is in the folder.
    #[error("{} has a study of another layout, which stays as it is; leave the layout out, or name another folder", _0.display())]
    Layout(PathBuf),
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
    /// Cases in the hand of [`StudyRun::drive`].
    pub running: usize,
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
    layout: StudyLayout,
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
    /// Locks and prepares the folder of `case` in `out`, unless it is over; `then` is the field of [`Record`]. Of records in one
    /// file those that were `seen` have none of the case.
    ///
    /// # Errors
    /// Errors of the file system, and [`RunError::Lock`] where this process works on the case already.
    pub fn begin(
        case: &Case,
        then: &str,
        out: &Path,
        again: Again,
        seen: Seen,
        keeper: &impl Keeper,
    ) -> Result<Begun, RunError> {
        let path = out.join(&case.folder);
        let file = |error| RunError::File { path: path.clone(), error };
        let held = loop {
            std::fs::create_dir_all(&path).map_err(file)?;
            match keeper.hold(|hidden| hold(&path).inspect(|held| hidden.push(held.path().to_owned()))) {
                Err(LockError::Busy { is_own: false, .. }) => return Ok(Begun::Busy),
                // Whoever had ended the case removed the folder.
                Err(LockError::File { error, .. }) if error.kind() == io::ErrorKind::NotFound => {}
                taken => break taken?,
            }
        };
        let mut turn = Self { path: path.clone(), held, is_packed: false, layout: StudyLayout::of(out) };
        let state = match turn.layout {
            _ if again == Again::All => CaseState::Open,
            StudyLayout::Folders => CaseState::of(case, then, &path),
            StudyLayout::Table => journal::state(case, then, out, seen).map_err(file)?,
        };
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
        let fail = |error| RunError::File { path: self.path.clone(), error };
        let saved = Record::new(case, then, outcome, &self.path).map_err(fail).and_then(|record| {
            let status = record.status;
            if self.layout == StudyLayout::Folders {
                return record.save(&self.path, keeper).map(|()| status).map_err(fail);
            }
            let (out, record) = (whole::folder(&self.path), record.without_files());
            alone(out, &keeper, || journal::append(out, &record))?.map_err(fail)?;
            clear(&self.path).map(|()| status).map_err(fail)
        });
        self.leave(&keeper);
        saved
    }

    /// Frees the folder of the case, which stays open.
    pub fn leave(self, keeper: &impl Keeper) {
        free(self.held, keeper);
        if self.layout == StudyLayout::Table {
            // One with files stays.
            let _ = std::fs::remove_dir(&self.path);
        }
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
    running: AtomicUsize,
    held: Mutex<Vec<Held>>,
    /// Of records in one file: what has been read of them, and the numbers of the cases by their hashes.
    listed: Option<Mutex<(Seen, HashMap<String, usize>)>>,
}

impl StudyRun {
    /// Makes the folder `out` and looks which cases of `share` are over; `then` is the field of [`Record`]. Processes share the
    /// cases that were never over. What runs `again` belongs to one process for each part of a study: another one would do
    /// it once more. Absent: the `layout` of the study in `out`, of a new one folders.
    ///
    /// # Errors
    /// [`RunError::Lock`] where another process does other work in `out`, and errors of the file system.
    pub fn open(
        plan: Arc<Plan>,
        then: &str,
        out: &Path,
        again: Again,
        share: Share,
        layout: Option<StudyLayout>,
    ) -> Result<Self, RunError> {
        let fail = |error| RunError::File { path: out.to_owned(), error };
        std::fs::create_dir_all(out).map_err(fail)?;
        let Share { shard, of } = share;
        // The same cases by the same function; a run of all cases has none beside it but those of its parts.
        let parts = if again == Again::All { format!("all {of}") } else { String::new() };
        let cases = || plan.cases.iter().map(|case| &*case.folder).collect::<Vec<_>>().join(" ");
        let work = || digest(format!("{then} {parts} {}", cases()).as_bytes())[..WORK].to_owned();
        let mut held = vec![join(out, &plan.work.clone().unwrap_or_else(work))?];
        if again != Again::None {
            held.push(hold_as(out, &format!("{LOCK}-{shard}-of-{of}"))?);
        }
        if !layout.map_or(Ok(true), |layout| layout.begin(out)).map_err(fail)? {
            return Err(RunError::Layout(out.to_owned()));
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
                () => match CaseState::of(case, then, &folder) {
                    CaseState::Over(record) => Slot::Over(record.status),
                    CaseState::Packed | CaseState::Open => Slot::Left,
                },
            }
        };
        let slots: Vec<Slot> = plan.cases.iter().enumerate().map(|(number, case)| look((number, case))).collect();
        let listed = (StudyLayout::of(out) == StudyLayout::Table).then(|| {
            let hashes = plan.cases.iter().enumerate().map(|(number, case)| (case.hash.clone(), number));
            Mutex::new((Seen::default(), hashes.collect()))
        });
        let (slots, held, then, out) = (Mutex::new(slots), Mutex::new(held), then.to_owned(), out.to_owned());
        let mut run = Self { plan, then, out, again, slots, before: 0, running: AtomicUsize::new(0), held, listed };
        run.look_again(0)?;
        // What runs again is left whatever the records say.
        for slot in run.slots.get_mut().unwrap_or_else(PoisonError::into_inner) {
            let is_left = match *slot {
                Slot::Over(Status::Failed) => again != Again::None,
                Slot::Over(Status::Done) => again == Again::All,
                _ => false,
            };
            *slot = if is_left { Slot::Left } else { *slot };
        }
        run.before = run.tally().over();
        Ok(run)
    }

    /// Takes note of the records in one file that others have appended. Returns how much of it has been read, in which none is of
    /// case `number`.
    ///
    /// # Errors
    /// Errors of the file system.
    pub fn look_again(&self, number: usize) -> Result<Seen, RunError> {
        let Some(listed) = &self.listed else { return Ok(Seen::default()) };
        let (seen, numbers) = &mut *lock(listed);
        let mut slots = lock(&self.slots);
        let mut note = |record: Record| match numbers.get(&record.hash) {
            Some(&number) if record.then == self.then && slots[number] != Slot::Elsewhere => {
                slots[number] = Slot::Over(record.status);
            }
            _ => {}
        };
        let read = journal::read(&self.out, seen, &mut note);
        read.map_err(|error| RunError::File { path: self.out.clone(), error })?;
        Ok(if matches!(slots[number], Slot::Over(_)) { Seen::default() } else { *seen })
    }

    /// Whether the record of a case that is over can be read here.
    pub fn is_recorded(&self, number: usize) -> bool {
        match self.listed {
            None => self.out.join(&self.plan.cases[number].folder).join(RECORD).is_file(),
            Some(_) => self.look_again(number).is_ok() && self.status(number).is_some(),
        }
    }

    /// How a case ended; `None` where it is not over.
    pub fn status(&self, number: usize) -> Option<Status> {
        if let Slot::Over(status) = lock(&self.slots)[number] { Some(status) } else { None }
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
        Tally { cases, before: self.before, done, failed, running: self.running.load(Ordering::Relaxed) }
    }

    /// Records of the cases of this run that are over, in order.
    pub fn records(&self) -> Vec<Record> {
        let slots = lock(&self.slots).clone();
        records(&self.plan, &self.then, &self.out, &|number| slots[number] != Slot::Elsewhere)
    }

    /// Takes the turn of this process on case `number`.
    ///
    /// # Errors
    /// See [`CaseTurn::begin`].
    pub fn begin(&self, number: usize, keeper: &impl Keeper) -> Result<Begun, RunError> {
        let (case, seen) = (&self.plan.cases[number], self.look_again(number)?);
        let begun = CaseTurn::begin(case, &self.then, &self.out, self.again, seen, keeper)?;
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

    /// Does the cases that are left, `jobs` at a time, until all are over, one cannot be recorded, or `work` gives `None` or an
    /// error. It waits for cases of other processes, and takes over those of a process that ended. `hears` is told of every case.
    ///
    /// # Errors
    /// The first error of [`begin`](Self::begin), `work` or [`end`](Self::end); other cases at work are recorded before.
    pub fn drive(
        &self,
        jobs: u16,
        keeper: impl Keeper + Copy + Sync,
        hears: &(dyn Fn(Heard) + Sync),
        work: &(dyn Fn(usize) -> Result<Option<CaseOutcome>, AskError> + Sync),
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
                    self.running.fetch_add(1, Ordering::Relaxed);
                    hears(Heard::Starts(number));
                    let worked = work(number);
                    self.running.fetch_sub(1, Ordering::Relaxed);
                    match worked {
                        Ok(Some(outcome)) => self.end(number, turn, outcome, keeper).map(|()| true),
                        left => {
                            turn.leave(&keeper);
                            left.map(|_| false).map_err(RunError::Full)
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
        save_tables(&self.plan, &self.then, &self.out, keeper)
    }
}

/// Records of the cases of `plan` that are over in `out` and `wanted` by their numbers, in order.
pub fn records(plan: &Plan, then: &str, out: &Path, wanted: &dyn Fn(usize) -> bool) -> Vec<Record> {
    let cases = plan.cases.iter().enumerate().filter(|(number, _)| wanted(*number));
    let mut found: BTreeMap<usize, Record> = BTreeMap::new();
    if StudyLayout::of(out) == StudyLayout::Folders {
        found.extend(cases.filter_map(|(number, case)| match CaseState::of(case, then, &out.join(&case.folder)) {
            CaseState::Over(record) => Some((number, *record)),
            CaseState::Packed | CaseState::Open => None,
        }));
    } else {
        let numbers: HashMap<&str, usize> = cases.map(|(number, case)| (&*case.hash, number)).collect();
        let mut keep = |record: Record| match numbers.get(&*record.hash) {
            Some(number) if record.then == then => drop(found.insert(*number, record)),
            _ => {}
        };
        // What cannot be read counts as absent, like the record in a folder.
        let _ = journal::read(out, &mut Seen::default(), &mut keep);
    }
    found.into_values().collect()
}

/// Writes the tables of all cases that are over in `out`, each whole or not at all; returns the table of the cases. `keeper`
/// removes temporary files after a signal. Processes that end at the same time write one after the other, so that the last one
/// finds the records of all.
///
/// # Errors
/// Errors of the file system.
pub fn save_tables(plan: &Plan, then: &str, out: &Path, keeper: impl Keeper + Copy) -> Result<Table, RunError> {
    let tables = || {
        if StudyLayout::of(out) == StudyLayout::Table {
            journal::tidy(out, keeper)?;
        }
        let table = tabulate(&plan.keys, &records(plan, then, out, &|_| true));
        let groups = ensemble(&table, &plan.keys, REPLICATE);
        save(out, TABLES[0], Unit::new(keeper), |file| table.write_csv(file))?;
        save(out, TABLES[1], Unit::new(keeper), |file| groups.write_csv(file))?;
        Ok(table)
    };
    alone(out, &keeper, tables)?.map_err(|error| RunError::File { path: out.to_owned(), error })
}

/// Does short work in the folder of a study or a fit while no other process does such.
pub(crate) fn alone<T>(out: &Path, keeper: &impl Keeper, work: impl FnOnce() -> T) -> Result<T, LockError> {
    let take = || keeper.hold(|hidden| hold(out).inspect(|held| hidden.push(held.path().to_owned())));
    let held = patiently(TRIES, take)?;
    let done = work();
    free(held, keeper);
    Ok(done)
}

/// Gives back a lock, whose file a signal would have removed.
fn free(held: Held, keeper: &impl Keeper) {
    keeper.hold(|hidden| {
        hidden.retain(|path| path != held.path());
        drop(held);
    });
}

/// Removes what is in the folder of a case but its lock.
fn clear(folder: &Path) -> io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        match entry.file_type()?.is_dir() {
            true => std::fs::remove_dir_all(entry.path())?,
            false if entry.file_name() == LOCK => {}
            false => std::fs::remove_file(entry.path())?,
        }
    }
    Ok(())
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
