//! Flags of `mesocrete effective`.

use crate::commands::shared::{Threads, Writing};
use crate::commands::{names, values};
use meso_core::mesh::MethodName;
use meso_effective::Boundary;
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz), `-` for standard input; or a label volume (.tif, .npy, .vti)
    pub(super) model: PathBuf,
    /// Folder of the results: effective.json, effective.html, and the fields, diffusivity_x.vti, stiffness_xx.vti and so on;
    /// .vtu of tetrahedra
    #[arg(short, long, value_name = "DIR", default_value = "out")]
    pub(super) output: PathBuf,
    /// Property: diffusivity, conductivity, stiffness, or all
    #[arg(long, value_name = "PROPERTY", default_value = "diffusivity", value_parser = what)]
    pub(super) what: What,
    /// Values of the phases: a TOML file with the tables [diffusivity] and [conductivity], each with mortar, aggregate,
    /// itz, void, fibre [default: diffusivity 1, 0, 1, 0, 0; conductivity 1.5, 3, 1.5, 0.025, 50], and with tables such as
    /// [stiffness.mortar], each with youngs_modulus_mpa, poisson_ratio, eigenstrain. A label volume takes labels as keys, too,
    /// as in 0 = 1.0
    #[arg(long, value_name = "FILE")]
    pub(super) phases: Option<PathBuf>,
    /// Edge of a voxel, mm; the error follows from voxels of twice the size [default: an eighth of the smallest grain; of a
    /// label volume, the file's, or else 1]
    #[arg(long, value_name = "H", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["voxel-size", "size", "h"])]
    pub(super) voxel_size_mm: Option<f64>,
    /// Division of a model: voxel, or lattice, tetrahedra whose faces follow the aggregates
    #[arg(long, value_name = "METHOD", default_value = "voxel", value_parser = names::parser::<MethodName>())]
    pub(super) method: MethodName,
    /// Edge length of the tetrahedra, mm; the error follows from elements of twice the size [default: a quarter of the
    /// smallest grain]
    #[arg(long, value_name = "H", value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["element-size", "mesh-size"])]
    pub(super) element_size_mm: Option<f64>,
    /// Strains without stress of the phases, which expand or shrink the specimen, as in mortar=-4e-4,itz=-4e-4
    #[arg(long, value_name = "PHASE=STRAIN", value_delimiter = ',', value_parser = eigenstrain)]
    pub(super) eigenstrain: Vec<(String, f64)>,
    /// Axes along which a label volume repeats itself; without, it has walls
    #[arg(long, value_name = "AXES", value_parser = axes)]
    pub(super) periodic: Option<Axes>,
    /// Axes of the gradient; each takes a solution. Stiffness always has all
    #[arg(long, value_name = "AXES", default_value = "xyz", value_parser = axes)]
    pub(super) axes: Axes,
    /// Conditions at walls: fixed, given potentials at the ends of the gradient and insulated sides; uniform-gradient, an upper
    /// estimate, or uniform-flux, a lower one, in tetrahedra
    #[arg(long, value_name = "NAME", default_value = "fixed", value_parser = boundary)]
    pub(super) boundary: Boundary,
    /// Error of the equations, over the result, beside that of the voxels [default: 1e-9; of stiffness 1e-12]
    #[arg(long, value_name = "SHARE", value_parser = values::number, allow_negative_numbers = true)]
    pub(super) tolerance: Option<f64>,
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
    pub(super) stiffness: bool,
}

/// Which of x, y, z are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Axes(pub(super) [bool; 3]);

fn what(text: &str) -> Result<What, String> {
    let is = |name: &str| text == name || text == "all";
    let what = What { diffusivity: is("diffusivity"), conductivity: is("conductivity"), stiffness: is("stiffness") };
    if !(what.diffusivity || what.conductivity || what.stiffness) {
        return Err("it must be diffusivity, conductivity, stiffness or all".to_owned());
    }
    Ok(what)
}

fn boundary(text: &str) -> Result<Boundary, String> {
    Boundary::named(text).ok_or_else(|| format!("it must be {}", Boundary::NAMES.join(", ")))
}

fn eigenstrain(text: &str) -> Result<(String, f64), String> {
    let (phase, strain) = text.split_once('=').ok_or("it must be a phase and a strain, as in mortar=-4e-4")?;
    Ok((phase.trim().to_owned(), values::number(strain.trim())?))
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
