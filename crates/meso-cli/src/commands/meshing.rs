//! The flags of a mesh and its deck, the same for `pack` and `mesh`, and the mesh they ask for.

use super::{names, values};
use crate::failure::Failure;
use crate::{inputs, stderr};
use meso_core::Model;
use meso_core::export::abaqus::{Analysis, DeckError, DeckOptions, Loading};
use meso_core::materials::Materials;
use meso_core::mesh::conforming::{ROOM_MM, Surfaces};
use meso_core::mesh::{self, Fit, ItzForm, Mesh, MeshError, MeshOptions, MeshTable, MethodName, VolumeMesher};
use meso_core::packing::{Placement, Specimen};
use meso_core::spec::options_from_toml;
use meso_gmsh::Gmsh;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Meshes and decks")]
pub(super) struct Meshing {
    #[arg(long, default_value = "voxel", value_parser = names::parse::<MethodName>)]
    #[arg(help = format!("How the specimen is divided: {}", names::list::<MethodName>()))]
    method: MethodName,
    /// Edge length of the elements, mm
    #[arg(long, value_name = "H", default_value_t = MeshOptions::default().element_size_mm, value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    element_size_mm: f64,
    #[arg(long, default_value = "solid", value_parser = names::parse::<ItzForm>)]
    #[arg(help = format!("How the interfacial transition zone enters the mesh: {}", names::list::<ItzForm>()))]
    itz: ItzForm,
    #[arg(long, default_value = "fitted", value_parser = names::parse::<Fit>)]
    #[arg(help = format!("What a lattice does at the aggregates' surfaces: {}", names::list::<Fit>()))]
    fit: Fit,
    /// 2 puts a node in the middle of every edge of a tetrahedron (C3D10); lattice and conforming
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = values::whole_number)]
    #[arg(allow_negative_numbers = true)]
    order: u32,
    /// Let the ITZ be thinner than one voxel, with holes in it
    #[arg(long)]
    thin_itz: bool,
    /// Sub-samples per voxel and axis, 1 to 8; more than 1 takes the majority
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = values::whole_number)]
    #[arg(allow_negative_numbers = true)]
    subsamples: u32,
    /// Hexahedra with reduced integration (C3D8R)
    #[arg(long)]
    reduced_integration: bool,
    /// Only nodes, elements, sets and surfaces, for *INCLUDE
    #[arg(long)]
    geometry_only: bool,
    /// Tie opposite faces of a periodic box by *EQUATION; REF_X, REF_Y and REF_Z take the mean strain
    #[arg(long)]
    periodic_equations: bool,
    #[arg(long, default_value = "none", value_parser = names::parse::<Analysis>)]
    #[arg(help = format!("What a deck computes: {}", names::list::<Analysis>()))]
    analysis: Analysis,
    /// Mean axial strain at the end of the analysis [default: 0.001 elastic and tension, 0.006 compression]
    #[arg(long, value_name = "E", value_parser = values::number, allow_negative_numbers = true)]
    strain: Option<f64>,
    /// Friction between plates and specimen in compression
    #[arg(long, value_name = "MU", default_value_t = Loading::default().friction, value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    friction: f64,
    /// Frames of field output in compression and tension
    #[arg(long, value_name = "N", default_value_t = Loading::default().frames, value_parser = values::count)]
    #[arg(allow_negative_numbers = true)]
    frames: u32,
    /// A TOML file with a [materials] table; values it leaves out keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// Parts of a specimen that gmsh fills apart; absent: as its memory needs
    #[arg(long, value_name = "N", value_parser = values::whole_number, allow_negative_numbers = true)]
    slabs: Option<u32>,
    /// The program gmsh, for --method conforming
    #[arg(long, value_name = "PROGRAM", default_value = "gmsh")]
    gmsh: PathBuf,
}

impl Meshing {
    /// What was typed, whatever method it belongs to.
    fn table(&self) -> MeshTable {
        MeshTable {
            method: self.method,
            element_size_mm: self.element_size_mm,
            itz: self.itz,
            thin_itz: self.thin_itz,
            subsamples: self.subsamples,
            fit: self.fit,
            order: self.order,
            slabs: self.slabs,
        }
    }

    /// The options; flags of other methods were named by [`warn_unused`](Self::warn_unused), and do nothing.
    pub(super) fn options(&self) -> Result<MeshOptions, Failure> {
        let table = self.table();
        let options = table.validate_ranges().and_then(|()| table.without_foreign().try_into());
        options.map_err(|error| wrong_mesh(&error))
    }

    /// Contents of a deck; options that a mesh of `specimen` cannot carry are wrong usage.
    pub(super) fn deck(&self, specimen: &Specimen) -> Result<DeckOptions, Failure> {
        let deck = DeckOptions {
            analysis: self.analysis,
            strain: self.strain,
            loading: Loading { friction: self.friction, frames: self.frames, ..Loading::default() },
            materials: materials(self.materials.as_deref())?,
            geometry_only: self.geometry_only,
            reduced_integration: self.reduced_integration,
            periodic_equations: self.periodic_equations,
            ..DeckOptions::default()
        };
        deck.validate_for(specimen.periodic().0).map_err(|error| wrong_deck(&error))?;
        if self.itz == ItzForm::Cohesive {
            deck.validate_cohesive().map_err(|error| wrong_deck(&error))?;
        }
        Ok(deck)
    }

