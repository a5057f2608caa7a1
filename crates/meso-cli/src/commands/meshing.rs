//! The flags of a mesh and its deck, the same for `pack` and `mesh`, and the mesh they ask for.

use super::{names, values};
use crate::failure::Failure;
use crate::progress::Watch;
use crate::{inputs, stderr};
use meso_concrete::OutOfRange;
use meso_core::aggregate::Itz;
use meso_core::export::abaqus::{Analysis, DeckOptions, Loading};
use meso_core::materials::Materials;
use meso_core::mesh::conforming::Surfaces;
use meso_core::mesh::{
    self, Fit, ItzForm, Joined, Mesh, MeshError, MeshOptions, MeshTable, MethodName, NarrowGaps, PhaseOff, Tools,
    VolumeMesher, Volumes,
};
use meso_core::spec::options_from_toml;
use meso_core::specimen::Specimen;
use meso_core::{Model, Spec};
use meso_gmsh::Gmsh;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Names that other programs give `--element-size-mm`, and that clap would take for `--itz` and `--help`.
pub(super) const SIZE: [&str; 4] = ["element-size", "size", "mesh-size", "h"];

#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Meshes and decks")]
pub(super) struct Meshing {
    #[arg(long, value_parser = names::parse::<MethodName>)]
    #[arg(help = format!("Method of meshing: {} [default: voxel; with an analysis lattice]", names::list::<MethodName>()))]
    method: Option<MethodName>,
    /// Edge length of the elements, mm
    #[arg(long, value_name = "H", default_value_t = MeshOptions::default().element_size_mm, value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = SIZE)]
    element_size_mm: f64,
    #[arg(long, value_parser = names::parse::<ItzForm>)]
    #[arg(help = format!("Interfacial transition zone in the mesh: {} [default: solid, or none where the elements are thicker than it; with an analysis smeared]", names::list::<ItzForm>()))]
    itz: Option<ItzForm>,
    /// The thickness that the spec gives it.
    #[arg(skip)]
    thickness: OnceLock<Itz>,
    #[arg(long, value_parser = names::parse::<Joined>)]
    #[arg(help = format!("Treatment of aggregates that would share nodes: {} [default: keep; with an analysis mortar]", names::list::<Joined>()))]
    joined: Option<Joined>,
    #[arg(long, value_parser = names::parse::<Volumes>)]
    #[arg(help = format!("Volume of the aggregates in a fitted lattice: {} [default: fitted; with an analysis exact]", names::list::<Volumes>()))]
    volumes: Option<Volumes>,
    #[arg(long, value_name = "GAPS", value_parser = names::parse::<NarrowGaps>)]
    #[arg(help = format!("Gaps one tetrahedron wide between aggregates: {} [default: keep; with an analysis split]", names::list::<NarrowGaps>()))]
    narrow_gaps: Option<NarrowGaps>,
    #[arg(long, default_value = "fitted", value_parser = names::parse::<Fit>)]
    #[arg(help = format!("Fit of a lattice to the aggregates' surfaces: {}", names::list::<Fit>()))]
    fit: Fit,
    /// 2 puts a node in the middle of every edge of a tetrahedron (C3D10); lattice and conforming
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = values::whole_number)]
    #[arg(allow_negative_numbers = true)]
    order: u32,
    /// Let the ITZ be thinner than one voxel, with holes in it
    #[arg(long)]
    thin_itz: bool,
    /// Sub-samples per voxel and axis, 1 to 8; with more than 1 each body gets as many voxels as its samples fill
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = values::whole_number)]
    #[arg(allow_negative_numbers = true)]
    subsamples: u32,
    /// Accept a phase more than 10 % off its exact volume, which is an error otherwise
    #[arg(long)]
    accept_phase_error: bool,
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
    #[arg(help = format!("Analysis of the deck: {}", names::list::<Analysis>()))]
    analysis: Analysis,
    /// Mean axial strain at the end of the analysis [default: 0.001 elastic and tension, 0.006 compression]
    #[arg(long, value_name = "E", value_parser = values::number, allow_negative_numbers = true)]
    strain: Option<f64>,
    /// Friction between plates and specimen in compression
    #[arg(long, value_name = "MU", default_value_t = Loading::default().friction, value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    friction: f64,
    /// Length of the step in compression and tension, s
    #[arg(long, value_name = "S", default_value_t = Loading::default().duration_s, value_parser = values::number)]
    #[arg(allow_negative_numbers = true)]
    duration: f64,
    #[arg(long, value_name = "S", value_parser = values::number, allow_negative_numbers = true)]
    #[arg(help = format!("Time increment that mass scaling keeps in compression and tension, s [default: {:e}]", Loading::default().time_increment_s))]
    time_increment: Option<f64>,
    /// Frames of field output in compression and tension
    #[arg(long, value_name = "N", default_value_t = Loading::default().frames, value_parser = values::count)]
    #[arg(allow_negative_numbers = true)]
    frames: u32,
    /// Strength and damage of mortar and ITZ in a deck without an analysis, for steps of your own
    #[arg(long)]
    with_damage: bool,
    /// A TOML file with a [materials] table; values it leaves out keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// Number of parts that gmsh fills one by one; absent: as many as its memory needs
    #[arg(long, value_name = "N", value_parser = values::whole_number, allow_negative_numbers = true)]
    slabs: Option<u32>,
    /// The program gmsh, for --method conforming
    #[arg(long, value_name = "PROGRAM", default_value = "gmsh")]
    gmsh: PathBuf,
}

