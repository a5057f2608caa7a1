//! The work of `mesocrete solve`: from a model, a spec or nothing to the stress-strain curve.

use super::flags::{Args, TestText};
use super::folder::{Folder, Kept, Note};
use super::watch::Watching;
use crate::commands::names;
use crate::failure::{Failure, INTERRUPTED, RUN};
use crate::gpu::{self, Choice};
use crate::interrupt::Polling;
use crate::progress::{PACK, Watch};
use crate::{inputs, interrupt, outputs, room, stderr};
use meso_ask::files::{self, is_toml};
use meso_ask::footing::Footing;
use meso_ask::{MeshAsk, SolveAsk, TestGiven};
use meso_concrete::{short, thousands};
use meso_core::mesh::{Mesh, Tools};
use meso_core::watch::Stage;
use meso_core::{Model, Spec};
use meso_solve::results::{Outcome, Snapshot, Source, TestSeconds};
use meso_solve::{Control, Ended, Response, Run, Test};
use std::time::Instant;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let started = Instant::now();
    let ask = args.ask()?;
    let device = gpu::find(&args.device)?;
    let mut folder = Folder::open(&args.output, args.checkpoint.is_some(), args.resume, args.writing.force)?;
    let kept = if args.resume { Some(folder.kept()?) } else { None };
    let mut seconds = TestSeconds::default();
    let Some((model, footing)) = args.model(&ask, &mut seconds)? else { return Ok(INTERRUPTED) };
    let mesh = args.divide(&ask, &model, &footing, &mut seconds)?;
    let (source, begun) = (Source::of(&model, &footing.options), Instant::now());
    let mut run = ask.begin(&mesh, &model, &footing, warn)?;
    drop(model);
    let written = kept.map_or_else(|| Ok(Note::default()), |kept| resume(&mut run, kept))?;
    folder.go_on(written, !args.resume)?;
    let test = ask.test();
    args.announce(&test, &run, &mesh);
    if let Some(device) = &device {
        gpu::attach(&mut run, device, args.writing.quiet)?;
    }
    let (response, folder) = std::thread::scope(|scope| {
        let watch = Watching::new(&mesh, folder, scope, args.checkpoint, args.writing.quiet);
        (run.to_end(&Polling::begin(), &watch), watch.folder())
    });
    seconds.solve = begun.elapsed().as_secs_f64();
    let strain = test.strain();
    finish(args, &Finished { mesh: &mesh, run: &run, response, source, strain, started, seconds }, folder)
}

impl Args {
    /// The request, with the content of the files. Refuses flags that cannot be meant, before any work.
    fn ask(&self) -> Result<SolveAsk, Failure> {
        let (base, from) = match &self.test {
            TestText::Named(kind) => (Test { kind: *kind, ..Test::default() }, TestGiven::Named),
            TestText::File(path) => (files::test(path, &inputs::text)?, TestGiven::File(path.display().to_string())),
        };
        self.accepted(self.mesh.ask()?, Some(base), from)
    }

    /// The request as far as no file is read.
    pub(crate) fn unread(&self) -> Result<SolveAsk, Failure> {
        let base = match self.test {
            TestText::Named(kind) => Some(Test { kind, ..Test::default() }),
            TestText::File(_) => None,
        };
        self.accepted(self.mesh.unread(), base, TestGiven::default())
    }

    fn accepted(&self, mesh: MeshAsk, base: Option<Test>, from: TestGiven) -> Result<SolveAsk, Failure> {
        let (on_device, is_first) = (self.device != Choice::Cpu, self.model.is_none());
        let ask = SolveAsk { mesh, base, from, given: self.given.clone(), brush: self.brush, on_device, is_first };
        ask.accept()?;
        outputs::refuse_stdout(&self.output, "a test writes several files; name a folder")?;
        match self.over.asked().next().filter(|_| !self.packs()) {
            Some(key) => Err(Failure::Usage(format!(
                "{} has no effect on a saved model; leave it out, or give a SPEC.toml",
                self.over.giver().option(key)
            ))),
            None => Ok(ask),
        }
    }

