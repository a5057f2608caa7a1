//! `mesocrete solve`: the test itself, from a model, a spec or nothing to the stress-strain curve.

mod folder;
mod watch;

use super::meshing::{MeshFlags, MeshSettings, wrong_option};
use super::shared::{Threads, Writing};
use super::{names, values};
use crate::failure::{Failure, INTERRUPTED, RUN};
use crate::interrupt::Polling;
use crate::progress::{PACK, Watch};
use crate::{inputs, interrupt, room, stderr};
use folder::{CHECKPOINT, Folder, Kept, Written};
use meso_concrete::thousands;
use meso_core::aggregate::Itz as Shells;
use meso_core::mesh::{ItzForm, Mesh, MethodName, Order, Purpose};
use meso_core::watch::Stage;
use meso_core::{Model, Spec};
use meso_solve::results::{Moment, Outcome, ResultFile, Snapshot, Source, TestSeconds, sample_of};
use meso_solve::{Control, Ended, LawName, Response, Run, Smoothing, SolveError, Test, TestKind};
use meso_study::{NameError, Names};
use std::path::{Path, PathBuf};
use std::time::Instant;
use watch::Watching;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz; `-` is standard input), or what to pack (SPEC.toml); absent: a 150 mm cube, Fuller 5 to 20 mm,
    /// 40 %, gaps of 1 mm, in elements of 4 mm
    model: Option<PathBuf>,
    /// Folder of the results: curve.csv, result.json, frames.pvd with its .vtu files, result.html
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    output: PathBuf,
    #[arg(long, default_value = "compression", value_parser = names::parse::<TestKind>)]
    #[arg(help = format!("Load on the specimen, along z: {}", names::list::<TestKind>()))]
    test: TestKind,
    /// Friction between plates and specimen; in tension the plates are glued on
    #[arg(long, value_name = "MU", default_value_t = Test::default().friction, value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    friction: f64,
    /// Mean axial strain at the end [default: 0.005 in compression, 0.0005 in tension]
    #[arg(long, value_name = "E", value_parser = values::number, allow_negative_numbers = true)]
    strain: Option<f64>,
    #[arg(long, default_value_t = LawText(Test::default().law), value_parser = law)]
    #[arg(help = format!("The law of mortar and ITZ: {}", names::list::<LawName>()))]
    law: LawText,
    #[arg(long, value_name = "OVER", value_parser = names::parse::<Smoothing>)]
    #[arg(help = format!("Smooth the strains of tetrahedra, so that peaks hardly depend on their size: {} [default: edges; none for voxels]", names::list::<Smoothing>()))]
    smoothing: Option<Smoothing>,
    #[arg(long, value_name = "HOW", default_value = "servo", value_parser = names::parse::<Control>)]
    #[arg(help = format!("Plates that slow down while the specimen breaks, or keep their speed as in a deck: {}", names::list::<Control>()))]
    control: Control,
    /// Frames of all fields, evenly over the test, 0 for none; more while a servo holds the plates back
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = values::whole_number)]
    #[arg(allow_negative_numbers = true)]
    frames: u32,
    /// Time of the test at the plates' full speed, s; short ones are not quasi-static [default: by the height and the strain]
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Time step that mass scaling keeps, s [default: by the element size]
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    time_step: Option<f64>,
    /// Write checkpoint.bin every S seconds, for --resume
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    checkpoint: Option<f64>,
    /// Resume from the checkpoint.bin in DIR; give the same flags as before
    #[arg(long)]
    resume: bool,
    /// Seed of the packing, where one is made
    #[arg(long, value_name = "N", value_parser = values::seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Volume of the aggregates over the specimen's, 0 to 1, where a packing is made
    #[arg(long, value_name = "F", value_parser = values::number, allow_negative_numbers = true)]
    fraction: Option<f64>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    writing: Writing,
    #[command(flatten)]
    mesh: MeshFlags,
}

/// A law by its name, as clap shows it.
#[derive(Clone, Copy, Debug)]
struct LawText(LawName);

impl std::fmt::Display for LawText {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&names::of(&self.0))
    }
}

