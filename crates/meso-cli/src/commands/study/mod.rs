//! `mesocrete study`: every combination of some options, one folder each, and one table of all.

mod slurm;

use super::shared::share;
use super::values;
use crate::failure::{Failure, INTERRUPTED, RUN};
use crate::outputs::Signals;
use crate::progress::{CLEAR, Watch, bar, show};
use crate::stderr::flag;
use crate::{Python, gpu, inputs, interrupt, outputs, room, stderr, threads};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use meso_ask::{AskError, Giver, Machine, Over};
use meso_concrete::thousands;
use meso_core::mesh::Tools;
use meso_gmsh::Gmsh;
use meso_study::{
    Again, Case, CaseOutcome, Doing, Heard, Plan, RunError, Share, Status, Steps, StudyFile, StudyLayout, StudyRun,
    TABLES, Tally,
};
use serde_json::{Map, json};
use std::io::{self, IsTerminal};
use std::num::NonZero;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once, PoisonError};
use std::time::{Duration, Instant};

/// How often a line without a terminal says how far the planning is and which case starts, and how often a terminal is
/// redrawn.
const LINE: Duration = Duration::from_secs(5);
const CASE_LINE: Duration = Duration::from_secs(60);
const REDRAW: Duration = Duration::from_millis(200);

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Study (TOML): `spec`, a file or a table; `[over]`, the options to vary; `outputs`, `[mesh]`, `[solve]` and
    /// `[effective]`, the work on each packing; see docs/studies.md
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
    /// Run part K of N, every N-th case from the K-th on, e.g. in a task of a Slurm array; --collect writes the tables
    #[arg(long, value_name = "K/N", value_parser = share, conflicts_with_all = ["case", "collect", "slurm", "dry_run"])]
    shard: Option<Share>,
    /// Run the case number K of --dry-run, from 1 on
    #[arg(long, value_name = "K", value_parser = values::count, conflicts_with_all = ["collect", "slurm", "dry_run"])]
    case: Option<u32>,
    /// Run no case; write the tables of all that are over, and report the others
    #[arg(long, conflicts_with_all = ["slurm", "dry_run", "force", "retry_failed"])]
    collect: bool,
    /// Print the script of a Slurm array of N tasks, and run no case
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "40",
          value_parser = values::count, conflicts_with_all = ["dry_run", "force"])]
    slurm: Option<u32>,
    /// Run the cases on the workers of a dask scheduler, e.g. tcp://10.0.0.1:8786; they must see the folder, too
    #[arg(long, value_name = "ADDRESS", conflicts_with_all = ["shard", "case", "collect", "slurm", "dry_run", "force", "jobs",
          "min_gap_mm", "time_limit", "gmsh"])]
    dask: Option<String>,
    /// Way to keep cases: a folder each, or one file with the records of all and no other file; absent: as the folder has them
    #[arg(long, value_name = "LAYOUT", value_parser = layout(), conflicts_with_all = ["collect", "dry_run"])]
    layout: Option<StudyLayout>,
    /// Number of cases that run at the same time. It changes the time, never the result
    #[arg(short, long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    jobs: Option<u16>,
    /// Number of threads of a case; when absent the cores are shared among the cases at the same time
    #[arg(long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Smallest distance between two aggregates, in every packing [default: the spec's; where it has none, as much as [mesh] and [solve] need]
    #[arg(long, value_name = "MM", value_parser = values::number, allow_negative_numbers = true)]
    min_gap_mm: Option<f64>,
    /// End every packing after S seconds with the best found; the results then depend on the machine
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    time_limit: Option<f64>,
    /// The program gmsh, for [mesh] and [solve] with method = "conforming"; a study's file names no program
    #[arg(long, value_name = "PROGRAM")]
    gmsh: Option<PathBuf>,
    /// Print only warnings and errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(args: &Args, python: Option<&Python<'_>>) -> Result<u8, Failure> {
    outputs::refuse_stdout(&args.output, "a study writes many files; name a folder")?;
    let on_dask = args.dask.as_deref().map(|address| args.on_dask(address, python)).transpose()?;
    Over { min_gap_mm: args.min_gap_mm, time_limit_s: args.time_limit, ..Over::default() }.accept(Giver::Flags)?;
    let mut file = StudyFile::read(&args.study, &inputs::text)?;
    file.place(&[("min_gap_mm", args.min_gap_mm), ("time_limit_s", args.time_limit)]);
    let shown = Shown::new(args.quiet);
    let gmsh = args.gmsh.as_deref().unwrap_or(Path::new("gmsh"));
    let how = Working::new(args.jobs, args.threads, gmsh, args.again());
    let plan = checked_plan(&file, &how, &shown)?;
    if let Some(on_dask) = on_dask {
        return on_dask();
    }
    if args.dry_run {
        return list(plan, args);
    }
    let share = args.share(plan.cases.len())?;
    if let Some(tasks) = args.slurm {
        return slurm::print(tasks, &plan, &file, &how.gmsh, args);
    }
    if args.collect && !args.output.is_dir() {
        let (folder, collect) = (args.output.display(), flag("collect"));
        return Err(Failure::Run(format!(
            "{folder} is not there; {collect} takes the folder of a study that has begun"
        )));
    }
    let study = match args.collect {
        true => StudyRun::look(Arc::clone(&plan), "", &args.output),
        false => StudyRun::open(Arc::clone(&plan), "", &args.output, how.again, share, args.layout),
    };
    let study = study.map_err(failure)?;
    if !args.collect {
        drive(&study, &plan, &|case| file.steps(case, &inputs::text), &how, &shown)?;
    }
    finish(&study, args)
}

