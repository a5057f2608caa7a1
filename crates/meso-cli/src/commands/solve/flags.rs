//! Flags of `mesocrete solve`.

use crate::commands::meshing::MeshFlags;
use crate::commands::shared::{Threads, Writing};
use crate::commands::{names, values};
use clap::builder::TypedValueParser;
use meso_gpu::Choice;
use meso_solve::{Control, LawName, Smoothing, Test, TestKind};
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz; `-` is standard input), or what to pack (SPEC.toml); absent: a 150 mm cube, Fuller 5 to 20 mm,
    /// 40 %, gaps of 1 mm, in elements of 4 mm
    pub(super) model: Option<PathBuf>,
    /// Folder of the results: curve.csv, result.json, frames.pvd with its .vtu files, result.html
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub(super) output: PathBuf,
    /// Load on the specimen, along z
    #[arg(long, default_value = "compression", value_parser = names::parser::<TestKind>())]
    pub(super) test: TestKind,
    /// Friction between plates and specimen; in tension the plates are glued on
    #[arg(long, value_name = "MU", default_value_t = Test::default().friction, value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    pub(super) friction: f64,
    /// Mean axial strain at the end [default: 0.005 in compression, 0.0005 in tension]
    #[arg(long, value_name = "E", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) strain: Option<f64>,
    /// The law of mortar and ITZ
    #[arg(long, default_value_t = LawText(Test::default().law), value_parser = names::parser::<LawName>().map(LawText))]
    pub(super) law: LawText,
    /// Smooth the strains of tetrahedra, so that peaks hardly depend on their size [default: edges; none for voxels]
    #[arg(long, value_name = "OVER", value_parser = names::parser::<Smoothing>())]
    #[arg(hide_short_help = true)]
    pub(super) smoothing: Option<Smoothing>,
    /// Plates that slow down while the specimen breaks, or keep their speed as in a deck
    #[arg(long, value_name = "HOW", default_value = "servo", value_parser = names::parser::<Control>())]
    #[arg(hide_short_help = true)]
    pub(super) control: Control,
    /// Frames of all fields, evenly over the test, 0 for none; more while a servo holds the plates back
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = values::whole_number)]
    #[arg(allow_negative_numbers = true)]
    pub(super) frames: u32,
    /// Time of the test at the plates' full speed, s; short ones are not quasi-static [default: by the height and the strain]
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(super) duration: Option<f64>,
    /// Time step that mass scaling keeps, s [default: by the element size]
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(super) time_step: Option<f64>,
    /// Write checkpoint.bin every S seconds, for --resume
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(super) checkpoint: Option<f64>,
    /// Resume from the checkpoint.bin in DIR; give the same flags as before
    #[arg(long)]
    pub(super) resume: bool,
    /// Seed of the packing, where one is made
    #[arg(long, value_name = "N", value_parser = values::seed, allow_negative_numbers = true)]
    pub(super) seed: Option<u64>,
    /// Volume of the aggregates over the specimen's, 0 to 1, where a packing is made
    #[arg(long, value_name = "F", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) fraction: Option<f64>,
    /// Smallest distance between two aggregates, where a packing is made [default: half an element, or less where the packing
    /// would get too dense]
    #[arg(long, value_name = "MM", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) min_gap_mm: Option<f64>,
    /// End the packing after S seconds with the best found, where one is made
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) time_limit: Option<f64>,
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

/// A law by its name, as clap shows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct LawText(pub(super) LawName);

impl std::fmt::Display for LawText {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&names::of(&self.0))
    }
}
