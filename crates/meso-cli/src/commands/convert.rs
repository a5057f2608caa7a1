//! `mesocrete convert`: a saved model in another format.

use super::names;
use crate::failure::Failure;
use crate::inputs;
use crate::outputs::{self, Target, Unit};
use crate::stderr;
use meso_core::export::vtk::Encoding;
use meso_core::formats::{Format, Surfaces};
use meso_core::packing::Images;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json); `-` is standard input
    model: PathBuf,
    /// File to write, its format by the extension: .json, .vtu, .stl, .csv; `-` is standard output. May be repeated
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    /// Format on standard output: json, vtu, stl, csv
    #[arg(long, value_name = "FORMAT", default_value = "json", value_parser = format_name)]
    format: Format,
    /// Compress the data of a .vtu (zlib)
    #[arg(long)]
    compress: bool,
    #[arg(long, default_value = "none", value_parser = names::parse::<Images>)]
    #[arg(help = format!("Aggregates that cross a face of a periodic specimen, in .vtu and .stl: {}", names::list::<Images>()))]
    images: Images,
    /// Replace files that are there already
    #[arg(short, long)]
    force: bool,
    /// Print only errors
    #[arg(short, long)]
    quiet: bool,
}

fn format_name(text: &str) -> Result<Format, String> {
    Format::from_path(&Path::new("x").with_extension(text)).ok_or_else(|| format!("it must be one of {}", known("")))
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let plan = args.output.iter().map(|path| plan(path, args)).collect::<Result<Vec<_>, _>>()?;
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.model])?;
    let model = inputs::model(&args.model)?;
    let surfaces = Surfaces { encoding: Encoding::compressed(args.compress), images: args.images };
    let mut unit = Unit::default();
    for (target, format) in &plan {
        unit.fill(target, args.force, |out| format.write(&model, surfaces, out))?;
    }
    unit.commit()?;
    if !args.quiet {
        plan.iter()
            .filter_map(|(target, _)| target.file())
            .for_each(|path| stderr::line(format!("wrote {}", path.display())));
    }
    Ok(0)
}

fn plan(path: &Path, args: &Args) -> Result<(Target, Format), Failure> {
    let format = if path == Path::new("-") { Some(args.format) } else { Format::from_path(path) };
    let format = format.ok_or_else(|| {
        let meshes = " (a mesh for finite elements: mesocrete mesh)";
        Failure::Usage(format!(
            "{}: the extension names no format; it must be one of {}{meshes}",
            path.display(),
            known(".")
        ))
    })?;
    Ok((Target::new(path, args.force)?, format))
}

fn known(dot: &str) -> String {
    Format::ALL.map(|format| format!("{dot}{}", format.extension())).join(", ")
}
