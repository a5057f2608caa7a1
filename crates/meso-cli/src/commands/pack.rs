//! `mesocrete pack`: a spec becomes a packed specimen and its files.

use super::mesh_report::MeshReport;
use super::meshing::{Meshing, wrong_deck};
use super::shared::{Threads, Writing};
use super::{mesh, names, values};
use crate::failure::{Failure, INTERRUPTED, RUN, SHORT};
use crate::outputs::{self, Target, Unit};
use crate::progress::{PACK, Watch};
use crate::{inputs, stderr};
use meso_concrete::thousands;
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::{Format, MeshFormat, SurfaceOptions};
use meso_core::images::Images;
use meso_core::mesh::Mesh;
use meso_core::packing::{Placement, Report, Seconds, StopReason, Strategy};
use meso_core::page;
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::watch::Stage;
use meso_core::{Model, Spec, SpecError, Watch as _};
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Spec to pack (TOML, see `mesocrete init`); `-` is standard input; absent: a 150 mm cube, Fuller 5 to 20 mm, 50 %
    spec: Option<PathBuf>,
    /// File to write, its format by the extension: .json, .json.gz, .vtu, .vtp, .stl, .step, .glb, .ply, .obj, .csv; a
    /// page: .html; meshes: .inp, .msh, .pvtu; `-` writes the .json to standard output. May be repeated; absent: model.json, model.vtu, model.inp, model.html
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Seed of all randomness; the same seed gives the same bytes
    #[arg(long, value_name = "N", value_parser = values::seed, allow_negative_numbers = true)]
    seed: Option<u64>,
    /// Volume of the aggregates over the specimen's, 0 to 1
    #[arg(long, value_name = "F", value_parser = values::number, allow_negative_numbers = true)]
    fraction: Option<f64>,
    #[arg(long, value_parser = names::parse::<Strategy>)]
    #[arg(help = format!("Strategy of placement: {}", names::list::<Strategy>()))]
    strategy: Option<Strategy>,
    /// Random positions tried per aggregate
    #[arg(long, value_name = "N", value_parser = values::count, allow_negative_numbers = true)]
    attempts: Option<u32>,
    /// Smallest distance between two aggregates; 0 only proves them apart. The default is 0, with `--method conforming`
    /// 0.05, and with an --analysis half an element, or less where the packing would get too dense
    #[arg(long, value_name = "MM", value_parser = values::number, allow_negative_numbers = true)]
    min_gap_mm: Option<f64>,
    /// Smallest distance between an aggregate and the specimen's surface. Periodic packings are shifted until no aggregate
    /// touches a face
    #[arg(long, value_name = "MM", value_parser = values::number, allow_negative_numbers = true)]
    wall_gap_mm: Option<f64>,
    /// Stop after S seconds with the best packing found. If generation used up the time, placement gets one more second
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    time_limit: Option<f64>,
    #[command(flatten)]
    threads: Threads,
    #[arg(long, default_value = "none", value_parser = names::parse::<Images>)]
    #[arg(help = format!("Aggregates that cross a face of a periodic specimen, where surfaces are written: {}", names::list::<Images>()))]
    images: Images,
    /// Exit with 3 when the target is not reached
    #[arg(long)]
    strict: bool,
    /// Compress the data of a .vtu or .vtp (zlib)
    #[arg(long)]
    compress: bool,
    #[command(flatten)]
    writing: Writing,
    /// Write the figures of the run as JSON; `-` is standard output
    #[arg(long, value_name = "FILE")]
    summary_json: Option<PathBuf>,
    #[command(flatten)]
    meshing: Meshing,
}

/// Content of one output.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Content {
    Packing(Format),
    Mesh(MeshFormat),
    /// Pictures and figures.
    Page,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let plan = args.plan()?;
    let stages: Vec<_> = PACK.into_iter().filter(|(stage, _)| plan.has_mesh() || *stage != Stage::Mesh).collect();
    let mut watch = Watch::of_files(args.writing.quiet, &stages);
    let spec = match args.spec(&watch) {
        Err(Failure::Late(message)) => {
            watch.finish();
            stderr::line(format!("error: {message}; nothing is written"));
            return Ok(if args.strict { SHORT } else { RUN });
        }
        spec => spec?,
    };
    let deck = args.meshing.deck(&spec)?;
    if plan.has_mesh() {
        args.meshing.check(&spec.specimen)?;
    }
    watch.aside(|| {
        args.meshing.warn_unused(plan.has_deck());
        // Before the work: a hopeless target is reported while nothing is lost.
        spec.doubts().iter().for_each(|doubt| stderr::line(format!("warning: {doubt}")));
    });
    watch.keeps_the_best();
    let model = meso_core::pack(&spec, &watch);
    watch.placed();
    let written = model.map_err(|error| args.name_flag(error)).and_then(|model| {
        let mesh = plan
            .has_mesh()
            .then(|| args.meshing.build(&model, args.writing.quiet, &watch).map(|(mesh, _)| mesh))
            .transpose();
        // A packing is not lost with its mesh.
        plan.write(&model, mesh.as_ref().ok().and_then(Option::as_ref), &deck, &watch)?;
        Ok((model, mesh))
    });
    watch.finish();
    let (model, mesh) = written?;
    if !args.writing.quiet {
        print(&model.report);
        if let Ok(Some(mesh)) = &mesh {
            MeshReport::of(mesh, &model, args.meshing.options()?, &deck).print();
            args.meshing.hint(&spec).into_iter().for_each(stderr::line);
        }
        plan.files(mesh.is_ok()).for_each(|path| stderr::line(format!("wrote {}", path.display())));
        if mesh.is_ok() {
            plan.meshes().for_each(|(target, format)| mesh::how_to_run(target, format, &deck));
        }
    }
    mesh?;
    Ok(exit_code(&model.report, args.strict))
}

