//! Flags of `mesocrete mesh`.

use crate::commands::meshing::Meshing;
use crate::commands::shared::{Threads, Writing};
use crate::formats::Named;
use meso_core::formats::MeshFormat;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    pub(super) model: PathBuf,
    /// File to write, its format by the extension: .inp, .k, .cdb, .vtu, .pvtu (pieces beside it), .msh, .xdmf; `-` is standard output
    /// (.inp). May be repeated
    #[arg(short, long, value_name = "FILE", required = true, value_parser = Named::<MeshFormat>::parser())]
    pub(super) output: Vec<Named<MeshFormat>>,
    #[command(flatten)]
    pub(super) threads: Threads,
    /// Compress the data of a .vtu (zlib)
    #[arg(long, hide_short_help = true)]
    pub(super) compress: bool,
    /// Exit with 3 when a phase is more than 1 % off its exact volume
    #[arg(long, hide_short_help = true)]
    pub(super) strict: bool,
    #[command(flatten)]
    pub(super) writing: Writing,
    /// Write the figures of the mesh as JSON, every bad element by its number; `-` is standard output
    #[arg(long, value_name = "FILE")]
    pub(super) summary_json: Option<PathBuf>,
    #[command(flatten)]
    pub(super) meshing: Meshing,
}