    /// Whether there is no saved model yet.
    fn packs(&self) -> bool {
        self.model.as_deref().is_none_or(is_toml)
    }

    /// The specimen, and how it is meshed; none where the user stopped the packing.
    fn model(&self, ask: &SolveAsk, seconds: &mut TestSeconds) -> Result<Option<(Model, Footing)>, Failure> {
        let gmsh = self.mesh.gmsh(self.writing.quiet);
        if let Some(path) = self.model.as_deref().filter(|_| !self.packs()) {
            let mut watch = Watch::of_files(self.writing.quiet, &[(Stage::Read, 1.0)]);
            let model = inputs::model(path, &watch)?;
            watch.finish();
            let footing = ask.settle_for(&model, &room::machine(Tools { gmsh: &gmsh, watch: &watch }))?;
            return Ok(Some((model, footing)));
        }
        let mut watch = Watch::of_files(self.writing.quiet, &PACK[..4]);
        let read = |path| inputs::spec(path, &watch, &self.over);
        let mut spec = self.model.as_deref().map_or_else(|| Ok(Spec::of_first_test()), read)?;
        self.over.settle(&mut spec, |spec| ask.leave_room(spec, &watch))?;
        let footing = ask.settle(&spec, &room::machine(Tools { gmsh: &gmsh, watch: &watch }))?;
        if !self.writing.quiet {
            let (kind, percent, gap) = (spec.specimen.kind(), short(100.0 * spec.fraction), spec.placement.min_gap_mm);
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
        watch.aside(|| spec.doubts().iter().for_each(|doubt| stderr::line(format!("warning: {doubt}"))));
        watch.keeps_the_best();
        let begun = watch.elapsed();
        let model = meso_core::pack(&spec, &watch);
        watch.finish();
        seconds.pack = watch.elapsed() - begun;
        let model = model.map_err(|error| Failure::Usage(error.to_string()))?;
        model.report.shortfall().iter().for_each(|short| stderr::line(format!("warning: {short}")));
        Ok((!interrupt::asked()).then_some((model, footing)))
    }

    fn divide(
        &self,
        ask: &SolveAsk,
        model: &Model,
        footing: &Footing,
        seconds: &mut TestSeconds,
    ) -> Result<Mesh, Failure> {
        let begun = Instant::now();
        let options = &footing.options;
        if !self.writing.quiet {
            let (method, size) = (names::of(&options.method.name()), options.element_size_mm);
            stderr::line(format!("meshing {} aggregates: {method}, {size} mm", thousands(model.aggregates.len())));
        }
        let mut watch = Watch::of_files(self.writing.quiet, &[(Stage::Mesh, 1.0)]);
        let gmsh = self.mesh.gmsh(self.writing.quiet);
        let mesh = ask.mesh.mesh(footing, model, &Tools { gmsh: &gmsh, watch: &watch });
        watch.finish();
        let (mesh, _) = mesh?;
        seconds.mesh = begun.elapsed().as_secs_f64();
        Ok(mesh)
    }

    fn announce(&self, asked: &Test, run: &Run, mesh: &Mesh) {
        if self.writing.quiet {
            return;
        }
        let (elements, steps) = (thousands(mesh.cell_count()), thousands(run.steps() as usize));
        // A servo adds steps while the specimen breaks.
        let at_least = if asked.control() != Control::Steady { "at least " } else { "" };
        let (test, law, strain) = (names::of(&asked.kind), names::of(&asked.law), asked.strain());
        let swollen = asked.expansion().map(|expansion| expansion.words());
        let loads = if asked.is_fast() {
            let what = if asked.supports.is_empty() { test } else { "supports of a file".to_owned() };
            format!("{what} in real time")
        } else if asked.has_path() {
            let after = swollen.map(|words| format!(" after an expansion of {words}")).unwrap_or_default();
            format!("{test}{after} to a strain of {strain}, friction {}", asked.friction())
        } else {
            format!("{test} of {}", swollen.unwrap_or_default())
        };
        stderr::line(format!(
            "{loads}, law {law}: {elements} elements, {at_least}{steps} steps of {:.2e} s with {:.0} % of mass added, {:.0} MB",
            run.time_step_s(),
            run.added_mass_percent(),
            run.bytes() as f64 / 1e6
        ));
        run.scatter().iter().for_each(|own| stderr::line(own.words()));
    }
}

/// Restores the state that an earlier run kept.
fn resume(run: &mut Run, mut kept: Kept) -> Result<Note, Failure> {
    run.resume(&mut kept.state).map_err(|error| Failure::Run(format!("{}: {error}", kept.path.display())))?;
    Ok(kept.written)
}

/// A run that came to its end.
struct Finished<'a> {
    mesh: &'a Mesh,
    run: &'a Run<'a>,
    response: Response,
    source: Source,
    /// At the end of the whole test.
    strain: f64,
    started: Instant,
    seconds: TestSeconds,
}

