//! How a specimen is divided for a test, and of what it is made: the flags of `mesh` that a test needs, with a test's defaults.

use crate::commands::{meshing, names, values};
use crate::failure::Failure;
use crate::progress::Watch;
use meso_core::Model;
use meso_core::materials::Materials;
use meso_core::mesh::{Fit, ItzForm, Mesh, MeshOptions, MeshTable, MethodName, NarrowGaps};
use meso_core::specimen::Specimen;
use meso_core::watch::Stage;
use std::path::PathBuf;

/// Element size without a model, mm: the whole test then takes minutes.
const QUICK_MM: f64 = 4.0;

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Mesh and materials")]
pub(super) struct Division {
    #[arg(long, default_value = "lattice", value_parser = names::parse::<MethodName>)]
    #[arg(help = format!("Method of meshing: {}", names::list::<MethodName>()))]
    method: MethodName,
    /// Edge length of the elements, mm [default: 2; without a model 4]
    #[arg(long, value_name = "H", value_parser = values::number, allow_negative_numbers = true, aliases = meshing::SIZE)]
    element_size_mm: Option<f64>,
    #[arg(long, default_value = "smeared", value_parser = names::parse::<ItzForm>)]
    #[arg(help = format!("Interfacial transition zone in the test: {}", names::list::<ItzForm>()))]
    itz: ItzForm,
    #[arg(long, default_value = "fitted", value_parser = names::parse::<Fit>)]
    #[arg(help = format!("Fit of a lattice to the aggregates' surfaces: {}", names::list::<Fit>()))]
    fit: Fit,
    #[arg(long, value_name = "GAPS", value_parser = names::parse::<NarrowGaps>)]
    #[arg(help = format!("Gaps one tetrahedron wide between aggregates: {} [default: split; without a model keep]", names::list::<NarrowGaps>()))]
    narrow_gaps: Option<NarrowGaps>,
    /// Sub-samples per voxel and axis, 1 to 8; with more than 1 each body gets as many voxels as its samples fill
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = values::whole_number)]
    #[arg(allow_negative_numbers = true)]
    subsamples: u32,
    /// A TOML file with a [materials] table; values it leaves out keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// The program gmsh, for --method conforming
    #[arg(long, value_name = "PROGRAM", default_value = "gmsh")]
    gmsh: PathBuf,
}

impl Division {
    /// Options of the mesh of `specimen`, checked.
    pub(super) fn options(&self, is_quick: bool, specimen: &Specimen) -> Result<MeshOptions, Failure> {
        let options = self.for_any(is_quick)?;
        meshing::check(&options, &self.gmsh, specimen)?;
        Ok(options)
    }

    /// Options of the mesh of any specimen.
    pub(super) fn for_any(&self, is_quick: bool) -> Result<MeshOptions, Failure> {
        let usual = MeshTable::of_a_test();
        let table = MeshTable {
            method: self.method,
            element_size_mm: self.element_size_mm.unwrap_or(if is_quick { QUICK_MM } else { usual.element_size_mm }),
            itz: Some(self.itz),
            narrow_gaps: self.narrow_gaps.unwrap_or(if is_quick { NarrowGaps::Keep } else { usual.narrow_gaps }),
            fit: self.fit,
            subsamples: self.subsamples,
            ..usual
        };
        MeshOptions::try_from(table).map_err(|error| meshing::wrong_mesh(&error))
    }

    /// Whether the mesh is of voxels.
    pub(super) fn has_boxes(&self) -> bool {
        self.method == MethodName::Voxel
    }

    /// Whether a file says what the materials are.
    pub(super) fn has_materials(&self) -> bool {
        self.materials.is_some()
    }

    pub(super) fn materials(&self) -> Result<Materials, Failure> {
        meshing::materials(self.materials.as_deref())
    }

    pub(super) fn build(&self, model: &Model, options: &MeshOptions, quiet: bool) -> Result<Mesh, Failure> {
        let mut watch = Watch::of_files(quiet, &[(Stage::Mesh, 1.0)]);
        let mesh = meshing::build(model, options, &self.gmsh, quiet, &watch);
        watch.finish();
        mesh
    }
}
