//! `mesocrete mesh`: a saved model as finite elements.

use super::mesh_report::MeshReport;
use super::meshing::{Meshing, wrong_deck};
use super::shared::{Threads, Writing};
use crate::failure::{Failure, SHORT};
use crate::outputs::{self, Target, Unit};
use crate::progress::{Watch, of_model};
use crate::{inputs, stderr};
use meso_core::Spec;
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::MeshFormat;
use meso_core::mesh::{Mesh, PhaseOff};
use meso_core::watch::Stage;
use meso_study::{NameError, Names};
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    model: PathBuf,
    /// File to write, its format by the extension: .inp, .vtu, .pvtu (pieces beside it), .msh; `-` is standard output
    /// (.inp). May be repeated
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    #[command(flatten)]
    threads: Threads,
    /// Compress the data of a .vtu (zlib)
    #[arg(long)]
    compress: bool,
    /// Exit with 3 when a phase is more than 1 % off its exact volume
    #[arg(long)]
    strict: bool,
    #[command(flatten)]
    writing: Writing,
    /// Write the figures of the mesh as JSON, every bad element by its number; `-` is standard output
    #[arg(long, value_name = "FILE")]
    summary_json: Option<PathBuf>,
    #[command(flatten)]
    meshing: Meshing,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

impl Args {
    /// Refuses flags that no file can make right.
    pub(super) fn validate(&self) -> Result<(), Failure> {
        self.output.iter().try_for_each(|path| mesh_format(path).map(drop))?;
        self.meshing.options().map(drop)
    }

    /// The files that are asked for.
    pub(super) fn outputs(&self) -> &[PathBuf] {
        &self.output
    }

    /// Claims the name of every file that the mesh is written to.
    pub(super) fn claim(&self, owner: &str, names: &mut Names) -> Result<(), Failure> {
        for path in &self.output {
            let mut claim = |path: &Path| names.claim(owner, &path.file_name().unwrap_or_default().to_string_lossy());
            claim(path).map_err(wrong_name)?;
            match mesh_format(path)? {
                MeshFormat::Inp if self.meshing.has_curve() => {
                    claim(&DeckOptions::curve_path(path)).map_err(wrong_name)?;
                }
                MeshFormat::Pvtu => {
                    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
                    names.claim_series(owner, &format!("{stem}_"), ".vtu").map_err(wrong_name)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Refuses what a packing of `spec` cannot be meshed with, before it is packed.
    pub(super) fn check(&self, spec: &Spec) -> Result<(), Failure> {
        self.output.iter().try_for_each(|path| mesh_format(path).map(drop))?;
        self.meshing.deck(spec)?;
        self.meshing.check(&spec.specimen)
    }
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let plan = args.output.iter().map(|path| plan(path, args)).collect::<Result<Vec<_>, _>>()?;
    let summary = args.summary_json.as_ref().map(|path| Target::new(path, args.writing.force)).transpose()?;
    let targets: Vec<&Target> = plan.iter().map(|(target, _)| target).chain(&summary).collect();
    outputs::distinct(&targets, &args.meshing.inputs().chain([args.model.as_path()]).collect::<Vec<_>>())?;
    let writes_deck = plan.iter().any(|(_, format)| *format == MeshFormat::Inp);
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Mesh, 2.0));
    let model = inputs::model(&args.model, &watch)?;
    let deck = args.meshing.deck(&model.spec)?;
    args.meshing.check(&model.spec.specimen)?;
    watch.aside(|| args.meshing.warn_unused(writes_deck));
    let mesh = args.meshing.build(&model, args.writing.quiet, &watch);
    watch.finish();
    let (mesh, off) = mesh?;
    if writes_deck {
        deck.validate(&mesh).map_err(|error| wrong_deck(&error))?;
    }
    let mut unit = Unit::default();
    let fill_all = || {
        let mut outputs = plan.iter();
        outputs.try_for_each(|(target, format)| {
            fill(&mut unit, target, args.writing.force, *format, &mesh, &deck, args.compress)
        })
    };
    let options = args.meshing.options()?;
    let tell = || {
        let asked = !args.writing.quiet || summary.is_some();
        asked.then(|| MeshReport::of(&mesh, &model, options, &deck))
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
        args.meshing.hint(&model.spec).into_iter().for_each(stderr::line);
        targets
            .iter()
            .filter_map(|target| target.file())
            .for_each(|path| stderr::line(format!("wrote {}", path.display())));
        plan.iter().for_each(|(target, format)| how_to_run(target, *format, &deck));
    }
    Ok(if args.strict { exit_code(off) } else { 0 })
}

fn wrong_name(error: NameError) -> Failure {
    Failure::Usage(error.to_string())
}

/// Beyond this share of its exact volume `--strict` finds a phase off.
const STRICT_PHASE_ERROR: f64 = 0.01;

/// Exit code of a strict run that wrote its files; prints which phase is off.
fn exit_code(off: Option<PhaseOff>) -> u8 {
    off.filter(|off| off.error().abs() > STRICT_PHASE_ERROR).map_or(0, |off| {
        let (phase, error) = (off.phase.name(), 100.0 * off.error());
        stderr::line(format!("warning: {phase} has {error:+.1} % of its exact volume, where --strict allows 1 %"));
        SHORT
    })
}

fn plan(path: &Path, args: &Args) -> Result<(Target, MeshFormat), Failure> {
    let format = mesh_format(path)?;
    Ok((target(path, format, args.writing.force, &args.meshing)?, format))
}

/// The format that an output's extension names; standard output takes a deck.
fn mesh_format(path: &Path) -> Result<MeshFormat, Failure> {
    let format = if path == Path::new("-") { Some(MeshFormat::Inp) } else { MeshFormat::from_path(path) };
    format.ok_or_else(|| {
        let known = MeshFormat::ALL.map(|format| format!(".{}", format.extension())).join(", ");
        let message = format!("{}: unknown mesh format; the extension must be one of {known}", path.display());
        Failure::Usage(message)
    })
}

/// Destination of a mesh, inspected before any work is done.
pub(super) fn target(path: &Path, format: MeshFormat, force: bool, meshing: &Meshing) -> Result<Target, Failure> {
    if format == MeshFormat::Pvtu {
        // The number of pieces is not known yet, but an existing first one would be in the way.
        Target::new(&MeshFormat::piece_path(path, 0), force)?;
    }
    let target = Target::new(path, force)?;
    if format == MeshFormat::Inp && meshing.has_curve() && matches!(target, Target::File { .. }) {
        Target::new(&DeckOptions::curve_path(path), force)?;
    }
    Ok(target)
}

/// Says how a deck with a curve is run, and what writes its curve down.
pub(super) fn how_to_run(target: &Target, format: MeshFormat, deck: &DeckOptions) {
    if let (Target::File { shown, .. }, MeshFormat::Inp, true) = (target, format, deck.has_curve()) {
        let (input, script) = (shown.display(), DeckOptions::curve_path(shown));
        stderr::line(format!(
            "run it: abaqus job=NAME input={input} double=both cpus=16; its curve: abaqus python {} NAME.odb",
            script.display()
        ));
    }
}

/// Writes `mesh` to `target`, and its pieces beside it where the format has any.
pub(super) fn fill(
    unit: &mut Unit,
    target: &Target,
    force: bool,
    format: MeshFormat,
    mesh: &Mesh,
    deck: &DeckOptions,
    compress: bool,
) -> Result<(), Failure> {
    let path = target.file().unwrap_or(Path::new("-"));
    for file in format.files(path, mesh, deck) {
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
