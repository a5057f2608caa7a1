//! Flags of `mesocrete fit`.

use crate::commands::shared::Writing;
use crate::commands::{names, values};
use meso_solve::{LawName, Test};
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
    /// Number of packings, of successive seeds from the spec's on; their scatter is the uncertainty
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = values::packings, allow_negative_numbers = true)]
    pub(super) seeds: u32,
    /// Most steps after the first five points; each tests every packing once
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = values::whole_number, allow_negative_numbers = true)]
    pub(super) steps: u32,
    /// A TOML file with the [materials] to start from; absent values keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    pub(super) materials: Option<PathBuf>,
    /// Friction between plates and specimen
    #[arg(long, value_name = "MU", default_value_t = Test::default().friction(), value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    pub(super) friction: f64,
    /// Mean axial strain at the end [default: 1.15 times the last one of the curve]
    #[arg(long, value_name = "E", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) strain: Option<f64>,
    /// The law of mortar and ITZ [default: that of solve]
    #[arg(long, value_name = "LAW", value_parser = names::parser::<LawName>())]
    pub(super) law: Option<LawName>,
    /// Size of an element, mm [default: that of solve]
    #[arg(long, value_name = "H", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) element_size_mm: Option<f64>,
    /// Smallest distance between two aggregates, in every packing [default: the spec's; where it has none, as much as the mesh needs]
    #[arg(long, value_name = "MM", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) min_gap_mm: Option<f64>,
    /// End every packing after S seconds with the best found; the results then depend on the machine
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) time_limit: Option<f64>,
    /// Accept meshes that show a phase badly, as `solve` does
    #[arg(long)]
    pub(super) accept_phase_error: bool,
    /// Number of tests at the same time. It changes the time, never the result
    #[arg(short, long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    pub(super) jobs: Option<u16>,
    /// Number of threads of a test; when absent the cores are shared among the tests at the same time
    #[arg(long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    pub(super) threads: Option<u16>,
    #[command(flatten)]
    pub(super) writing: Writing,
}
