//! Flags of `mesocrete solve`.

use crate::commands::file_or::FileOr;
use crate::commands::meshing::MeshFlags;
use crate::commands::names;
use crate::commands::shared::{Threads, Writing};
use crate::commands::values;
use crate::gpu::Choice;
use clap::builder::TypedValueParser;
use meso_ask::{Given, Over};
use meso_solve::{Test, TestKind};
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz; `-` is standard input), or what to pack (SPEC.toml); absent: a 150 mm cube, Fuller 5 to 20 mm,
    /// 40 %, gaps of 1 mm, in elements of 4 mm
    pub(super) model: Option<PathBuf>,
    /// Folder of the results: curve.csv, result.json, frames.pvd with its .vtu files, result.html
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub(super) output: PathBuf,
    #[arg(long, value_name = "NAME|TEST.toml", default_value = "compression", value_parser = test_parser())]
    #[arg(help = format!("The test: {}; or a file of its supports, loads, turns and gauges, see `mesocrete init --test`", names::list::<TestKind>()))]
    pub(super) test: TestText,
    #[command(flatten)]
    pub(super) given: Given<Test>,
    /// Plates of brushes or teflon: a friction of 0.005
    #[arg(long, conflicts_with = "friction")]
    pub(super) brush: bool,
    /// Write checkpoint.bin every S seconds, for --resume
    #[arg(long, value_name = "S", value_parser = values::seconds, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(super) checkpoint: Option<f64>,
    /// Resume from the checkpoint.bin in DIR; give the same flags as before
    #[arg(long)]
    pub(super) resume: bool,
    #[command(flatten)]
    pub(super) over: Given<Over>,
    /// What takes the steps: cpu, gpu (the first that there is), cuda:N or opencl:N; the results are the same bytes (see
    /// `mesocrete devices`)
    #[arg(long, value_name = "NAME", default_value_t = Choice::Cpu)]
    pub(super) device: Choice,
    #[command(flatten)]
    pub(super) threads: Threads,
    #[command(flatten)]
    pub(super) writing: Writing,
    #[command(flatten)]
    pub(super) mesh: MeshFlags,
}

/// A named test, or the file that describes one.
#[derive(Clone, Debug)]
pub(super) enum TestText {
    Named(TestKind),
    File(PathBuf),
}

/// Parser of a test.
fn test_parser() -> impl TypedValueParser<Value = TestText> {
    FileOr { file: TestText::File, name: names::parser::<TestKind>().map(TestText::Named) }
}