impl Args {
    /// Refuses flags that no file can make right.
    pub(super) fn validate(&self) -> Result<(), Failure> {
        self.output.iter().try_for_each(|path| content(path).map(drop))?;
        if self.spec.is_some() { Ok(()) } else { self.meshing.validate(&self.spec(&Watch::of_files(true, &[]))?) }
    }

    /// The spec's file, with the changes of the flags.
    fn spec(&self, watch: &Watch) -> Result<Spec, Failure> {
        let read = |path| inputs::spec(path, watch, self.time_limit);
        let mut spec = self.spec.as_deref().map_or_else(|| Ok(Spec::default()), read)?;
        spec.seed = self.seed.unwrap_or(spec.seed);
        spec.fraction = self.fraction.unwrap_or(spec.fraction);
        spec.placement.strategy = self.strategy.unwrap_or(spec.placement.strategy);
        spec.placement.attempts = self.attempts.or(spec.placement.attempts);
        let Placement { min_gap_mm, wall_gap_mm, .. } = &mut spec.placement;
        *min_gap_mm = self.min_gap_mm.unwrap_or(*min_gap_mm);
        *wall_gap_mm = self.wall_gap_mm.unwrap_or(*wall_gap_mm);
        spec.placement.time_limit_s = self.time_limit.or(spec.placement.time_limit_s);
        spec.validate().map_err(|error| self.name_flag(error))?;
        if let Some(said) = self.meshing.leave_room(&mut spec).filter(|_| !self.writing.quiet) {
            watch.aside(|| stderr::line(said));
        }
        spec.validate().map_err(|error| self.name_flag(error))?;
        Ok(spec)
    }

    /// A wrong value from a flag is called by the flag's name.
    fn name_flag(&self, error: SpecError) -> Failure {
        let flag = match error.key.as_str() {
            "fraction" if self.fraction.is_some() => "--fraction",
            "placement.attempts" if self.attempts.is_some() => "--attempts",
            "placement.min_gap_mm" if self.min_gap_mm.is_some() => "--min-gap-mm",
            "placement.wall_gap_mm" if self.wall_gap_mm.is_some() => "--wall-gap-mm",
            "placement.time_limit_s" if self.time_limit.is_some() => "--time-limit",
            _ => return Failure::Usage(error.to_string()),
        };
        Failure::Usage(format!("{flag} {}", error.message))
    }

    /// Destinations of all outputs; refuses those that cannot be written before anything is packed.
    fn plan(&self) -> Result<Plan, Failure> {
        let default = ["model.json", "model.vtu", "model.inp", "model.html"].map(PathBuf::from);
        let paths = if self.output.is_empty() { &default[..] } else { &self.output };
        let contents = paths.iter().map(|path| content(path)).collect::<Result<Vec<_>, _>>()?;
        let target = |(path, content): (&PathBuf, &Content)| match content {
            Content::Packing(_) | Content::Page => Target::new(path, self.writing.force),
            Content::Mesh(format) => mesh::target(path, *format, self.writing.force, &self.meshing),
        };
        let targets = paths.iter().zip(&contents).map(target).collect::<Result<Vec<_>, _>>()?;
        let summary = self.summary_json.as_ref().map(|path| Target::new(path, self.writing.force)).transpose()?;
        let all: Vec<&Target> = targets.iter().chain(&summary).collect();
        outputs::distinct(&all, &self.spec.as_deref().into_iter().chain(self.meshing.inputs()).collect::<Vec<_>>())?;
        let surfaces = SurfaceOptions { compress: self.compress, images: self.images, ..SurfaceOptions::default() };
        Ok(Plan { outputs: targets.into_iter().zip(contents).collect(), summary, force: self.writing.force, surfaces })
    }
}

fn content(path: &Path) -> Result<Content, Failure> {
    if path == Path::new("-") {
        return Ok(Content::Packing(Format::Json));
    }
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html")) {
        return Ok(Content::Page);
    }
    let packing = Format::from_path(path).map(Content::Packing);
    packing.or_else(|| MeshFormat::from_path(path).map(Content::Mesh)).ok_or_else(|| {
        let meshes = MeshFormat::ALL.map(MeshFormat::extension).into_iter().filter(|name| *name != "vtu");
        let known: Vec<&str> = Format::ALL.map(Format::extension).into_iter().chain(meshes).chain(["html"]).collect();
        let known = known.join(", .");
        Failure::Usage(format!("{}: unknown format; the extension must be one of .{known}", path.display()))
    })
}