/// Reads a layout.
fn layout() -> impl TypedValueParser<Value = StudyLayout> {
    let read = |name: String| StudyLayout::named(&name).unwrap_or(StudyLayout::Folders);
    PossibleValuesParser::new(StudyLayout::ALL.map(StudyLayout::name)).map(read)
}

/// Does the cases that are left of a plan that another command made; `steps` are those of a case.
pub(crate) fn cases(
    plan: Plan,
    out: &Path,
    steps: &StepsOf<'_>,
    how: &Working,
    quiet: bool,
) -> Result<StudyRun, Failure> {
    let plan = Arc::new(plan);
    let study = StudyRun::open(Arc::clone(&plan), "", out, how.again, Share::ALL, None).map_err(failure)?;
    drive(&study, &plan, steps, how, &Shown::new(quiet))?;
    Ok(study)
}

/// Finds the steps of a case.
pub(crate) type StepsOf<'a> = dyn Fn(&Case) -> Result<Steps, AskError> + Sync + 'a;

/// How cases are worked on.
pub(crate) struct Working {
    jobs: Option<u16>,
    threads: Option<u16>,
    gmsh: Gmsh,
    again: Again,
}

impl Working {
    /// Cases at the same time, and threads of one.
    pub(crate) fn new(jobs: Option<u16>, threads: Option<u16>, gmsh: &Path, again: Again) -> Self {
        Self { jobs, threads: shared_threads(jobs, threads), gmsh: Gmsh::program(gmsh), again }
    }