impl Meshing {
    /// The options as typed, those of other methods included.
    fn table(&self) -> MeshTable {
        let usual = self.usual();
        MeshTable {
            method: self.method(),
            element_size_mm: self.element_size_mm,
            itz: self.itz.or(usual.itz),
            thin_itz: self.thin_itz,
            subsamples: self.subsamples,
            fit: self.fit,
            order: self.order,
            joined: self.joined.unwrap_or(usual.joined),
            volumes: self.volumes.unwrap_or(usual.volumes),
            narrow_gaps: self.narrow_gaps.unwrap_or(usual.narrow_gaps),
            slabs: self.slabs,
        }
        .with_itz_for(self.thickness.get().unwrap_or(&Itz::default()))
    }

    /// Choices that no flag makes.
    fn usual(&self) -> MeshTable {
        if self.analyses() { MeshTable::of_a_test() } else { MeshTable::default() }
    }

    /// Whether the deck computes something: then what is not asked for is what a mechanician would choose.
    fn analyses(&self) -> bool {
        self.analysis != Analysis::None && !self.geometry_only
    }

    /// Whether a deck is of a test with a curve.
    pub(super) fn has_curve(&self) -> bool {
        self.analysis.is_explicit() && !self.geometry_only
    }

    fn method(&self) -> MethodName {
        self.method.unwrap_or(self.usual().method)
    }

    fn itz(&self) -> ItzForm {
        self.table().itz.unwrap_or(ItzForm::Solid)
    }

    /// How to get the ITZ, where the mesh has none although nobody said so.
    pub(super) fn hint(&self, spec: &Spec) -> Option<String> {
        let [low, high] = spec.itz.thickness_mm;
        (self.itz.is_none() && self.itz() == ItzForm::None && high > 0.0).then(|| {
            format!(
                "the mesh has no ITZ: shells of {low} to {high} mm are thinner than its elements; --itz cohesive or --method \
                 lattice shows them"
            )
        })
    }

    /// The options; flags of other methods were named by [`warn_unused`](Self::warn_unused), and do nothing.
    pub(super) fn options(&self) -> Result<MeshOptions, Failure> {
        let table = self.table();
        let options = table.validate_ranges().and_then(|()| table.without_foreign().try_into());
        options.map_err(|error| wrong_mesh(&error))
    }

