//! Flags of `mesocrete solve`.

use crate::commands::meshing::MeshFlags;
use crate::commands::names;
use crate::commands::shared::{Threads, Writing};
use crate::commands::test_file::FileOr;
use crate::commands::values;
use crate::gpu::Choice;
use clap::builder::TypedValueParser;
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
    #[arg(long, value_name = "NAME|TEST.toml", default_value = "compression", value_parser = test_parser())]
    #[arg(help = format!("The test: {}; or a file of its supports, loads, turns and gauges, see `mesocrete init --test`", names::list::<TestKind>()))]
    pub(super) test: TestText,
    #[arg(long, value_name = "MU", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(help = format!("Friction between plates and specimen; in tension the plates are glued on [default: {}; 0.5 in splitting]", Test::default().friction()))]
    pub(super) friction: Option<f64>,
    /// Plates of brushes or teflon: a friction of 0.005
    #[arg(long, conflicts_with = "friction")]
    pub(super) brush: bool,
    /// Lateral pressure of a triaxial test, MPa; negative ones are tension [default: 5]
    #[arg(long, value_name = "P", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) pressure_mpa: Option<f64>,
    /// Strain at the end [default: by the test; 0.005 in compression, 0.0005 in tension]
    #[arg(long, value_name = "E", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) strain: Option<f64>,
    #[arg(long, value_parser = names::parser::<LawName>())]
    #[arg(help = format!(
        "The law of mortar and ITZ: meso is that of mortar between grains, cdp the twin of a deck, cdpm2 for comparison \
         [default: {}]",
        names::of(&Test::default().law)
    ))]
    pub(super) law: Option<LawName>,
    /// Smooth the strains of tetrahedra, so that peaks hardly depend on their size [default: edges; none for voxels]
    #[arg(long, value_name = "OVER", value_parser = names::parser::<Smoothing>())]
    #[arg(hide_short_help = true)]
    pub(super) smoothing: Option<Smoothing>,
    /// Plates that slow down while the specimen breaks, follow the crack mouth or the lateral strain, or keep their speed as in a
    /// deck [default: servo]
    #[arg(long, value_name = "HOW", value_parser = names::parser::<Control>())]
    #[arg(hide_short_help = true)]
    pub(super) control: Option<Control>,
    /// Frames of all fields, evenly over the strain, 0 for none
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

/// A named test, or the file that describes one.
#[derive(Clone, Debug)]
pub(super) enum TestText {
    Named(TestKind),
    File(PathBuf),
    /// The test of a study.
    Tree(Box<Test>),
}

/// Parser of a test.
fn test_parser() -> impl TypedValueParser<Value = TestText> {
    FileOr { file: TestText::File, name: names::parser::<TestKind>().map(TestText::Named) }
}