    /// This machine, which [`settle`] asks.
    pub(crate) fn machine(&self) -> Machine<'_> {
        room::machine(Tools { gmsh: &self.gmsh, ..Tools::default() })
    }

    /// Does a case: its results or the error that is kept, and its warnings. An interrupted case has none of them: see
    /// [`interrupt::asked`].
    ///
    /// # Errors
    /// A full disk, for which no case is to blame.
    fn run(&self, case: &Case, steps: &Steps, folder: &Path) -> Result<CaseOutcome, AskError> {
        let warnings = Mutex::new(Vec::new());
        let tell = |word: &str, text: &str| {
            stderr::line(format!("{word}: {}: {text}", case.folder));
            if word == "warning" {
                warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
            }
        };
        let all = || {
            let watch = Watch::start(true, &[]);
            let doing = Doing { watch: &watch, keeper: Signals, gmsh: &self.gmsh, devices: &gpu::device, tell: &tell };
            let model = steps.pack(&case.spec, &watch)?;
            if interrupt::asked() { Ok(Map::new()) } else { steps.run(&model, folder, &doing) }
        };
        let ended = threads::with(self.threads, || {
            catch_unwind(AssertUnwindSafe(all)).unwrap_or_else(|_| Err(Failure::Bug.into()))
        });
        let results = match ended.unwrap_or_else(|failure| Err(failure.into())) {
            Err(full @ AskError::Full(_)) => return Err(full),
            results => results.map_err(|fault| fault.message().to_owned()),
        };
        Ok(CaseOutcome { results, warnings: warnings.into_inner().unwrap_or_else(PoisonError::into_inner) })
    }
}

/// Refuses a case whose options its specimen cannot have.
pub(crate) fn settle(case: &Case, steps: &Steps, machine: &Machine<'_>) -> Result<(), AskError> {
    steps.accept(&case.spec, machine, &gpu::device)
}

/// The plan. An invalid option of any case is named before the work, while nothing is lost.
fn checked_plan(file: &StudyFile, how: &Working, shown: &Shown) -> Result<Arc<Plan>, Failure> {
    let plan = Arc::new(file.plan(&mut |planned, cases| shown.count("planning", planned, cases))?);
    let machine = how.machine();
    for (number, case) in plan.cases.iter().enumerate() {
        shown.count("checking options", number, plan.cases.len());
        let steps = file.steps(case, &inputs::text)?;
        settle(case, &steps, &machine).map_err(|fault| file.wrong(&fault))?;
    }
    shown.clear();
    Ok(plan)
}

/// Does the cases that are left.
fn drive(study: &StudyRun, plan: &Plan, steps: &StepsOf<'_>, how: &Working, shown: &Shown) -> Result<(), Failure> {
    if !study.is_exclusive() {
        let (folder, shards) = (study.out().display(), Giver::Flags.choice("shard", "K/N"));
        stderr::line(format!("warning: the disk of {folder} has no locks: start one process, or shards of {shards}"));
    }
    let work = |number: usize| {
        let case = &plan.cases[number];
        let outcome = match steps(case) {
            Ok(steps) => how.run(case, &steps, &study.out().join(&case.folder))?,
            Err(fault) => Err(fault.message().to_owned()).into(),
        };
        Ok((!interrupt::asked()).then_some(outcome))
    };
    let hears = |heard: Heard| shown.heard(study.tally(), plan, heard);
    let is_over = AtomicBool::new(false);
    let ended = std::thread::scope(|scope| {
        let ticking = scope.spawn(|| shown.tick(study, &is_over));
        let ended = study.drive(how.jobs.unwrap_or(1), Signals, &hears, &work);
        is_over.store(true, Ordering::Relaxed);
        ticking.thread().unpark();
        ended
    });
    shown.clear();
    ended.map_err(failure)
}

/// Threads of a case: cases at the same time share the cores.
fn shared_threads(jobs: Option<u16>, threads: Option<u16>) -> Option<u16> {
    let shared = |jobs: u16| {
        let cores = std::thread::available_parallelism().map_or(1, NonZero::get);
        (cores / usize::from(jobs)).max(1) as u16
    };
    threads.or_else(|| jobs.filter(|jobs| *jobs > 1).map(shared))
}

/// Reads the text of a study that names no other file, and plans it: the files of every case, as the study names them. It
/// opens no file and runs no program.
pub(crate) fn unread(text: &str) -> Result<Vec<Vec<PathBuf>>, Failure> {
    let Some(file) = StudyFile::alone(text)? else { return Ok(Vec::new()) };
    let plan = file.plan_alone()?;
    let files = |case| Ok(file.steps(case, &inputs::text)?.files().map(PathBuf::from).collect());
    plan.cases.iter().map(files).collect()
}