    /// Contents of a deck; options that a mesh of the specimen cannot carry are wrong usage.
    pub(super) fn deck(&self, spec: &Spec) -> Result<DeckOptions, Failure> {
        self.thickness.get_or_init(|| spec.itz);
        let deck = DeckOptions {
            analysis: self.analysis,
            strain: self.strain,
            loading: self.loading(),
            with_damage: self.with_damage,
            materials: materials(self.materials.as_deref())?,
            geometry_only: self.geometry_only,
            reduced_integration: self.reduced_integration,
            periodic_equations: self.periodic_equations,
            section_mm2: Some(spec.specimen.volume() / spec.specimen.aabb().size().z),
            allow_joined: self.joined == Some(Joined::Keep),
            heading: heading(spec, &self.command()),
        };
        deck.validate_for(spec.specimen.periodic().0).map_err(|error| wrong_deck(&error))?;
        if self.itz() == ItzForm::Cohesive {
            deck.validate_cohesive().map_err(|error| wrong_deck(&error))?;
        }
        Ok(deck)
    }

    fn loading(&self) -> Loading {
        Loading {
            friction: self.friction,
            duration_s: self.duration,
            time_increment_s: self.time_increment.unwrap_or(Loading::default().time_increment_s),
            frames: self.frames,
        }
    }

    /// Warns of flags without effect: those of decks where none is written, those of another method or analysis.
    pub(super) fn warn_unused(&self, writes_deck: bool) {
        let deck = [
            ("--analysis", self.analysis != Analysis::None),
            ("--strain", self.strain.is_some()),
            ("--geometry-only", self.geometry_only),
            ("--periodic-equations", self.periodic_equations),
            ("--reduced-integration", self.reduced_integration),
            ("--with-damage", self.with_damage),
        ];
        for (flag, _) in deck.into_iter().filter(|(_, given)| *given && !writes_deck) {
            stderr::line(format!("warning: {flag} has no effect: no .inp is written"));
        }
        for (key, _, of) in self.table().foreign() {
            let of = format!("{of:?}").to_lowercase();
            does_nothing(&flag(key), &format!("the method {of}"));
        }
        let voxels = self.method() == MethodName::Voxel;
        let analysis = if self.geometry_only { Analysis::None } else { self.analysis };
        let explicit = analysis.is_explicit();
        let usual = Loading::default();
        for (flag, given, used, of) in [
            ("--volumes", self.volumes == Some(Volumes::Exact), !voxels, "the methods lattice and conforming"),
            (
                "--narrow-gaps",
                self.narrow_gaps == Some(NarrowGaps::Split),
                !voxels,
                "the methods lattice and conforming",
            ),
            ("--joined", self.joined.is_some(), self.itz() != ItzForm::Cohesive, "an --itz that is not cohesive"),
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
            ("--duration", self.duration != usual.duration_s, explicit, "--analysis compression and tension"),
            ("--time-increment", self.time_increment.is_some(), explicit, "--analysis compression and tension"),
            (
                "--with-damage",
                self.with_damage,
                !self.geometry_only || !writes_deck,
                "decks that hold more than geometry",
            ),
        ] {
            if given && !used {
                does_nothing(flag, of);
            }
        }
    }

    /// The command that gives the same deck again, whatever it was typed as: files and threads change nothing.
    fn command(&self) -> String {
        let (mesh, loading) = (self.table().without_foreign(), self.loading());
        let mut words = vec![format!(
            "mesocrete mesh MODEL --method {} --element-size-mm {} --itz {} --joined {} --volumes {} --narrow-gaps {}",
            name(mesh.method),
            mesh.element_size_mm,
            name(self.itz()),
            name(mesh.joined),
            name(mesh.volumes),
            name(mesh.narrow_gaps),
        )];
        let flags = [
            ("--fit plain", mesh.fit == Fit::Plain),
            ("--order 2", mesh.order == 2),
            ("--thin-itz", mesh.thin_itz),
            ("--reduced-integration", self.reduced_integration),
            ("--geometry-only", self.geometry_only),
            ("--periodic-equations", self.periodic_equations),
            ("--with-damage", self.with_damage),
            ("--accept-phase-error", self.accept_phase_error),
        ];
        words.extend(flags.into_iter().filter(|(_, given)| *given).map(|(flag, _)| flag.to_owned()));
        if mesh.subsamples > 1 {
            words.push(format!("--subsamples {}", mesh.subsamples));
        }
        words.extend(mesh.slabs.map(|slabs| format!("--slabs {slabs}")));
        if self.analyses() {
            words.push(format!("--analysis {}", name(self.analysis)));
            words.extend(self.strain.map(|strain| format!("--strain {strain}")));
        }
        if self.analysis.is_explicit() {
            let Loading { friction, duration_s, time_increment_s, frames } = loading;
            words
                .push(format!("--friction {friction} --duration {duration_s:?} --time-increment {time_increment_s:?}"));
            words.push(format!("--frames {frames}"));
        }
        words.extend(self.materials.as_ref().map(|_| "--materials FILE".to_owned()));
        words.join(" ")
    }

