//! Flags of a mesh and of its deck, as users type them.

use super::errors::wrong_mesh;
use crate::commands::names;
use crate::commands::test_file::FileOr;
use crate::commands::{test_file, values};
use crate::failure::Failure;
use clap::builder::TypedValueParser;
use meso_core::export::abaqus::{Analysis, DeckOptions, Plain};
use meso_core::export::lsdyna::LsdynaLaw;
use meso_core::mesh::{Fit, ItzForm, Joined, MeshTable, MethodName, NarrowGaps, Purpose, Volumes};
use meso_core::{Spec, Watch};
use meso_solve::{Test, TestKind, footing};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Names that other programs give `--element-size-mm`, and that clap would take for `--itz` and `--help`.
const SIZE: [&str; 4] = ["element-size", "size", "mesh-size", "h"];

/// A size of elements, as users type it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ElementSize {
    /// The largest that was tried and keeps the phases.
    Auto,
    Mm(f64),
}

fn element_size(text: &str) -> Result<ElementSize, String> {
    match text {
        "auto" => Ok(ElementSize::Auto),
        number => values::number(number).map(ElementSize::Mm).map_err(|error| format!("{error}, or auto")),
    }
}

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Mesh and materials")]
pub(crate) struct MeshFlags {
    /// Method of meshing [default: voxel; for a test lattice]
    #[arg(long, value_parser = names::parser::<MethodName>())]
    method: Option<MethodName>,
    /// Edge length of the elements, mm, or auto: the largest of some sizes that keeps every phase within 5 % on a small cube
    /// of the packing [default: 2; for a test without a model 4]
    #[arg(long, value_name = "H|auto", value_parser = element_size, allow_negative_numbers = true, aliases = SIZE)]
    element_size_mm: Option<ElementSize>,
    /// The size that `auto` means for the packing at hand, mm.
    #[arg(skip)]
    tried: OnceLock<f64>,
    /// Accept a phase more than 10 % off its exact volume, which is an error otherwise; results carry a flag then
    #[arg(long, hide_short_help = true)]
    pub(super) accept_phase_error: bool,
    /// Interfacial transition zone in the mesh [default: solid, or none where the elements are thicker than it; for a
    /// test smeared]
    #[arg(long, value_parser = names::parser::<ItzForm>())]
    itz: Option<ItzForm>,
    /// Treatment of aggregates that would share nodes [default: keep; for a test mortar]
    #[arg(long, value_parser = names::parser::<Joined>())]
    #[arg(hide_short_help = true)]
    joined: Option<Joined>,
    /// Volume of the aggregates in a mesh that follows them [default: exact for grains other than convex polyhedra, and for a
    /// test without a solid ITZ; else fitted]
    #[arg(long, value_parser = names::parser::<Volumes>())]
    #[arg(hide_short_help = true)]
    volumes: Option<Volumes>,
    /// Gaps one tetrahedron wide between aggregates [default: keep; for a test of a model split]
    #[arg(long, value_name = "GAPS", value_parser = names::parser::<NarrowGaps>())]
    #[arg(hide_short_help = true)]
    narrow_gaps: Option<NarrowGaps>,
    /// Fit of a lattice to the aggregates' surfaces [default: fitted]
    #[arg(long, value_parser = names::parser::<Fit>())]
    #[arg(hide_short_help = true)]
    fit: Option<Fit>,
    /// Order of the elements [default: 1]; 2 puts a node in the middle of every edge of a tetrahedron (C3D10)
    #[arg(long, value_name = "N", value_parser = values::whole_number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    order: Option<u32>,
    /// Let the ITZ be thinner than one voxel, with holes in it
    #[arg(long, hide_short_help = true)]
    thin_itz: bool,
    /// Sub-samples per voxel and axis, 1 to 8 [default: 1]; with more than 1 each body gets as many voxels as its samples fill
    #[arg(long, value_name = "N", value_parser = values::whole_number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    subsamples: Option<u32>,
    /// Number of slabs that gmsh fills one by one; absent: as many as its memory needs
    #[arg(long, value_name = "N", value_parser = values::whole_number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    slabs: Option<u32>,
    /// A TOML file with a [materials] table; absent values keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    pub(super) materials: Option<PathBuf>,
    /// The program gmsh, for --method conforming
    #[arg(long, value_name = "PROGRAM", default_value = "gmsh")]
    #[arg(hide_short_help = true)]
    pub(super) gmsh: PathBuf,
}

impl MeshFlags {
    /// The options that are given.
    pub(super) fn table(&self) -> MeshTable {
        MeshTable {
            method: self.method,
            element_size_mm: match self.element_size_mm {
                Some(ElementSize::Mm(size)) => Some(size),
                Some(ElementSize::Auto) => self.tried.get().copied(),
                None => None,
            },
            itz: self.itz,
            joined: self.joined,
            volumes: self.volumes,
            narrow_gaps: self.narrow_gaps,
            thin_itz: self.thin_itz.then_some(true),
            subsamples: self.subsamples,
            fit: self.fit,
            order: self.order,
            slabs: self.slabs,
        }
    }

    /// Finds the size that `auto` means for `spec`. `leaves_room` says that it is still to be packed, with the gaps that the
    /// mesh needs.
    pub(crate) fn try_sizes(
        &self,
        purpose: Purpose,
        spec: &Spec,
        leaves_room: bool,
        watch: &dyn Watch,
    ) -> Result<(), Failure> {
        if self.element_size_mm == Some(ElementSize::Auto) && self.tried.get().is_none() {
            let found = footing::element_size(&self.table(), purpose, spec, leaves_room, watch);
            let size = found.map_err(|error| wrong_mesh(&error))?;
            self.tried.get_or_init(|| size);
        }
        Ok(())
    }

