//! Flags of `mesocrete effective`.

use crate::commands::shared::{Threads, Writing};
use meso_ask::EffectiveAsk;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz), `-` for standard input; a label volume (.tif, .npy, .vti); or the folder of a test
    /// with frames, which `mesocrete solve` wrote
    pub(super) model: PathBuf,
    /// Folder of the results: effective.json, effective.html, and the fields, diffusivity_x.vti, stiffness_xx.vti and so on;
    /// .vtu of tetrahedra
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub(super) output: PathBuf,
    /// Array of a .vti that has the labels [default: its scalars, of the cells or else of the points]
    #[arg(long, value_name = "NAME")]
    pub(super) array: Option<String>,
    #[command(flatten)]
    pub(super) ask: EffectiveAsk,
    #[command(flatten)]
    pub(super) threads: Threads,
    #[command(flatten)]
    pub(super) writing: Writing,
}