fn law(text: &str) -> Result<LawText, String> {
    names::parse(text).map(LawText)
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let started = Instant::now();
    let (test, materials) = (args.test(), args.mesh.materials()?);
    meso_solve::validate(&materials, &test).map_err(|error| wrong(&error))?;
    args.validate()?;
    let mut folder = Folder::open(&args.output, args.checkpoint.is_some(), args.resume, args.writing.force)?;
    let kept = if args.resume { Some(folder.kept()?) } else { None };
    let mut seconds = TestSeconds::default();
    let Some((model, settings)) = args.model(&mut seconds)? else { return Ok(INTERRUPTED) };
    let mesh = args.divide(&model, &settings, &mut seconds)?;
    let source = Source::of(&model, &settings.options);
    let sample = sample_of(&mesh, &model, &settings.options);
    drop(model);
    let begun = Instant::now();
    let mut run = Run::new(sample, &materials, &test).map_err(|error| wrong(&error))?;
    let frames = kept.map_or_else(|| Ok(Vec::new()), |kept| resume(&mut run, kept))?;
    folder.go_on(frames, !args.resume)?;
    args.announce(&run, &mesh);
    let watch = Watching::new(&mesh, folder, args.checkpoint, args.writing.quiet);
    let response = run.to_end(&Polling::begin(), &watch);
    (folder, seconds.solve) = (watch.folder(), begun.elapsed().as_secs_f64());
    finish(args, &Finished { mesh: &mesh, run: &run, response, source, started, seconds }, folder)
}

impl Args {
    fn test(&self) -> Test {
        Test {
            kind: self.test,
            friction: self.friction,
            strain: self.strain,
            duration_s: self.duration,
            time_step_s: self.time_step,
            frames: self.frames,
            control: self.control,
            law: self.law.0,
            smoothing: self.smoothing,
            ..Test::default()
        }
    }

    /// Refuses flags that do not suit packings of `spec`, before one is packed.
    pub(super) fn check(&self, spec: &Spec) -> Result<(), Failure> {
        meso_solve::validate(&self.mesh.materials()?, &self.test()).map_err(|error| wrong(&error))?;
        self.validate()?;
        self.settings(spec).map(drop)
    }

    /// Claims the name of every file of the results.
    pub(super) fn claim(owner: &str, names: &mut Names) -> Result<(), NameError> {
        let [prefix, suffix] = Moment::FILES;
        names.claim_series(owner, prefix, suffix)?;
        ResultFile::ALL
            .map(ResultFile::name)
            .into_iter()
            .chain([CHECKPOINT])
            .try_for_each(|name| names.claim(owner, name))
    }

    /// Refuses flags that no file can make right.
    pub(super) fn validate_alone(&self) -> Result<(), Failure> {
        self.validate()?;
        if self.mesh.has_materials() {
            return Ok(());
        }
        meso_solve::validate(&self.mesh.materials()?, &self.test()).map_err(|error| wrong(&error))?;
        self.mesh.options(self.purpose(), &Shells::default()).map(drop)
    }

    /// Refuses flags that cannot be meant, before any work.
    fn validate(&self) -> Result<(), Failure> {
        if self.output == Path::new("-") {
            let message = "--output - is standard output, but a test writes several files; name a folder";
            return Err(Failure::Usage(message.to_owned()));
        }
        if self.checkpoint.is_some_and(|every| !(0.0..=1e9).contains(&every)) {
            return Err(Failure::Usage("--checkpoint must be a number of seconds from 0 to 1e9".to_owned()));
        }
        let options = self.mesh.options(self.purpose(), &Shells::default())?;
        if self.smoothing == Some(Smoothing::Edges) && options.method.name() == MethodName::Voxel {
            let message = "--smoothing edges needs tetrahedra; take --method lattice or conforming, or leave it out";
            return Err(Failure::Usage(message.to_owned()));
        }
        if options.method.order() == Order::Quadratic {
            return Err(Failure::Usage("--order is 2; a test takes 1".to_owned()));
        }
        if self.packs() {
            return Ok(());
        }
        for (flag, given) in [("--seed", self.seed.is_some()), ("--fraction", self.fraction.is_some())] {
            if given {
                let message = format!("{flag} has no effect on a saved model; leave it out, or give a SPEC.toml");
                return Err(Failure::Usage(message));
            }
        }
        Ok(())
    }