    /// Whether a size of elements is given.
    pub(crate) fn has_size(&self) -> bool {
        self.element_size_mm.is_some()
    }

    /// Whether a file has the materials.
    pub(crate) fn has_materials(&self) -> bool {
        self.materials.is_some()
    }

    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.materials.iter().map(PathBuf::as_path)
    }
}

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Decks")]
pub(crate) struct DeckFlags {
    /// Hexahedra with reduced integration (C3D8R)
    #[arg(long, hide_short_help = true)]
    pub(super) reduced_integration: bool,
    /// Only nodes, elements, sets and surfaces, for *INCLUDE
    #[arg(long)]
    pub(super) geometry_only: bool,
    /// Tie opposite faces of a periodic box by *EQUATION; REF_X, REF_Y and REF_Z take the mean strain
    #[arg(long, hide_short_help = true)]
    pub(super) periodic_equations: bool,
    #[arg(long, value_name = "NAME|TEST.toml", default_value = "none", value_parser = analysis_parser())]
    #[arg(help = format!(
        "Analysis of the deck; any but none meshes, and packs, for a test: {}, or a test: {}, or a TEST.toml",
        names::list::<Plain>(),
        names::list::<TestKind>()
    ))]
    pub(super) analysis: AnalysisText,
    /// Strain at the end of the analysis [default: the test's own, 0.001 elastic]
    #[arg(long, value_name = "E", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    strain: Option<f64>,
    /// Friction between plates and specimen [default: the test's own, 0.1 in an impact]
    #[arg(long, value_name = "MU", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    friction: Option<f64>,
    /// Time of the path, s [default: the test's own, as in `solve`; 0.02 in an impact]
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    duration: Option<f64>,
    /// Time increment that mass scaling keeps, s [default: the test's own, as in `solve`]
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    time_increment: Option<f64>,
    /// Frames of field output [default: 50]
    #[arg(long, value_name = "N", value_parser = values::count, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    frames: Option<u32>,
    /// Speed of the striker in an impact, mm/s [default: 5000]
    #[arg(long, value_name = "MM_S", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(hide_short_help = true)]
    impact_speed: Option<f64>,
    /// Law of mortar and ITZ in a .k
    #[arg(long, value_name = "LAW", default_value = "cdpm", value_parser = names::parser::<LsdynaLaw>())]
    #[arg(hide_short_help = true)]
    pub(super) lsdyna_law: LsdynaLaw,
    /// Strength and damage of mortar and ITZ in a deck without an analysis, for steps of your own
    #[arg(long, hide_short_help = true)]
    pub(super) with_damage: bool,
}

/// An analysis as users type it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum AnalysisText {
    Named(Analysis),
    /// A file, and its test once it was read.
    File(PathBuf, Box<OnceLock<Test>>),
}

/// Parser of an analysis.
fn analysis_parser() -> impl TypedValueParser<Value = AnalysisText> {
    let read = |name: &str| {
        let plain = names::read(name).map(|plain: Plain| plain.into());
        plain.or_else(|_| names::read(name).map(|kind: TestKind| kind.into())).map(AnalysisText::Named)
    };
    let name = names::parser_of([names::all::<Plain>(), names::all::<TestKind>()].concat(), read);
    FileOr { file: |path| AnalysisText::File(path, Box::default()), name }
}

impl DeckFlags {
    /// The analysis of the deck; a file is read once.
    fn analysis(&self) -> Result<Analysis, Failure> {
        Ok(match &self.analysis {
            AnalysisText::Named(analysis) => analysis.clone(),
            AnalysisText::File(path, read) => match read.get() {
                Some(test) => test.clone().into(),
                None => test_file::of_deck(path).map(|test| read.get_or_init(|| test).clone())?.into(),
            },
        })
    }

    /// Contents of the deck as far as flags say them.
    pub(super) fn options(&self) -> Result<DeckOptions, Failure> {
        Ok(DeckOptions {
            analysis: self.analysis()?,
            strain: self.strain,
            friction: self.friction,
            duration_s: self.duration,
            time_increment_s: self.time_increment,
            frames: self.frames,
            impact_speed_mm_per_s: self.impact_speed,
            with_damage: self.with_damage,
            geometry_only: self.geometry_only,
            reduced_integration: self.reduced_integration,
            periodic_equations: self.periodic_equations,
            lsdyna_law: self.lsdyna_law,
            ..DeckOptions::default()
        })
    }

    /// The file of a test.
    pub(super) fn file(&self) -> Option<&Path> {
        if let AnalysisText::File(path, _) = &self.analysis { Some(path) } else { None }
    }

    /// Whether the deck computes something, by its own step or by one that is added to it.
    pub(super) fn analyses(&self) -> bool {
        (self.analysis != AnalysisText::Named(Analysis::None) || self.with_damage) && !self.geometry_only
    }

    /// The first flag that only a deck has. An analysis also decides mesh and packing, a time increment the figures.
    pub(super) fn only_for_decks(&self) -> Option<&'static str> {
        let all = [
            ("--reduced-integration", self.reduced_integration),
            ("--geometry-only", self.geometry_only),
            ("--periodic-equations", self.periodic_equations),
            ("--strain", self.strain.is_some()),
            ("--friction", self.friction.is_some()),
            ("--duration", self.duration.is_some()),
            ("--frames", self.frames.is_some()),
            ("--impact-speed", self.impact_speed.is_some()),
            ("--lsdyna-law", self.lsdyna_law != LsdynaLaw::default()),
            ("--with-damage", self.with_damage),
        ];
        all.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag)
    }
}