    /// The files that are read.
    pub(super) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.materials.iter().map(PathBuf::as_path)
    }

    /// Refuses what no mesh of a packing of `spec` can have, as far as no file says it; it looks for no gmsh.
    pub(super) fn validate(&self, spec: &Spec) -> Result<(), Failure> {
        if self.materials.is_none() {
            self.deck(spec)?;
        }
        self.options()?.validate(&spec.specimen).map_err(|error| wrong_mesh(&error))
    }

    /// Refuses options that `specimen` cannot be meshed with, and a missing gmsh, before the specimen is packed.
    pub(super) fn check(&self, specimen: &Specimen) -> Result<(), Failure> {
        check(&self.options()?, &self.gmsh, specimen)
    }

    /// Where no gaps are asked for, asks for those that the mesh needs; what was asked for, in words.
    ///
    /// A conforming mesh needs some, else its facets touch. An analysis needs aggregates that share no nodes: half an element
    /// shows most gaps, less where the packing would get too dense for it.
    pub(super) fn leave_room(&self, spec: &mut Spec) -> Option<String> {
        if self.method() == MethodName::Conforming {
            let (advised, mut wanted) = (MeshError::ADVISED_GAP_MM, false);
            for gap in [&mut spec.placement.min_gap_mm, &mut spec.placement.wall_gap_mm] {
                (*gap, wanted) = if *gap == 0.0 { (advised, true) } else { (*gap, wanted) };
            }
            return wanted.then(|| format!("packing with gaps of {advised} mm, which a conforming mesh needs"));
        }
        if !self.analyses() || spec.placement.min_gap_mm > 0.0 {
            return None;
        }
        let gap = widest_gap(spec, self.element_size_mm / 2.0)?;
        spec.placement.min_gap_mm = gap;
        Some(format!("packing with gaps of {gap} mm between aggregates, so that the elements can show mortar there"))
    }

    /// Meshes, and finds the phase that is farthest off its exact volume; options that cannot be are wrong usage.
    pub(super) fn build(&self, model: &Model, quiet: bool, watch: &Watch) -> Result<(Mesh, Option<PhaseOff>), Failure> {
        let accepted = if self.accept_phase_error { f64::INFINITY } else { PhaseOff::ACCEPTED };
        let options = self.options()?;
        let mesh = build(model, &options, &self.gmsh, quiet, watch)?;
        let off = PhaseOff::accept(&mesh, model, &options, accepted).map_err(|error| wrong_mesh(&error))?;
        Ok((mesh, off))
    }
}

/// Refuses what `specimen` cannot be meshed with, and a gmsh that is not there.
pub(super) fn check(options: &MeshOptions, gmsh: &Path, specimen: &Specimen) -> Result<(), Failure> {
    options.validate(specimen).map_err(|error| wrong_mesh(&error))?;
    if options.method.name() == MethodName::Conforming {
        Gmsh::program(gmsh).check().map_err(|error| wrong_mesh(&error))?;
    }
    Ok(())
}

/// Meshes, with the program `gmsh` where it is needed; options that cannot be are wrong usage.
pub(super) fn build(
    model: &Model,
    options: &MeshOptions,
    gmsh: &Path,
    quiet: bool,
    watch: &Watch,
) -> Result<Mesh, Failure> {
    let gmsh = Announced { gmsh: Gmsh::program(gmsh), quiet };
    mesh::build(model, options, &Tools { gmsh: &gmsh, watch }).map_err(|error| wrong_mesh(&error))
}

