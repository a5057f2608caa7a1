//! Flags of `mesocrete fit`.

use crate::commands::shared::Writing;
use crate::commands::values;
use meso_ask::{FitAsk, Given};
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// The measured curve (CSV): columns strain and stress_mpa, or displacement_mm and stress_mpa; without a header line the
    /// first column is the strain and the second the stress
    pub(super) curve: PathBuf,
    /// The specimen that was tested (SPEC.toml)
    pub(super) spec: PathBuf,
    /// Folder of the fit: materials.toml, fit.json, and cases/ with every test
    #[arg(short, long, value_name = "DIR", default_value = "fit")]
    pub(super) output: PathBuf,
    #[command(flatten)]
    pub(super) ask: Given<FitAsk>,
    /// A TOML file with the [materials] to start from; absent values keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    pub(super) materials: Option<PathBuf>,
    /// Number of tests at the same time. It changes the time, never the result
    #[arg(short, long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    pub(super) jobs: Option<u16>,
    /// Number of threads of a test; when absent the cores are shared among the tests at the same time
    #[arg(long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    pub(super) threads: Option<u16>,
    #[command(flatten)]
    pub(super) writing: Writing,
}
