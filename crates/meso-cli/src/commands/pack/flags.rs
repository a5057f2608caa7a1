//! Flags of `mesocrete pack`.

use crate::commands::meshing::Meshing;
use crate::commands::names;
use crate::commands::shared::{Threads, Writing};
use crate::formats::{Content, Named};
use meso_ask::{Given, Over};
use meso_core::images::Images;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Spec to pack (TOML, see `mesocrete init`); `-` is standard input; absent: a 150 mm cube, Fuller 5 to 20 mm, 50 %
    pub(super) spec: Option<PathBuf>,
    /// File to write, its format by the extension: .json, .json.gz, .vtu, .vtp, .stl, .step, .glb, .ply, .obj, .csv; a
    /// page: .html; meshes: .inp, .k, .cdb, .msh, .pvtu, .xdmf; `-` writes the .json to standard output. May be repeated; absent: model.json, model.vtu, model.inp, model.html
    #[arg(short, long, value_name = "FILE", value_parser = Named::<Content>::parser())]
    pub(super) output: Vec<Named<Content>>,
    #[command(flatten)]
    pub(super) over: Given<Over>,
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
