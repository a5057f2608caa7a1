//! `mesocrete convert`: a saved model in another format.

use super::names;
use super::shared::{Threads, Writing};
use crate::failure::Failure;
use crate::outputs::{self, Target, Unit};
use crate::progress::Watch;
use crate::{inputs, stderr};
use meso_core::formats::{Format, SurfaceOptions};
use meso_core::images::Images;
use meso_core::watch::Stage;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    model: PathBuf,
    #[arg(short, long, value_name = "FILE", required = true)]
    #[arg(help = format!("File to write, its format by the extension: {}; `-` is standard output. May be repeated", known(".")))]
    output: Vec<PathBuf>,
    #[arg(long, value_name = "FORMAT", default_value = "json", value_parser = format_name)]
    #[arg(help = format!("Format on standard output: {}", known("")))]
    format: Format,
    /// Compress the data of a .vtu or .vtp (zlib)
    #[arg(long)]
    compress: bool,
    #[arg(long, default_value = "none", value_parser = names::parse::<Images>)]
    #[arg(help = format!("Aggregates that cross a face of a periodic specimen, where surfaces are written: {}", names::list::<Images>()))]
    images: Images,
    /// Add the mortar to a .step: a solid with a cavity per aggregate
    #[arg(long)]
    mortar: bool,
    /// Write an .stl as text, each aggregate a solid with its name
    #[arg(long)]
    named_solids: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    writing: Writing,
}

fn format_name(text: &str) -> Result<Format, String> {
    Format::from_path(&Path::new("x").with_extension(text)).ok_or_else(|| format!("it must be one of {}", known("")))
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let plan = args.output.iter().map(|path| plan(path, args)).collect::<Result<Vec<_>, _>>()?;
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.model])?;
    args.validate()?;
    let mut watch = Watch::of_files(args.writing.quiet, &[(Stage::Read, 1.0)]);
    let model = inputs::model(&args.model, &watch)?;
    watch.finish();
    let surfaces = SurfaceOptions {
        compress: args.compress,
        images: args.images,
        mortar: args.mortar,
        named_solids: args.named_solids,
    };
    let mut unit = Unit::default();
    for (target, format) in &plan {
        unit.fill(target, args.writing.force, |out| format.write(&model, surfaces, out))?;
    }
    unit.commit()?;
    if !args.writing.quiet {
        plan.iter()
            .filter_map(|(target, _)| target.file())
            .for_each(|path| stderr::line(format!("wrote {}", path.display())));
    }
    Ok(0)
}

impl Args {
    /// Refuses flags that no file can make right.
    pub(super) fn validate(&self) -> Result<(), Failure> {
        let formats = self.output.iter().map(|path| format(path, self)).collect::<Result<Vec<_>, _>>()?;
        let for_one = [(self.mortar, "--mortar", Format::Step), (self.named_solids, "--named-solids", Format::Stl)];
        match for_one.into_iter().find(|(given, _, format)| *given && !formats.contains(format)) {
            Some((_, flag, format)) => {
                let extension = format.extension();
                let message = format!("{flag} applies to .{extension} files alone; give -o a name that ends so");
                Err(Failure::Usage(message))
            }
            None => Ok(()),
        }
    }
}

fn plan(path: &Path, args: &Args) -> Result<(Target, Format), Failure> {
    Ok((Target::new(path, args.writing.force)?, format(path, args)?))
}

/// The format that an output's name asks for.
fn format(path: &Path, args: &Args) -> Result<Format, Failure> {
    let format = if path == Path::new("-") { Some(args.format) } else { Format::from_path(path) };
    format.ok_or_else(|| {
        let meshes = " (a mesh for finite elements: mesocrete mesh)";
        Failure::Usage(format!(
            "{}: unknown format; the extension must be one of {}{meshes}",
            path.display(),
            known(".")
        ))
    })
}

fn known(dot: &str) -> String {
    Format::ALL.map(|format| format!("{dot}{}", format.extension())).join(", ")
}