impl Args {
    /// Refuses a study of standard input with a `flag` whose processes read it again.
    fn named_file(&self, key: &str) -> Result<(), Failure> {
        if self.study != Path::new("-") {
            return Ok(());
        }
        Err(Failure::Usage(format!("{} takes the study of a file, which is read again; name the file", flag(key))))
    }

    /// What runs the cases on the workers of a dask scheduler.
    fn on_dask<'a>(
        &'a self,
        address: &'a str,
        python: Option<&'a Python<'_>>,
    ) -> Result<impl FnOnce() -> Result<u8, Failure> + 'a, Failure> {
        let (study, out) = (&self.study, &self.output);
        let python = python.ok_or_else(|| {
            let line = format!("mc.study({study:?}, out={out:?}, executor=Client({address:?}))");
            let install = "pip install mesocrete \"dask[distributed]\", and run its mesocrete";
            let dask = flag("dask");
            Failure::Usage(format!("{dask} is done by the Python package: {install}, or in Python {line}"))
        })?;
        self.named_file("dask")?;
        let layout = self.layout.map(StudyLayout::name);
        let request = json!({
            "study": study, "dask": address, "out": out, "layout": layout, "threads": self.threads,
            "retry_failed": self.retry_failed, "progress": !self.quiet,
        });
        Ok(move || python("study", &request.to_string()).map_err(Failure::Run))
    }

    /// The cases of this process.
    fn share(&self, cases: usize) -> Result<Share, Failure> {
        match self.case {
            None => Ok(self.shard.unwrap_or(Share::ALL)),
            Some(number) if (1..=cases).contains(&(number as usize)) => Ok(Share { shard: number as usize, of: cases }),
            Some(number) => {
                Err(Failure::Usage(format!("{} is {number}; it must lie within 1 and {cases}", flag("case"))))
            }
        }
    }

    fn again(&self) -> Again {
        match (self.force, self.retry_failed) {
            (true, _) => Again::All,
            (false, true) => Again::Failed,
            (false, false) => Again::None,
        }
    }
}

pub(crate) fn failure(error: RunError) -> Failure {
    Failure::Run(error.to_string())
}

/// Prints each case's folder and whether it is done, failed or open.
fn list(plan: Arc<Plan>, args: &Args) -> Result<u8, Failure> {
    let begun = args.output.is_dir().then(|| StudyRun::look(Arc::clone(&plan), "", &args.output));
    let begun = begun.transpose().map_err(failure)?;
    outputs::Unit::default().fill(&outputs::Target::Stdout, false, |out| {
        plan.cases.iter().enumerate().try_for_each(|(number, case)| {
            let word = match begun.as_ref().and_then(|begun| begun.status(number)) {
                Some(Status::Failed) if !args.force => "failed",
                Some(Status::Done) if !args.force => "done",
                _ => "open",
            };
            writeln!(out, "{word:6}  {}", case.folder)
        })
    })?;
    Ok(0)
}

/// Writes the tables, unless the cases are a part of the study; reports the cases that failed, and returns the exit code.
fn finish(study: &StudyRun, args: &Args) -> Result<u8, Failure> {
    let is_whole = args.shard.is_none() && args.case.is_none();
    let tally = study.tally();
    // The tables of another study, or of one with a function of Python, are not replaced by empty ones.
    let is_whole = is_whole && (!args.collect || tally.over() > 0);
    if is_whole {
        study.save_tables(Signals).map_err(failure)?;
    }
    for record in study.records().iter().filter(|record| record.status == Status::Failed) {
        stderr::line(format!("warning: {} failed: {}", record.case, record.error.as_deref().unwrap_or_default()));
    }
    let Tally { cases, before, done, failed, .. } = tally;
    let left = cases - tally.over();
    if !args.quiet {
        let again = format!("; {} runs them again", flag("retry_failed"));
        let hint = if failed > 0 { &*again } else { "" };
        stderr::line(format!("{done} of {cases} cases done ({before} before), {failed} failed{hint}"));
        if is_whole {
            TABLES.iter().for_each(|name| stderr::line(format!("wrote {}", study.out().join(name).display())));
        }
    }
    if args.collect && left > 0 {
        let collect = flag("collect");
        stderr::line(format!("warning: {left} cases are left; the command without {collect} does them"));
    }
    if interrupt::asked() {
        stderr::line("stopped; the same command goes on with the next case");
        return Ok(INTERRUPTED);
    }
    Ok(if failed > 0 || args.collect && left > 0 { RUN } else { 0 })
}