/// Writes the results and says the most of them; the exit code.
fn finish(args: &Args, finished: &Finished, mut folder: Folder) -> Result<u8, Failure> {
    let Finished { mesh, run, response, source, strain, started, seconds } = finished;
    let ended = &response.result.ended;
    let keeps = *ended == Ended::Stopped && args.checkpoint.is_some();
    let kept = if keeps { folder.keep(run) } else { Ok(()) };
    let last = Snapshot::last(run, ended);
    let seconds = TestSeconds { total: started.elapsed().as_secs_f64(), ..*seconds };
    let (frames, taken) = (folder.frames(), folder.taken());
    let outcome = Outcome { mesh, response, source, frames: &frames, taken: &taken, last: last.as_ref(), seconds };
    // Before a disk without room can hide them.
    tell(response, *strain, args.writing.quiet);
    folder.fill(&outcome)?;
    let lost = folder.lost();
    let written = folder.commit(*ended == Ended::Completed)?;
    if !args.writing.quiet {
        written.iter().for_each(|path| stderr::line(format!("wrote {}", path.display())));
    }
    // The last line.
    response.result.flagged().iter().for_each(|found| stderr::line(format!("warning: {found}")));
    kept?;
    match ended {
        Ended::Completed => lost.map(|()| if response.result.errors.is_empty() { 0 } else { RUN }),
        Ended::Stopped => Ok(INTERRUPTED),
        Ended::Diverged(_) | Ended::Failed(_) => Ok(RUN),
    }
}

fn warn(doubt: &String) {
    stderr::line(format!("warning: {doubt}"));
}

/// Prints the curve's figures, then warnings and errors.
fn tell(response: &Response, strain: f64, quiet: bool) {
    let (result, figures) = (&response.result, &response.result.figures);
    if !quiet && result.is_free() {
        stderr::line(result.headline());
    } else if !quiet {
        let modulus = format!(", modulus {:.0} MPa", figures.modulus_mpa);
        let modulus = if result.has_modulus() { modulus } else { String::new() };
        stderr::line(format!("{}{modulus}, {:.2} MPa at the end", result.headline(), figures.stress_at_end_mpa));
        stderr::line(format!(
            "kinetic over internal energy {:.2} %, {:.2} % to half the peak; energy balance off by {:.4} % of the work, {:.1} % of mass added",
            100.0 * result.kinetic_over_internal_max,
            100.0 * result.kinetic_over_internal_to_half_peak,
            100.0 * result.energy_balance_error,
            result.added_mass_percent
        ));
    }
    result.late_warnings().for_each(|doubt| warn(&doubt));
    result.errors.iter().for_each(|error| stderr::line(format!("error: {error}")));
    if result.ended == Ended::Stopped {
        let strained = response.curve.last().map_or(0.0, |row| row.strain) / strain;
        let timed = result.steps as f64 / result.steps_planned as f64;
        let (share, of) = if result.is_fast() { (timed, "time") } else { (strained, "strain") };
        stderr::line(format!("stopped after {:.0} % of the {of}; the curve is valid until there", 100.0 * share));
    }
}