    /// Warns of flags without effect: those of decks where none is written, those of another method or analysis.
    pub(super) fn warn_unused(&self, writes_deck: bool) {
        let deck = [
            ("--analysis", self.analysis != Analysis::None),
            ("--strain", self.strain.is_some()),
            ("--geometry-only", self.geometry_only),
            ("--periodic-equations", self.periodic_equations),
            ("--reduced-integration", self.reduced_integration),
        ];
        for (flag, _) in deck.into_iter().filter(|(_, given)| *given && !writes_deck) {
            stderr::line(format!("warning: {flag} has no effect: no .inp is written"));
        }
        for (key, _, of) in self.table().foreign() {
            let of = format!("{of:?}").to_lowercase();
            does_nothing(&flag(key), &format!("the method {of}"));
        }
        let voxels = self.method == MethodName::Voxel;
        let analysis = if self.geometry_only { Analysis::None } else { self.analysis };
        let explicit = matches!(analysis, Analysis::Compression | Analysis::Tension);
        let usual = Loading::default();
        for (flag, given, used, of) in [
            ("--reduced-integration", self.reduced_integration, voxels || !writes_deck, "the method voxel"),
            (
                "--analysis",
                self.analysis != Analysis::None,
                analysis == self.analysis || !writes_deck,
                "decks that hold more than geometry",
            ),
            ("--strain", self.strain.is_some(), analysis != Analysis::None || !writes_deck, "an --analysis"),
            (
                "--friction",
                self.friction != usual.friction,
                analysis == Analysis::Compression,
                "--analysis compression",
            ),
            ("--frames", self.frames != usual.frames, explicit, "--analysis compression and tension"),
        ] {
            if given && !used {
                does_nothing(flag, of);
            }
        }
    }

    /// The files that are read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.materials.iter().map(PathBuf::as_path)
    }

    /// Refuses options that `specimen` cannot be meshed with, and a missing gmsh, before the specimen is packed.
    pub(super) fn check(&self, specimen: &Specimen) -> Result<(), Failure> {
        self.options()?.validate(specimen).map_err(|error| wrong_mesh(&error))?;
        if self.method == MethodName::Conforming {
            Gmsh::program(&self.gmsh).check().map_err(|error| wrong_mesh(&error))?;
        }
        Ok(())
    }

    /// Where a conforming mesh is wanted and no gaps are asked for, asks for those it needs; whether it did.
    pub(super) fn leave_room(&self, placement: &mut Placement) -> bool {
        let mut wanted = false;
        for gap in [&mut placement.min_gap_mm, &mut placement.wall_gap_mm] {
            if self.method == MethodName::Conforming && *gap == 0.0 {
                (*gap, wanted) = (ROOM_MM, true);
            }
        }
        wanted
    }

    /// Meshes; options that cannot be are wrong usage.
    pub(super) fn build(&self, model: &Model, quiet: bool) -> Result<Mesh, Failure> {
        let gmsh = Gmsh::program(&self.gmsh);
        let run = |surfaces: &Surfaces| {
            if let Some(size) = surfaces.again_mm().filter(|_| !quiet) {
                stderr::line(format!("gmsh's mesh cannot be used; asking it again, for elements of {size:.3} mm"));
            }
            gmsh.fill(surfaces)
        };
        mesh::build_with(model, &self.options()?, &run).map_err(|error| wrong_mesh(&error))
    }
}

fn wrong_mesh(error: &MeshError) -> Failure {
    match error {
        MeshError::Option { key, value, accepted } => Failure::Usage(format!("{} is {value}; {accepted}", flag(key))),
        MeshError::MissingGmsh { .. } => {
            Failure::Run(format!("{error} and put it on the PATH or name it with --gmsh, or take --method lattice"))
        }
        MeshError::NearTouching { .. } => {
            Failure::Run(format!("{error}; `mesocrete pack --method conforming` leaves such gaps by itself"))
        }
        _ => Failure::Run(error.to_string()),
    }
}

/// What a deck cannot hold is wrong usage.
pub(super) fn wrong_deck(error: &DeckError) -> Failure {
    Failure::Usage(format!("{} {}", flag(error.key()), error.fault()))
}

/// The core speaks of `element_size_mm`, the user typed `--element-size-mm`; values of `[materials]` have no flag.
fn flag(key: &str) -> String {
    if key.contains('.') { key.to_owned() } else { format!("--{}", key.replace('_', "-")) }
}

fn does_nothing(flag: &str, of: &str) {
    stderr::line(format!("warning: {flag} is only for {of}, and does nothing here"));
}

/// A file that holds material values.
#[derive(Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
struct MaterialsFile {
    materials: Materials,
}

fn materials(path: Option<&Path>) -> Result<Materials, Failure> {
    let Some(path) = path else { return Ok(Materials::default()) };
    inputs::toml(path, options_from_toml).map(|file: MaterialsFile| file.materials)
}