/// Destinations of all outputs.
struct Plan {
    outputs: Vec<(Target, Content)>,
    summary: Option<Target>,
    force: bool,
    surfaces: SurfaceOptions,
}

impl Plan {
    /// The files that were written, those of meshes where there is one.
    fn files(&self, has_mesh: bool) -> impl Iterator<Item = &Path> {
        let is_there = move |content: &Content| has_mesh || !matches!(content, Content::Mesh(_));
        let there = self.outputs.iter().filter(move |(_, content)| is_there(content)).map(|(target, _)| target);
        there.chain(&self.summary).filter_map(Target::file)
    }

    fn meshes(&self) -> impl Iterator<Item = (&Target, MeshFormat)> {
        self.outputs.iter().filter_map(|(target, content)| match content {
            Content::Mesh(format) => Some((target, *format)),
            Content::Packing(_) | Content::Page => None,
        })
    }

    fn has_deck(&self) -> bool {
        self.outputs.iter().any(|(_, content)| *content == Content::Mesh(MeshFormat::Inp))
    }

    fn has_mesh(&self) -> bool {
        self.outputs.iter().any(|(_, content)| matches!(content, Content::Mesh(_)))
    }

    /// Writes all files; the summary last, because it states how long the others took.
    fn write(&self, model: &Model, mesh: Option<&Mesh>, deck: &DeckOptions, watch: &Watch) -> Result<(), Failure> {
        let mut unit = Unit::default();
        let start = watch.elapsed();
        for (number, (target, content)) in self.outputs.iter().enumerate() {
            watch.stage(Stage::Write, number as f64 / self.outputs.len() as f64);
            match (content, mesh) {
                (Content::Packing(format), _) => {
                    unit.fill(target, self.force, |out| format.write(model, self.surfaces, out))?;
                }
                (Content::Mesh(format), Some(mesh)) => {
                    deck.validate(mesh).map_err(|error| wrong_deck(&error))?;
                    mesh::fill(&mut unit, target, self.force, *format, mesh, deck, self.surfaces.compress)?;
                }
                (Content::Mesh(_), None) => {}
                (Content::Page, _) => self.fill_page(&mut unit, target, model, mesh, watch)?,
            }
        }
        if let Some(target) = &self.summary {
            let total = watch.elapsed();
            let seconds = Seconds { write: total - start, total, ..model.report.seconds };
            let summary = Report { seconds, ..model.report.clone() };
            unit.fill(target, self.force, |out| {
                serde_json::to_writer_pretty(&mut *out, &summary)?;
                writeln!(out)
            })?;
        }
        unit.commit()
    }
}

impl Plan {
    /// A page of fewer samples than `report` takes: a newcomer waits for it.
    fn fill_page(
        &self,
        unit: &mut Unit,
        target: &Target,
        model: &Model,
        mesh: Option<&Mesh>,
        watch: &Watch,
    ) -> Result<(), Failure> {
        let figures = Statistics::watched(model, &StatisticsOptions::quick(), watch)
            .map_err(|error| Failure::Run(error.to_string()))?;
        unit.fill(target, self.force, |out| page::write(model, &figures, mesh, out))
    }
}

/// The result as a table.
fn print(report: &Report) {
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
    stderr::line(format!("grading: {}", report.grading));
    stderr::line("    class, mm       asked     reached  aggregates");
    for class in &report.classes {
        let limits = format!("{} - {}", class.d_min_mm, class.d_max_mm);
        let aggregates = thousands(class.aggregates);
        stderr::line(format!(
            "  {limits:>11}  {:>10.5}  {:>10.5}  {aggregates:>10}",
            class.target_fraction, class.fraction
        ));
    }
    for phase in &report.phases {
        let (name, bodies) = (phase.phase.plural(), thousands(phase.bodies));
        stderr::line(format!("  {name:>11}  {:>10.5}  {:>10.5}  {bodies:>10}", phase.target_fraction, phase.fraction));
    }
}

/// Exit code of a run that wrote its files; prints why it stopped short.
fn exit_code(report: &Report, strict: bool) -> u8 {
    if report.stop_reason == StopReason::TargetReached {
        return 0;
    }
    let why = match report.stop_reason {
        StopReason::Interrupted => " (interrupted)",
        StopReason::TimeLimit => " (the time limit came first)",
        StopReason::TargetReached | StopReason::AttemptsExhausted | StopReason::Jammed => "",
    };
    stderr::line(format!("warning: short of the target{why}: {}", report.stop_detail));
    match report.stop_reason {
        StopReason::Interrupted => INTERRUPTED,
        _ if strict => SHORT,
        _ => 0,
    }
}
