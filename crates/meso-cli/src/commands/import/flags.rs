//! Flags of `mesocrete import`.

use crate::commands::shared::{Threads, Writing};
use crate::commands::values;
use crate::formats::Named;
use meso_core::formats::Format;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A label volume (.tif, .npy, .vti): one integer a grain or a phase
    pub(super) volume: PathBuf,
    /// File to write, as `convert` does: .json, .json.gz, .vtu, .stl and so on. May be repeated
    #[arg(short, long, value_name = "FILE", default_value = "model.json", value_parser = Named::<Format>::parser())]
    pub(super) output: Vec<Named<Format>>,
    /// Edge of a voxel, mm; or three, along x, y, z [default: the file's, or else 1]
    #[arg(long, value_name = "H", value_delimiter = ',', value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["voxel-size", "size", "h"])]
    pub(super) voxel_size_mm: Vec<f64>,
    /// Array of a .vti that has the labels [default: its scalars, of the cells or else of the points]
    #[arg(long, value_name = "NAME")]
    pub(super) array: Option<String>,
    /// Labels of the mortar; every connected part of another label is a grain
    #[arg(long, value_name = "LABELS", value_delimiter = ',', default_value = "0", allow_negative_numbers = true)]
    pub(super) mortar: Vec<i64>,
    /// Labels that are the aggregates' phase together, such as core and ITZ; its connected parts are the grains, and all
    /// other labels are mortar
    #[arg(
        long,
        value_name = "LABELS",
        value_delimiter = ',',
        allow_negative_numbers = true,
        conflicts_with = "mortar"
    )]
    pub(super) aggregate: Vec<i64>,
    /// Labels outside a drilled core, which stands along z: its cylinder is the specimen, not the whole box
    #[arg(long, value_name = "LABELS", value_delimiter = ',', allow_negative_numbers = true)]
    pub(super) outside: Vec<i64>,
    /// Smaller grains are mortar
    #[arg(long, value_name = "N", default_value = "64", value_parser = values::whole_number)]
    pub(super) least_voxels: u32,
    /// Largest share of the volume that a grain may have; a larger one is asked about, since it may be mortar
    #[arg(long, value_name = "SHARE", default_value = "0.2", value_parser = values::number)]
    pub(super) largest_grain: f64,
    /// Exit with 3 if the aggregates have over 2 % less volume than the labels
    #[arg(long)]
    pub(super) strict: bool,
    /// Gap between grains that are nearer, mm, so that elements of this size keep mortar between them [default: half a voxel]
    #[arg(long, value_name = "G", default_value = "0", hide_default_value = true, value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    pub(super) gap_mm: f64,
    /// Thickness of the ITZ of every grain, mm
    #[arg(long, value_name = "T", default_value = "0", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) itz_thickness_mm: f64,
    /// Root mean square error of merged triangles, in voxels
    #[arg(long, value_name = "VOXELS", default_value = "0.2", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, hide_short_help = true)]
    pub(super) tolerance: f64,
    /// Width of the blur that smooths surfaces, in voxels
    #[arg(long, value_name = "VOXELS", default_value = "1", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, hide_short_help = true)]
    pub(super) smoothing: f64,
    /// Distance of the points between which a surface is found, in voxels; at most 1 on small grains
    #[arg(long, value_name = "VOXELS", default_value = "2", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, hide_short_help = true)]
    pub(super) step: f64,
    #[command(flatten)]
    pub(super) threads: Threads,
    #[command(flatten)]
    pub(super) writing: Writing,
}
