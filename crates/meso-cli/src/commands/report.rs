//! `mesocrete report`: a saved model in pictures and figures, as one self-contained page or as JSON.

use super::shared::{Threads, Writing};
use crate::failure::Failure;
use crate::formats::{Formats, Named};
use crate::inputs;
use crate::outputs::{self, Target, Unit};
use crate::progress::{Watch, of_model};
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::watch::Stage;
use meso_core::{methods, page};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    model: PathBuf,
    /// Page to write (.html), or the statistics alone (.json); `-` writes the page to standard output
    #[arg(short, long, value_name = "FILE", required_unless_present = "cite", value_parser = Named::<Content>::parser())]
    output: Option<Named<Content>>,
    /// Print a paragraph for the methods section of a paper, with the figures of this model and what to cite
    #[arg(long, conflicts_with = "output")]
    cite: bool,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    writing: Writing,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    match &args.output {
        Some(output) => write(args, output),
        None => cite(args),
    }
}

fn cite(args: &Args) -> Result<u8, Failure> {
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Measure, 0.0));
    let model = inputs::model(&args.model, &watch)?;
    watch.finish();
    Unit::default().fill(&Target::Stdout, false, |out| writeln!(out, "{}", methods::paragraph(&model, &[])))?;
    Ok(0)
}

fn write(args: &Args, Named { path, format: content }: &Named<Content>) -> Result<u8, Failure> {
    let target = Target::new(path, args.writing.force)?;
    outputs::distinct(&[&target], &[&args.model])?;
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Measure, 5.0));
    let model = inputs::model(&args.model, &watch)?;
    let figures = args.threads.run(|| Statistics::watched(&model, &StatisticsOptions::default(), &watch))?;
    watch.finish();
    let figures = figures.map_err(|error| Failure::Run(format!("{}: {error}", args.model.display())))?;
    let mut unit = Unit::default();
    unit.fill(&target, args.writing.force, |out| match content {
        Content::Page => page::write(&model, &figures, None, out),
        Content::Figures => write_figures(&figures, out),
    })?;
    unit.commit()?;
    if !args.writing.quiet {
        outputs::wrote([&target]);
    }
    Ok(0)
}

/// Content that the output's name asks for.
#[derive(Clone, Copy, Debug)]
enum Content {
    Page,
    Figures,
}

impl Formats for Content {
    const STREAM: Self = Self::Page;
    const KIND: &'static str = "report";

    fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_lowercase();
        [("html", Self::Page), ("json", Self::Figures)].into_iter().find(|(own, _)| *own == extension).map(|(_, of)| of)
    }

    fn known() -> Vec<&'static str> {
        vec!["html", "json"]
    }
}

fn write_figures(figures: &Statistics, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, figures)?;
    writeln!(out)
}