    /// Whether there is no saved model yet.
    fn packs(&self) -> bool {
        self.model.as_deref().is_none_or(is_spec)
    }

    /// Use of the mesh: a user who names no specimen makes a first test.
    fn purpose(&self) -> Purpose {
        if self.model.is_none() { Purpose::FirstTest } else { Purpose::Test }
    }

    /// The mesh of a specimen, if its test would have a number of steps that can be taken.
    fn settings(&self, spec: &Spec) -> Result<MeshSettings, Failure> {
        let settings = self.mesh.settings(self.purpose(), spec)?;
        let (height_mm, options) = (spec.specimen.aabb().size().z, &settings.options);
        room::accept_in_memory("the test", options.bytes_of_test(&spec.specimen), options.element_size_mm)?;
        let steps = self.test().steps(height_mm, options.element_size_mm, options.itz == ItzForm::Cohesive);
        steps.map(|_| settings).map_err(|error| wrong(&error))
    }

    /// The specimen, and how it is meshed; none where the user stopped the packing.
    fn model(&self, seconds: &mut TestSeconds) -> Result<Option<(Model, MeshSettings)>, Failure> {
        if let Some(path) = self.model.as_deref().filter(|_| !self.packs()) {
            let mut watch = Watch::of_files(self.writing.quiet, &[(Stage::Read, 1.0)]);
            let model = inputs::model(path, &watch)?;
            watch.finish();
            let options = self.settings(&model.spec)?;
            return Ok(Some((model, options)));
        }
        let mut watch = Watch::of_files(self.writing.quiet, &PACK[..4]);
        let spec = self.spec(&watch)?;
        let options = self.settings(&spec)?;
        if !self.writing.quiet {
            let (kind, percent, gap) = (spec.specimen.kind(), 100.0 * spec.fraction, spec.placement.min_gap_mm);
            let sizes = (spec.grading.d_min_mm, spec.grading.d_max_mm);
            let line = format!(
                "packing a {kind} of {:.0} mm3: {percent} %, {} to {} mm, gaps of {gap} mm, seed {}",
                spec.specimen.volume(),
                sizes.0,
                sizes.1,
                spec.seed
            );
            watch.aside(|| stderr::line(line));
        }
        watch.keeps_the_best();
        let begun = watch.elapsed();
        let model = meso_core::pack(&spec, &watch);
        watch.finish();
        seconds.pack = watch.elapsed() - begun;
        let model = model.map_err(|error| Failure::Usage(error.to_string()))?;
        Ok((!interrupt::asked()).then_some((model, options)))
    }

    /// The spec to pack: a SPEC.toml or the paper's specimen, with the changes of the flags.
    fn spec(&self, watch: &Watch) -> Result<Spec, Failure> {
        let read = |path| inputs::spec(path, watch, None);
        let mut spec = self.model.as_deref().map_or_else(|| Ok(Spec::of_first_test()), read)?;
        spec.seed = self.seed.unwrap_or(spec.seed);
        spec.fraction = self.fraction.unwrap_or(spec.fraction);
        spec.validate().map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(spec)
    }

    fn divide(&self, model: &Model, settings: &MeshSettings, seconds: &mut TestSeconds) -> Result<Mesh, Failure> {
        let begun = Instant::now();
        if !self.writing.quiet {
            let (method, size) = (names::of(&settings.options.method.name()), settings.options.element_size_mm);
            stderr::line(format!("meshing {} aggregates: {method}, {size} mm", thousands(model.aggregates.len())));
        }
        let mut watch = Watch::of_files(self.writing.quiet, &[(Stage::Mesh, 1.0)]);
        let mesh = settings.build(model, self.writing.quiet, &watch);
        watch.finish();
        let (mesh, _) = mesh?;
        seconds.mesh = begun.elapsed().as_secs_f64();
        Ok(mesh)
    }

    fn announce(&self, run: &Run, mesh: &Mesh) {
        if self.writing.quiet {
            return;
        }
        let (elements, steps) = (thousands(mesh.cell_count()), thousands(run.steps() as usize));
        // A servo adds steps while the specimen breaks.
        let at_least = if self.control == Control::Servo { "at least " } else { "" };
        let (test, law, strain) = (names::of(&self.test), self.law, self.test().strain());
        stderr::line(format!(
            "{test} to a strain of {strain}, friction {}, law {law}: {elements} elements, {at_least}{steps} steps of {:.2e} s with {:.0} % of mass added, {:.0} MB",
            self.friction,
            run.time_step_s(),
            run.added_mass_percent(),
            run.bytes() as f64 / 1e6
        ));
    }
}

