//! The work of `mesocrete pack`: a spec becomes a packed specimen and its files.

use super::flags::Args;
use crate::commands::mesh;
use crate::failure::{Failure, INTERRUPTED, RUN, SHORT};
use crate::progress::{PACK, Watch};
use crate::{inputs, room, stderr};
use meso_ask::DeckAsk;
use meso_concrete::thousands;
use meso_core::Spec;
use meso_core::mesh::Tools;
use meso_core::packing::{OwnPhaseReport, PhaseReport, Report, StopReason};
use meso_core::watch::Stage;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let ask = args.meshing.ask()?;
    let (plan, formats) = (args.plan(&ask)?, args.mesh_formats());
    ask.accept(&formats)?;
    let stages: Vec<_> = PACK.into_iter().filter(|(stage, _)| plan.has_mesh() || *stage != Stage::Mesh).collect();
    let mut watch = Watch::of_files(args.writing.quiet, &stages);
    let spec = match args.spec(&ask, &watch) {
        Err(Failure::Late(message)) => {
            watch.finish();
            stderr::line(format!("error: {message}; nothing is written"));
            return Ok(if args.strict { SHORT } else { RUN });
        }
        spec => spec?,
    };
    plan.suits(&spec.specimen)?;
    let gmsh = args.meshing.mesh.gmsh(args.writing.quiet);
    let settle = || ask.settle(&spec, &formats, &room::machine(Tools { gmsh: &gmsh, watch: &watch }));
    let mut settings = plan.has_mesh().then(settle).transpose()?;
    if settings.is_none() {
        ask.accept_for(&spec, &formats)?;
    }
    // Before the work: a hopeless target is reported while nothing is lost.
    watch.aside(|| spec.doubts().iter().for_each(|doubt| stderr::line(format!("warning: {doubt}"))));
    watch.keeps_the_best();
    let model = meso_core::pack(&spec, &watch);
    watch.placed();
    let written = model.map_err(|error| Failure::Usage(args.over.spec_error(&error))).and_then(|model| {
        let tools = Tools { gmsh: &gmsh, watch: &watch };
        let answer = settings.as_mut().map(|settings| ask.answer(settings, &model, &tools)).transpose();
        // A packing is not lost with its mesh.
        let mesh = answer.map(|answer| answer.map(|(mesh, _)| mesh));
        let deck = mesh.as_ref().ok().and_then(Option::as_ref).zip(settings.as_ref().map(|settings| &settings.deck));
        plan.write(&model, deck, &watch)?;
        Ok((model, mesh))
    });
    watch.finish();
    let (model, mesh) = written?;
    if !args.writing.quiet {
        print(&model.report, args.verbose, args.spec.is_none());
        if let (Ok(Some(mesh)), Some(settings)) = (&mesh, &settings) {
            mesh::print(settings, mesh, &model, args.verbose);
        }
        let files: Vec<String> = plan.files(mesh.is_ok()).map(|path| path.display().to_string()).collect();
        if !files.is_empty() {
            stderr::line(format!("wrote {}", files.join(", ")));
        }
        plan.next().iter().for_each(stderr::line);
        if let (Ok(_), Some(settings)) = (&mesh, &settings) {
            plan.meshes().for_each(|(target, format)| mesh::how_to_run(target, format, &settings.deck));
        }
    }
    mesh?;
    Ok(exit_code(&model.report, args.strict))
}

impl Args {
    /// The request as far as no file is read. Refuses flags that are wrong with any file.
    pub(crate) fn unread(&self) -> Result<DeckAsk, Failure> {
        let (ask, formats) = (self.meshing.unread(), self.mesh_formats());
        ask.accept(&formats)?;
        if self.spec.is_none() {
            let spec = self.spec(&ask, &Watch::of_files(true, &[]))?;
            ask.accept_for(&spec, &formats)?;
        }
        Ok(ask)
    }

    /// The spec's file, with the changes of the flags.
    fn spec(&self, ask: &DeckAsk, watch: &Watch) -> Result<Spec, Failure> {
        let read = |path| inputs::spec(path, watch, &self.over);
        let mut spec = self.spec.as_deref().map_or_else(|| Ok(Spec::default()), read)?;
        let leave_room = |spec: &mut Spec| ask.mesh.leave_room(ask.purpose(), spec, watch);
        if let Some(said) = self.over.settle(&mut spec, leave_room)?.filter(|_| !self.writing.quiet) {
            watch.aside(|| stderr::line(said));
        }
        Ok(spec)
    }
}

/// The result in lines; every size class where `verbose`, else the one that is furthest off. The default specimen says
/// which sizes it has.
fn print(report: &Report, verbose: bool, is_default: bool) {
    // A raw curve places less than the target; a mix design's has many decimals.
    let asked: f64 = report.classes.iter().map(|class| class.target_fraction).sum();
    stderr::line(format!(
        "packed {} aggregates in {:.2} s: fraction {:.5} of {} asked ({}, seed {})",
        thousands(report.aggregates),
        report.seconds.take + report.seconds.place,
        report.fraction,
        (asked * 1e5).round() / 1e5,
        report.strategy,
        report.seed
    ));
    let sizes = if is_default { "; sizes are longest axes, size = \"sieve\" in a spec takes openings" } else { "" };
    let grading = format!("grading: {}{sizes}", report.grading);
    if verbose {
        table(report, &grading);
    } else {
        let off = report.worst_class().map_or(String::new(), |off| format!("; worst class {:+.2} %", 100.0 * off));
        stderr::line(format!("{grading}{off}"));
        let phase = |p: &PhaseReport| format!("{} {:.5} of {} asked", p.phase.plural(), p.fraction, p.target_fraction);
        report.phases.iter().for_each(|p| stderr::line(phase(p)));
        let own = |p: &OwnPhaseReport| format!("{} {:.5} of {:.5} asked", p.phase, p.fraction, p.target_fraction);
        report.own_phases.iter().for_each(|p| stderr::line(own(p)));
        report.shells.iter().for_each(|p| stderr::line(format!("shells of {} {:.5}", p.phase, p.fraction)));
        report.coated_fraction.iter().for_each(|all| stderr::line(format!("stones with coatings and ITZ {all:.5}")));
    }
    report.remarks().iter().for_each(stderr::line);
}

/// Every size class and further phase as a row.
fn table(report: &Report, grading: &str) {
    stderr::line(grading);
    stderr::line("    class, mm       asked     reached  aggregates");
    for class in &report.classes {
        let limits = format!("{} - {}", class.d_min_mm, class.d_max_mm);
        row(&limits, class.target_fraction, class.fraction, class.aggregates);
    }
    for phase in &report.phases {
        row(phase.phase.plural(), phase.target_fraction, phase.fraction, phase.bodies);
    }
    for own in &report.own_phases {
        row(&own.phase, own.target_fraction, own.fraction, own.aggregates);
    }
}

fn row(name: &str, asked: f64, reached: f64, bodies: usize) {
    stderr::line(format!("  {name:>11}  {asked:>10.5}  {reached:>10.5}  {:>10}", thousands(bodies)));
}

/// Exit code of a run that wrote its files; prints why its fraction is not the one asked for.
fn exit_code(report: &Report, strict: bool) -> u8 {
    report.shortfall().iter().for_each(|off| stderr::line(format!("warning: {off}")));
    match report.stop_reason {
        StopReason::Interrupted => INTERRUPTED,
        _ if strict && report.is_short() => SHORT,
        _ => 0,
    }
}