/// The progress of a study, as the user sees it: a bar on a terminal, now and then a line elsewhere.
struct Shown {
    quiet: bool,
    is_terminal: bool,
    begun: Instant,
    last: Mutex<Instant>,
    first: Once,
}

impl Shown {
    fn new(quiet: bool) -> Self {
        let begun = Instant::now();
        let is_terminal = io::stderr().is_terminal();
        Self { quiet, is_terminal, begun, last: Mutex::new(begun), first: Once::new() }
    }

    /// How much of the work before the first case is done.
    fn count(&self, work: &str, done: usize, cases: usize) {
        let every = if self.is_terminal { REDRAW } else { LINE };
        let Ok(mut last) = self.last.try_lock() else { return };
        if self.quiet || last.elapsed() < every {
            return;
        }
        *last = Instant::now();
        let text = format!("{work}: {} of {} cases", thousands(done), thousands(cases));
        if self.is_terminal { show(&format!("{CLEAR}{text}")) } else { stderr::line(text) }
    }

    /// A case begins, or the run waits for one.
    fn heard(&self, tally: Tally, plan: &Plan, heard: Heard) {
        if self.quiet {
            return;
        }
        if self.is_terminal {
            let bar = bar(tally.over() as f64 / tally.cases as f64);
            show(&format!("{CLEAR}{}", fit(&format!("{} {bar}", self.state(tally)))));
            return;
        }
        self.first.call_once(|| stderr::line(format!("study of {} cases, {} done before", tally.cases, tally.before)));
        let Heard::Waits(number) = heard else { return };
        let Ok(mut last) = self.last.try_lock() else { return };
        if last.elapsed() >= CASE_LINE {
            *last = Instant::now();
            stderr::line(format!("waiting for another process: {}", plan.cases[number].folder));
        }
    }

    /// A line a minute where nobody sees a bar, however long a case takes.
    fn tick(&self, study: &StudyRun, is_over: &AtomicBool) {
        while !self.quiet && !self.is_terminal && !is_over.load(Ordering::Relaxed) {
            let begun = Instant::now();
            std::thread::park_timeout(CASE_LINE);
            if begun.elapsed() >= CASE_LINE {
                stderr::line(self.state(study.tally()));
            }
        }
    }

    /// Numbers of the cases, rate and remaining time.
    fn state(&self, tally: Tally) -> String {
        let (over, cases) = (tally.over(), tally.cases);
        let pace = self.pace(over - tally.before, cases - over);
        format!("{over} of {cases} cases over, {} failed, {} running{pace}", tally.failed, tally.running)
    }

    /// Rate and remaining time, once a case is over.
    fn pace(&self, over: usize, left: usize) -> String {
        let seconds = self.begun.elapsed().as_secs_f64();
        if over == 0 {
            return String::new();
        }
        let (rate, rest) = (over as f64 / seconds, left as f64 * seconds / over as f64);
        format!(", {:.3} a minute, {:.0} min left", 60.0 * rate, rest / 60.0)
    }

    fn clear(&self) {
        if !self.quiet && self.is_terminal {
            show(CLEAR);
        }
    }
}

/// The text within the columns that every terminal has.
fn fit(text: &str) -> String {
    text.chars().take(79).collect()
}
