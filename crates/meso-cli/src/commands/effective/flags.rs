//! Flags of `mesocrete effective`.

use crate::commands::shared::{Threads, Writing};
use crate::commands::values;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    pub(super) model: PathBuf,
    /// Folder of the results: effective.json, effective.html, and the fields, diffusivity_x.vti and so on
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub(super) output: PathBuf,
    /// Property: diffusivity, conductivity, or all for both
    #[arg(long, value_name = "PROPERTY", default_value = "diffusivity", value_parser = what)]
    pub(super) what: What,
    /// Values of the phases: a TOML file with the tables [diffusivity] and [conductivity], each with mortar, aggregate,
    /// itz, void, fibre [default: diffusivity 1, 0, 1, 0, 0; conductivity 1.5, 3, 1.5, 0.025, 50]
    #[arg(long, value_name = "FILE")]
    pub(super) phases: Option<PathBuf>,
    /// Edge of a voxel, mm; the error follows from voxels of twice the size [default: an eighth of the smallest grain]
    #[arg(long, value_name = "H", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["voxel-size", "size", "h"])]
    pub(super) voxel_size_mm: Option<f64>,
    /// Axes of the gradient; each takes a solution
    #[arg(long, value_name = "AXES", default_value = "xyz", value_parser = axes)]
    pub(super) axes: Axes,
    /// Write no fields
    #[arg(long)]
    pub(super) no_fields: bool,
    #[command(flatten)]
    pub(super) threads: Threads,
    #[command(flatten)]
    pub(super) writing: Writing,
}

/// Properties by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct What {
    pub(super) diffusivity: bool,
    pub(super) conductivity: bool,
}

/// Which of x, y, z are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Axes(pub(super) [bool; 3]);

fn what(text: &str) -> Result<What, String> {
    match text {
        "diffusivity" => Ok(What { diffusivity: true, conductivity: false }),
        "conductivity" => Ok(What { diffusivity: false, conductivity: true }),
        "all" => Ok(What { diffusivity: true, conductivity: true }),
        "stiffness" => Err("stiffness is not computed yet; it must be diffusivity, conductivity or all".to_owned()),
        _ => Err("it must be diffusivity, conductivity or all".to_owned()),
    }
}

fn axes(text: &str) -> Result<Axes, String> {
    let has = |axis: char| text.contains(axis);
    let axes = [has('x'), has('y'), has('z')];
    let named = axes.iter().filter(|axis| **axis).count();
    if named == 0 || text.chars().count() != named {
        return Err("it must be some of x, y, z, each once, as in xz".to_owned());
    }
    Ok(Axes(axes))
}
