//! Flags of `mesocrete image`.

use crate::commands::shared::{Threads, Writing};
use crate::commands::{names, values};
use crate::formats::Named;
use meso_core::formats::ImageFormat;
use meso_core::voxel_image::{ImageOptions, Quantity, ShareOf};
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    pub(super) model: PathBuf,
    /// File to write, its format by the extension: .npy, .tif, .vti; of a section .png and .svg, too; `-` writes the
    /// .npy to standard output. May be repeated
    #[arg(short, long, value_name = "FILE", required = true, value_parser = Named::<ImageFormat>::parser())]
    pub(super) output: Vec<Named<ImageFormat>>,
    /// Edge of a voxel, mm; along periodic axes it must divide the specimen's length
    #[arg(long, value_name = "H", default_value_t = ImageOptions::default().voxel_size_mm, value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["voxel-size", "size", "h"])]
    pub(super) voxel_size_mm: f64,
    /// Quantity at the voxels
    #[arg(long, default_value = "phase", value_parser = names::parser::<Quantity>())]
    pub(super) what: Quantity,
    /// Bodies whose share of a voxel is written, with --what share [default: aggregate, ITZ included]
    #[arg(long, value_parser = names::parser::<ShareOf>())]
    pub(super) of: Option<ShareOf>,
    /// Write only the voxels on a plane normal to an axis, in mm: z=75
    #[arg(long, value_name = "AXIS=MM", value_parser = plane, conflicts_with = "box")]
    pub(super) section: Option<(usize, f64)>,
    /// Write only a box, given by its lower and upper corner in mm: 0,0,0,50,50,50. Voxels start at the lower corner
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = corners, allow_hyphen_values = true)]
    pub(super) r#box: Option<[f64; 6]>,
    #[command(flatten)]
    pub(super) threads: Threads,
    #[command(flatten)]
    pub(super) writing: Writing,
}

/// An axis and a position on it.
fn plane(text: &str) -> Result<(usize, f64), String> {
    let expected = || "it must be an axis and a length in mm, as in z=75".to_owned();
    let (axis, at) = text.split_once('=').ok_or_else(expected)?;
    let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim()).ok_or_else(expected)?;
    at.trim().parse().ok().filter(|at: &f64| at.is_finite()).map(|at| (axis, at)).ok_or_else(expected)
}

/// Six coordinates.
fn corners(text: &str) -> Result<[f64; 6], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| "it must be six lengths in mm, separated by commas".to_owned())
}
