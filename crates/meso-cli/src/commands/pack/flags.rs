//! Flags of `mesocrete pack`.

use crate::commands::meshing::Meshing;
use crate::commands::shared::{Threads, Writing};
use crate::commands::{names, values};
use meso_core::images::Images;
use meso_core::packing::Strategy;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Spec to pack (TOML, see `mesocrete init`); `-` is standard input; absent: a 150 mm cube, Fuller 5 to 20 mm, 50 %
    pub(super) spec: Option<PathBuf>,
    /// File to write, its format by the extension: .json, .json.gz, .vtu, .vtp, .stl, .step, .glb, .ply, .obj, .csv; a
    /// page: .html; meshes: .inp, .k, .cdb, .msh, .pvtu, .xdmf; `-` writes the .json to standard output. May be repeated; absent: model.json, model.vtu, model.inp, model.html
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    /// Seed of all randomness; the same seed gives the same bytes
    #[arg(long, value_name = "N", value_parser = values::seed, allow_negative_numbers = true)]
    pub(super) seed: Option<u64>,
    /// Volume of the aggregates over the specimen's, 0 to 1
    #[arg(long, value_name = "F", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) fraction: Option<f64>,
    /// Strategy of placement
    #[arg(long, value_parser = names::parser::<Strategy>())]
    pub(super) strategy: Option<Strategy>,
    /// Random positions tried per aggregate
    #[arg(long, value_name = "N", value_parser = values::count, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(super) attempts: Option<u32>,
    /// Smallest distance between two aggregates; 0 only proves them apart. The default is 0, with `--method conforming`
    /// 0.05, and with an --analysis half an element, or less where the packing would get too dense
    #[arg(long, value_name = "MM", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) min_gap_mm: Option<f64>,
    /// Smallest distance between an aggregate and the specimen's surface. Periodic packings are shifted until no aggregate
    /// touches a face
    #[arg(long, value_name = "MM", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    pub(super) wall_gap_mm: Option<f64>,
    /// Stop after S seconds with the best packing found. If generation used up the time, placement gets one more second
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) time_limit: Option<f64>,
    #[command(flatten)]
    pub(super) threads: Threads,
    /// Aggregates that cross a face of a periodic specimen, where surfaces are written
    #[arg(long, default_value = "none", value_parser = names::parser::<Images>())]
    #[arg(hide_short_help = true)]
    pub(super) images: Images,
    /// Exit with 3 when the target is not reached
    #[arg(long, hide_short_help = true)]
    pub(super) strict: bool,
    /// Compress the data of a .vtu or .vtp (zlib)
    #[arg(long, hide_short_help = true)]
    pub(super) compress: bool,
    #[command(flatten)]
    pub(super) writing: Writing,
    /// Print every size class, and all figures of the mesh
    #[arg(short, long, conflicts_with = "quiet")]
    pub(super) verbose: bool,
    /// Write the figures of the run as JSON; `-` is standard output
    #[arg(long, value_name = "FILE")]
    pub(super) summary_json: Option<PathBuf>,
    #[command(flatten)]
    pub(super) meshing: Meshing,
}
