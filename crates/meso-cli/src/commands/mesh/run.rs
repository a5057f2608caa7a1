//! The work of `mesocrete mesh`: a saved model becomes finite elements.

use super::flags::Args;
use super::report::MeshReport;
use crate::failure::{Failure, SHORT};
use crate::formats::Named;
use crate::outputs::{self, Target, Unit};
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_ask::{DeckAsk, DeckSettled, Giver, strict_doubt};
use meso_core::Model;
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::{MeshFormat, SurfaceOptions};
use meso_core::mesh::{Mesh, PhaseOff, Tools};
use meso_core::watch::Stage;
use meso_files::whole::beginning;
use std::io::Write;
use std::path::Path;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let (ask, formats) = (args.meshing.ask()?, args.formats());
    let target = |output: &Named<_>| Ok((target(output, args.writing.force, &ask)?, output.format));
    let plan = args.output.iter().map(target).collect::<Result<Vec<_>, Failure>>()?;
    ask.accept(&formats)?;
    let surfaces = SurfaceOptions { compress: args.compress, ..SurfaceOptions::default() };
    surfaces.accept(&[], &formats).map_err(|error| Failure::Usage(ask.given.refusal(&error)))?;
    let summary = args.summary_json.as_ref().map(|path| Target::new(path, args.writing.force)).transpose()?;
    let targets: Vec<&Target> = plan.iter().map(|(target, _)| target).chain(&summary).collect();
    outputs::distinct(&targets, &args.meshing.inputs().chain([args.model.as_path()]).collect::<Vec<_>>())?;
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Mesh, 2.0));
    let model = inputs::model(&args.model, &watch)?;
    let gmsh = args.meshing.mesh.gmsh(args.writing.quiet);
    let machine = room::machine(Tools { gmsh: &gmsh, watch: &watch });
    let mut settings = ask.settle_for(&model, &formats, &machine)?;
    let answer = ask.answer(&mut settings, &model, &machine.tools);
    watch.finish();
    let (mesh, off) = answer?;
    let deck = &settings.deck;
    let mut unit = Unit::default();
    let fill_all = || {
        let mut outputs = plan.iter();
        outputs.try_for_each(|(target, format)| {
            fill(&mut unit, target, args.writing.force, *format, &mesh, deck, args.compress)
        })
    };
    let tell = || {
        let asked = !args.writing.quiet || summary.is_some();
        asked.then(|| MeshReport::of(&mesh, &model, &settings))
    };
    // The disk is waited for, and the figures are counted meanwhile.
    let (filled, told) = rayon::join(fill_all, tell);
    filled?;
    if let (Some(target), Some(told)) = (&summary, &told) {
        unit.fill(target, args.writing.force, |out| told.write(out))?;
    }
    unit.commit()?;
    if let (Some(told), false) = (told, args.writing.quiet) {
        told.print();
        settings.hint.iter().for_each(stderr::line);
        outputs::wrote(targets.iter().copied());
        plan.iter().for_each(|(target, format)| how_to_run(target, *format, deck));
    }
    Ok(if args.strict { exit_code(off, &mesh) } else { 0 })
}

impl Args {
    /// The request as far as no file is read.
    pub(crate) fn unread(&self) -> Result<DeckAsk, Failure> {
        let ask = self.meshing.unread();
        ask.accept(&self.formats())?;
        Ok(ask)
    }

    fn formats(&self) -> Vec<MeshFormat> {
        self.output.iter().map(|output| output.format).collect()
    }
}

/// Destination of a mesh, inspected before any work is done.
pub(crate) fn target(output: &Named<MeshFormat>, force: bool, ask: &DeckAsk) -> Result<Target, Failure> {
    let Named { path, format } = output;
    if *format == MeshFormat::Pvtu {
        // The number of pieces is not known yet, but an existing first one would be in the way.
        Target::new(&MeshFormat::piece_path(path, 0), force)?;
    }
    let target = Target::new(path, force)?;
    if ask.has_script(*format) && matches!(target, Target::File { .. }) {
        if let Some(why) = format.foreign_script(path, &beginning) {
            return Err(Failure::Run(why));
        }
        Target::new(&DeckOptions::curve_path(path), force)?;
    } else if let (Some(left), false) = (format.leftovers(path, &[], &beginning).first(), force) {
        return Err(Failure::Run(Giver::Flags.is_left(left, path.display())));
    }
    Ok(target)
}

/// Exit code of a strict run that wrote its files; prints which phase is off.
fn exit_code(off: Option<PhaseOff>, mesh: &Mesh) -> u8 {
    strict_doubt(off, mesh, Giver::Flags).map_or(0, |doubt| {
        stderr::line(format!("warning: {doubt}"));
        SHORT
    })
}

/// Prints the figures of a mesh, and how to get the ITZ that it has not.
pub(crate) fn print(settled: &DeckSettled, mesh: &Mesh, model: &Model, verbose: bool) {
    let report = MeshReport::of(mesh, model, settled);
    if verbose {
        report.print();
    } else {
        report.brief();
    }
    settled.hint.iter().for_each(stderr::line);
}

/// Prints the commands that run a deck with a curve and write the curve.
pub(crate) fn how_to_run(target: &Target, format: MeshFormat, deck: &DeckOptions) {
    if let (Target::File { shown, .. }, MeshFormat::K, true) = (target, format, deck.has_curve()) {
        let curve = match format.has_script(deck) {
            true => format!("; its curve: python {} \"binout*\"", in_shell(&DeckOptions::curve_path(shown))),
            false => String::new(),
        };
        stderr::line(format!("run it: lsdyna i={} ncpu=16 (double precision){curve}", in_shell(shown)));
    }
    if let (Target::File { shown, .. }, MeshFormat::Inp, true) = (target, format, deck.has_curve()) {
        let (input, script) = (in_shell(shown), in_shell(&DeckOptions::curve_path(shown)));
        stderr::line(format!(
            "run it: abaqus job=NAME input={input} double=both cpus=16; its curve: abaqus python {script} NAME.odb"
        ));
    }
}

/// A path as a shell takes it.
fn in_shell(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = text.chars().all(|c| c.is_alphanumeric() || "._-/\\:+=,@".contains(c));
    if is_plain { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// Writes `mesh` to `target`, and its pieces beside it where the format has any.
pub(crate) fn fill(
    unit: &mut Unit,
    target: &Target,
    force: bool,
    format: MeshFormat,
    mesh: &Mesh,
    deck: &DeckOptions,
    compress: bool,
) -> Result<(), Failure> {
    let path = target.file().unwrap_or(Path::new("-"));
    let files = format.files(path, mesh, deck);
    if let (Target::File { .. }, true) = (target, force) {
        for left in format.leftovers(path, &files, &beginning) {
            stderr::line(format!("{} is of the earlier {}, and goes with it", left.display(), path.display()));
            unit.remove(left);
        }
    }
    for file in files {
        let write = |out: &mut dyn Write| file.write(mesh, deck, compress, out);
        match file.path == path {
            true => unit.fill(target, force, write)?,
            // Nothing lies beside a stream.
            false if !matches!(target, Target::File { .. }) && format == MeshFormat::Inp => {}
            false => unit.fill(&Target::new(&file.path, force)?, force, write)?,
        }
    }
    Ok(())
}
