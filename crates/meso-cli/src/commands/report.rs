//! `mesocrete report`: one self-contained page about a saved model.

use super::values;
use crate::failure::Failure;
use crate::outputs::{self, Target, Unit};
use crate::{inputs, say, threads};
use meso_core::page;
use meso_core::statistics::{Options, statistics};
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json); `-` is standard input
    model: PathBuf,
    /// Page to write (.html); `-` is standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Number of threads; all cores when absent
    #[arg(long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    threads: Option<u16>,
    /// Replace a file that is there already
    #[arg(short, long)]
    force: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let target = plan(&args.output, args.force)?;
    outputs::distinct(&[&target], &[&args.model])?;
    let model = inputs::model(&args.model)?;
    let figures = threads::with(args.threads, || statistics(&model, &Options::default()))?;
    let figures = figures.map_err(|error| Failure::Run(format!("{}: {error}", args.model.display())))?;
    let mut unit = Unit::default();
    unit.fill(&target, args.force, |out| page::write(&model, &figures, out))?;
    unit.commit()?;
    if let (Some(path), false) = (target.file(), args.quiet) {
        say::line(format!("wrote {}", path.display()));
    }
    Ok(0)
}

fn plan(path: &Path, force: bool) -> Result<Target, Failure> {
    let is_page = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("html"));
    if path != Path::new("-") && !is_page {
        return Err(Failure::Usage(format!("{}: a report is a page; its name must end in .html", path.display())));
    }
    Target::new(path, force)
}
