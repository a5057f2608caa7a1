//! `mesocrete study`: every combination of some options, one folder each, and one table of all.

mod file;
mod steps;

use super::values;
use crate::failure::{Failure, INTERRUPTED};
use crate::progress::{CLEAR, bar, show};
use crate::{interrupt, stderr};
use file::StudyFile;
use meso_study::{Case, Plan, Record, State, Status, TABLES, save_tables};
use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use steps::Steps;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// What to vary (TOML): `spec`, a file or a table; `[over]`, the options to vary; `outputs`, `[mesh]` and `[solve]`, what
    /// to do with each packing; see docs/studies.md
    study: PathBuf,
    /// Folder of the study: a folder for each case, table.csv, table.parquet and ensemble.csv
    #[arg(short, long, value_name = "DIR", default_value = "study")]
    output: PathBuf,
    /// Do failed cases again; done ones are never done twice
    #[arg(long)]
    retry_failed: bool,
    /// List the cases and what is left to do, and do nothing
    #[arg(long)]
    dry_run: bool,
    /// Number of threads; all cores when absent. It changes the time, never the result
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
    let steps = plan.cases.iter().map(|case| file.steps(case, &args.output, args.threads));
    let steps = steps.collect::<Result<Vec<Steps>, _>>()?;
    let states: Vec<State> =
        plan.cases.iter().map(|case| State::of(case, "", &args.output.join(&case.folder))).collect();
    if args.dry_run {
        return list(&plan, &states);
    }
    std::fs::create_dir_all(&args.output).map_err(|error| Failure::file(&args.output, &error))?;
    let mut study = Study::new(args, plan.cases.len());
    for ((case, steps), state) in plan.cases.iter().zip(&steps).zip(states) {
        if let Some(record) = study.over(&state) {
            study.records.push(record);
            continue;
        }
        study.draw(case);
        match study.run(case, steps, &state)? {
            Some(record) => study.records.push(record),
            None => break,
        }
    }
    study.finish(&plan.keys)
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
    cases: usize,
    records: Vec<Record>,
    /// Cases that were done before.
    found: usize,
    seen: bool,
}

impl<'a> Study<'a> {
    fn new(args: &'a Args, cases: usize) -> Self {
        let seen = !args.quiet && io::stderr().is_terminal();
        Self { args, cases, records: Vec::new(), found: 0, seen }
    }

    /// The record of a case that needs nothing more.
    fn over(&mut self, state: &State) -> Option<Record> {
        let State::Over(record) = state else { return None };
        if record.status == Status::Failed && self.args.retry_failed {
            return None;
        }
        self.found += 1;
        Some((**record).clone())
    }

    /// Does a case and writes its record; none where the user stopped it.
    fn run(&self, case: &Case, steps: &Steps, state: &State) -> Result<Option<Record>, Failure> {
        let folder = self.args.output.join(&case.folder);
        let fail = |error: io::Error| Failure::file(&folder, &error);
        state.prepare(&folder).map_err(fail)?;
        let ended = steps.run(case, &folder);
        if interrupt::asked() {
            return Ok(None);
        }
        let record = Record::new(case, "", ended, &folder).map_err(fail)?;
        record.save(&folder).map_err(fail)?;
        Ok(Some(record))
    }

    fn failed(&self) -> usize {
        self.records.iter().filter(|record| record.status == Status::Failed).count()
    }

    /// The one bar of the study.
    fn draw(&self, case: &Case) {
        if self.seen {
            let (done, cases) = (self.records.len(), self.cases);
            let bar = bar(done as f64 / cases as f64);
            show(&format!(
                "{CLEAR}{}",
                fit(&format!("study {bar} {done} of {cases}, {} failed: {}", self.failed(), case.folder))
            ));
        }
    }

    /// Writes the tables and says what became of the cases; the exit code.
    fn finish(self, keys: &[String]) -> Result<u8, Failure> {
        if self.seen {
            show(CLEAR);
        }
        let out = &self.args.output;
        save_tables(out, keys, &self.records).map_err(|error| Failure::file(out, &error))?;
        for record in self.records.iter().filter(|record| record.status == Status::Failed) {
            stderr::line(format!("warning: {} failed: {}", record.case, record.error.as_deref().unwrap_or_default()));
        }
        if !self.args.quiet {
            let (done, failed) = (self.records.len() - self.failed(), self.failed());
            stderr::line(format!(
                "{done} of {} cases done ({} before), {failed} failed{}",
                self.cases,
                self.found,
                if failed > 0 { "; --retry-failed does them again" } else { "" }
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

/// The text within the columns that every terminal has.
fn fit(text: &str) -> String {
    text.chars().take(79).collect()
}

/// A path relative to the folder that a file lies in.
fn beside(file: &Path, name: &str) -> PathBuf {
    file.parent().unwrap_or(Path::new("")).join(name)
}