fn is_spec(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Restores the state that an earlier run kept.
fn resume(run: &mut Run, mut kept: Kept) -> Result<Vec<Written>, Failure> {
    run.resume(&mut kept.state).map_err(|error| Failure::Run(format!("{}: {error}", kept.path.display())))?;
    Ok(kept.frames)
}

/// A run that came to its end.
struct Finished<'a> {
    mesh: &'a Mesh,
    run: &'a Run<'a>,
    response: Response,
    source: Source,
    started: Instant,
    seconds: TestSeconds,
}

/// Writes the results and says the most of them; the exit code.
fn finish(args: &Args, finished: &Finished, mut folder: Folder) -> Result<u8, Failure> {
    let Finished { mesh, run, response, source, started, seconds } = finished;
    let ended = &response.result.ended;
    let keeps = *ended == Ended::Stopped && args.checkpoint.is_some();
    let kept = if keeps { folder.keep(run) } else { Ok(()) };
    // A run that diverged holds no numbers now.
    let last = (!matches!(ended, Ended::Diverged(_))).then(|| Snapshot::now(run));
    let seconds = TestSeconds { total: started.elapsed().as_secs_f64(), ..*seconds };
    let frames = folder.frames();
    let outcome = Outcome { mesh, response, source, frames: &frames, last: last.as_ref(), seconds };
    // Before a disk without room can hide them.
    tell(response, args.test().strain(), args.writing.quiet);
    folder.fill(&outcome)?;
    let lost = folder.lost();
    let written = folder.commit(*ended == Ended::Completed)?;
    if !args.writing.quiet {
        written.iter().for_each(|path| stderr::line(format!("wrote {}", path.display())));
    }
    kept?;
    match ended {
        Ended::Completed => lost.map(|()| 0),
        Ended::Stopped => Ok(INTERRUPTED),
        Ended::Diverged(_) => Ok(RUN),
    }
}

/// Prints the curve's figures, then warnings and errors.
fn tell(response: &Response, strain: f64, quiet: bool) {
    let (result, figures) = (&response.result, &response.result.figures);
    if !quiet {
        stderr::line(format!(
            "peak {:.2} MPa at a strain of {:.5}, modulus {:.0} MPa, {:.2} MPa at the end",
            figures.peak_mpa, figures.peak_strain, figures.modulus_mpa, figures.stress_at_end_mpa
        ));
        stderr::line(format!(
            "kinetic over internal energy {:.2} %, {:.2} % to half the peak; energy balance off by {:.4} % of the work, {:.1} % of mass added",
            100.0 * result.kinetic_over_internal_max,
            100.0 * result.kinetic_over_internal_to_half_peak,
            100.0 * result.energy_balance_error,
            result.added_mass_percent
        ));
    }
    result.warnings.iter().for_each(|warning| stderr::line(format!("warning: {}", with_flags(warning))));
    result.errors.iter().for_each(|error| stderr::line(format!("error: {}", with_flags(error))));
    if result.ended == Ended::Stopped {
        let share = 100.0 * response.curve.last().map_or(0.0, |row| row.strain) / strain;
        stderr::line(format!("stopped after {share:.0} % of the strain; the curve is valid until there"));
    }
}

/// Turns an error of the engine into wrong usage; a value of the test has a flag.
fn wrong(error: &SolveError) -> Failure {
    Failure::Usage(match error {
        SolveError::Value(wrong) if wrong.table == "test" => return wrong_option(wrong),
        _ => error.to_string(),
    })
}

/// The engine speaks of `test.time_step_s`, the user typed `--time-step`.
fn with_flags(text: &str) -> String {
    let flags = ["duration_s", "time_step_s", "friction", "strain", "frames"];
    flags.iter().fold(text.to_owned(), |text, key| {
        let flag = key.trim_end_matches("_s").replace('_', "-");
        text.replace(&format!("test.{key}"), &format!("--{flag}"))
    })
}
