//! `mesocrete study`: every combination of some options, one folder each, and one table of all.

mod file;
mod steps;

use super::values;
use crate::failure::{Failure, INTERRUPTED};
use crate::outputs::Signals;
use crate::progress::{CLEAR, bar, show};
use crate::{interrupt, stderr};
use file::StudyFile;
use meso_study::{Case, Plan, Record, State, Status, TABLES, save_tables};
use std::io::{self, IsTerminal};
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use steps::Steps;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Study (TOML): `spec`, a file or a table; `[over]`, the options to vary; `outputs`, `[mesh]` and `[solve]`,
    /// the work on each packing; see docs/studies.md
    study: PathBuf,
    /// Folder of the study: a folder for each case, table.csv and ensemble.csv
    #[arg(short, long, value_name = "DIR", default_value = "study")]
    output: PathBuf,
    /// Run failed cases again, and leave finished ones
    #[arg(long)]
    retry_failed: bool,
    /// Run every case again, and replace its files
    #[arg(short, long)]
    force: bool,
    /// List the cases and their states, and run none
    #[arg(long)]
    dry_run: bool,
    /// Number of cases that run at the same time. It changes the time, never the result
    #[arg(short, long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    jobs: Option<u16>,
    /// Number of threads of a case; when absent the cores are shared among the cases at the same time
    #[arg(long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Print only warnings and errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let file = StudyFile::read(&args.study)?;
    let plan = file.plan()?;
    // Before the work: whatever cannot be is named while nothing is lost.
    let steps = plan.cases.iter().map(|case| file.steps(case, &args.output, args.threads()));
    let steps = steps.collect::<Result<Vec<Steps>, _>>()?;
    let states: Vec<State> = plan.cases.iter().map(|case| args.state(case)).collect();
    if args.dry_run {
        return list(&plan, &states);
    }
    std::fs::create_dir_all(&args.output).map_err(|error| Failure::file(&args.output, &error))?;
    let study = Study::new(args, &plan.cases, &states);
    study.run(&steps, &states)?;
    study.finish(&plan.keys)
}

impl Args {
    /// What is left to do of a case.
    fn state(&self, case: &Case) -> State {
        if self.force { State::Open } else { State::of(case, "", &self.output.join(&case.folder)) }
    }

    /// Threads of a case: cases at the same time share the cores.
    fn threads(&self) -> Option<u16> {
        let shared = |jobs: u16| {
            let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
            (cores / usize::from(jobs)).max(1) as u16
        };
        self.threads.or_else(|| self.jobs.filter(|jobs| *jobs > 1).map(shared))
    }
}

/// Prints each case's folder and whether it is done, failed or open.
fn list(plan: &Plan, states: &[State]) -> Result<u8, Failure> {
    crate::outputs::Unit::default().fill(&crate::outputs::Target::Stdout, false, |out| {
        plan.cases.iter().zip(states).try_for_each(|(case, state)| {
            let word = match state {
                State::Over(record) if record.status == Status::Failed => "failed",
                State::Over(_) => "done",
                State::Open | State::Packed => "open",
            };
            writeln!(out, "{word:6}  {}", case.folder)
        })
    })?;
    Ok(0)
}

/// A study while it runs.
struct Study<'a> {
    args: &'a Args,
    cases: &'a [Case],
    /// By case; none of those that are open.
    records: Mutex<Vec<Option<Record>>>,
    /// Cases that were done before.
    found: usize,
    seen: bool,
}

impl<'a> Study<'a> {
    fn new(args: &'a Args, cases: &'a [Case], states: &[State]) -> Self {
        let seen = !args.quiet && io::stderr().is_terminal();
        let records: Vec<Option<Record>> = states.iter().map(|state| over(state, args.retry_failed)).collect();
        let found = records.iter().flatten().count();
        Self { args, cases, records: Mutex::new(records), found, seen }
    }