/// gmsh, whose second attempts the user hears of.
struct Announced {
    gmsh: Gmsh,
    quiet: bool,
}

impl VolumeMesher for Announced {
    fn fill(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        if let Some(size) = surfaces.again_mm().filter(|_| !self.quiet) {
            stderr::line(format!("gmsh's mesh cannot be used; running it again with elements of {size:.3} mm"));
        }
        self.gmsh.fill(surfaces)
    }
}

/// Turns an error of meshing into a failure; wrong options are wrong usage.
pub(super) fn wrong_mesh(error: &MeshError) -> Failure {
    let text = error.message(flag);
    match error {
        MeshError::Option(wrong) => Failure::Usage(format!("{} {}", flag(&wrong.key), wrong.fault())),
        MeshError::MissingGmsh { .. } => {
            Failure::Run(format!("{text} and put it on the PATH or name it with --gmsh, or take --method lattice"))
        }
        MeshError::PhaseError { .. } => Failure::Run(format!("{text}; --accept-phase-error accepts it")),
        MeshError::NearTouching { .. } => {
            Failure::Run(format!("{text}; `mesocrete pack --method conforming` leaves such gaps by itself"))
        }
        _ => Failure::Run(text),
    }
}

/// A packing with gaps costs little time up to this share of what its strategy reaches (at 50 % of the paper's specimen
/// gaps of 0.5 mm take 3 CPU s, of 0.75 mm 34 CPU s, and of 1 mm are not reached).
const EASY: f64 = 0.9;

/// The widest gap, halved from `most` as often as it takes, with which `spec` is packed easily; none where an eighth is too much.
fn widest_gap(spec: &Spec, most: f64) -> Option<f64> {
    [1.0, 0.5, 0.25, 0.125].into_iter().map(|share| share * most).find(|gap| {
        let mut with_gap = spec.clone();
        with_gap.placement.min_gap_mm = *gap;
        with_gap.crowding() <= EASY * with_gap.reach()
    })
}

/// Characters of a heading's line.
const LINE: usize = 76;

/// Which packing a deck is of, and the command that meshes it again.
fn heading(spec: &Spec, command: &str) -> Vec<String> {
    let packing = format!("packing: seed {}, fraction {} of a {}", spec.seed, spec.fraction, spec.specimen.kind());
    let mut lines = vec![packing];
    let mut line = String::from("command:");
    for word in command.split(' ') {
        if line.len() + 1 + word.len() > LINE {
            lines.push(std::mem::replace(&mut line, String::from("  ")));
        }
        line = line + " " + word;
    }
    lines.push(line);
    lines
}

/// The name that an option's value has on the command line.
fn name(value: impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Turns an error of a deck into wrong usage.
pub(super) fn wrong_deck(error: &OutOfRange) -> Failure {
    Failure::Usage(format!("{} {}", flag(&error.key), error.fault()))
}

/// The core speaks of `element_size_mm`, the user typed `--element-size-mm`; values of `[materials]` have no flag. Of a key that
/// ends in its unit, seconds, the flag has only the name.
pub(super) fn flag(key: &str) -> String {
    if key.contains('.') {
        return key.to_owned();
    }
    format!("--{}", key.strip_suffix("_s").unwrap_or(key).replace('_', "-"))
}

fn does_nothing(flag: &str, of: &str) {
    stderr::line(format!("warning: {flag} is only for {of}, and has no effect here"));
}

/// A file that holds material values.
#[derive(Default, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
struct MaterialsFile {
    materials: Materials,
}

/// The materials of a file, or the usual ones.
pub(super) fn materials(path: Option<&Path>) -> Result<Materials, Failure> {
    let Some(path) = path else { return Ok(Materials::default()) };
    inputs::toml(path, options_from_toml).map(|file: MaterialsFile| file.materials)
}