    fn records(&self) -> MutexGuard<'_, Vec<Option<Record>>> {
        self.records.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does the open cases, as many at a time as asked, until all are done, one cannot be recorded or the user stops it.
    fn run(&self, steps: &[Steps], states: &[State]) -> Result<(), Failure> {
        let open: Vec<usize> =
            (0..).zip(&*self.records()).filter(|(_, record)| record.is_none()).map(|(i, _)| i).collect();
        let open = Mutex::new(open.into_iter());
        let next = || open.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || -> Result<(), Failure> {
            while let Some(number) = next().filter(|_| !interrupt::asked()) {
                self.draw(&self.cases[number]);
                let ended = self.case(&self.cases[number], &steps[number], &states[number]);
                if ended.is_err() {
                    // The others finish their cases and find nothing more to do.
                    while next().is_some() {}
                }
                self.records()[number] = ended?;
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let others: Vec<_> = (1..self.args.jobs.unwrap_or(1)).map(|_| scope.spawn(work)).collect();
            let own = work();
            others.into_iter().map(|other| other.join().unwrap_or(Err(Failure::Bug))).fold(own, Result::and)
        })
    }

    /// Does a case and writes its record; none where the user stopped it.
    fn case(&self, case: &Case, steps: &Steps, state: &State) -> Result<Option<Record>, Failure> {
        let folder = self.args.output.join(&case.folder);
        let fail = |error: io::Error| Failure::file(&folder, &error);
        state.prepare(&folder).map_err(fail)?;
        let ended = steps.run(case, &folder);
        if interrupt::asked() {
            return Ok(None);
        }
        let record = Record::new(case, "", ended, &folder).map_err(fail)?;
        record.save(&folder, Signals).map_err(fail)?;
        Ok(Some(record))
    }

    /// The one bar of the study.
    fn draw(&self, case: &Case) {
        if self.seen {
            let records = self.records();
            let (done, cases) = (records.iter().flatten().count(), self.cases.len());
            let bar = bar(done as f64 / cases as f64);
            let failed = failed(records.iter().flatten());
            show(&format!(
                "{CLEAR}{}",
                fit(&format!("study {bar} {done} of {cases}, {failed} failed: {}", case.folder))
            ));
        }
    }

    /// Writes the tables and says what became of the cases; the exit code.
    fn finish(self, keys: &[String]) -> Result<u8, Failure> {
        if self.seen {
            show(CLEAR);
        }
        let out = &self.args.output;
        let records: Vec<Record> = self.records().iter().flatten().cloned().collect();
        save_tables(out, keys, &records, Signals).map_err(|error| Failure::file(out, &error))?;
        for record in records.iter().filter(|record| record.status == Status::Failed) {
            stderr::line(format!("warning: {} failed: {}", record.case, record.error.as_deref().unwrap_or_default()));
        }
        if !self.args.quiet {
            let failed = failed(&records);
            let done = records.len() - failed;
            stderr::line(format!(
                "{done} of {} cases done ({} before), {failed} failed{}",
                self.cases.len(),
                self.found,
                if failed > 0 { "; --retry-failed runs them again" } else { "" }
            ));
            TABLES.iter().for_each(|name| stderr::line(format!("wrote {}", out.join(name).display())));
        }
        if interrupt::asked() {
            stderr::line("stopped; the same command goes on with the next case");
            return Ok(INTERRUPTED);
        }
        Ok(0)
    }
}

/// The record of a case that needs nothing more.
fn over(state: &State, retry_failed: bool) -> Option<Record> {
    let State::Over(record) = state else { return None };
    let again = retry_failed && record.status == Status::Failed;
    (!again).then(|| (**record).clone())
}

fn failed<'a>(records: impl IntoIterator<Item = &'a Record>) -> usize {
    records.into_iter().filter(|record| record.status == Status::Failed).count()
}

/// The text within the columns that every terminal has.
fn fit(text: &str) -> String {
    text.chars().take(79).collect()
}

/// A path relative to the folder that a file lies in.
fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}
