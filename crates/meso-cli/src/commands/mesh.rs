//! `mesocrete mesh`: a saved model as finite elements.

use super::{names, values};
use crate::failure::Failure;
use crate::gmsh::Gmsh;
use crate::outputs::{self, Target, Unit};
use crate::{inputs, say, threads};
use meso_core::Model;
use meso_core::export::abaqus::{Analysis, DeckOptions, Loading};
use meso_core::export::vtk::Encoding;
use meso_core::formats::{MeshFormat, piece_path};
use meso_core::materials::Materials;
use meso_core::mesh::{
    self, CellKind, Fit, InterfaceDistance, ItzForm, Mesh, MeshError, MeshOptions, Method, PhaseVolumes, quality,
};
use std::io::Write;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json); `-` is standard input
    model: PathBuf,
    /// File to write, its format by the extension: .inp, .vtu, .pvtu (pieces beside it), .msh; `-` is standard output (.inp). May be repeated
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    #[arg(long, default_value = "voxel", value_parser = names::parse::<Method>)]
    #[arg(help = format!("How the specimen is divided: {}", names::list::<Method>()))]
    method: Method,
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
    #[arg(long, value_name = "N", default_value_t = 1)]
    order: u32,
    /// Let the ITZ be thinner than one voxel, with holes in it
    #[arg(long)]
    thin_itz: bool,
    /// Sub-samples per voxel and axis, 1 to 8; more than 1 takes the majority
    #[arg(long, value_name = "N", default_value_t = 1)]
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
    #[arg(long, value_name = "E", value_parser = values::number)]
    strain: Option<f64>,
    /// Friction between plates and specimen in compression
    #[arg(long, value_name = "MU", default_value_t = Loading::default().friction, value_parser = values::number)]
    friction: f64,
    /// A TOML file with a [materials] table; values it leaves out keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// The program gmsh, for --method conforming
    #[arg(long, value_name = "PROGRAM", default_value = "gmsh")]
    gmsh: PathBuf,
    /// Number of threads; all cores when absent
    #[arg(long, value_name = "N", value_parser = values::threads)]
    threads: Option<u16>,
    /// Compress what a .vtu holds (zlib)
    #[arg(long)]
    compress: bool,
    /// Replace files that are there already
    #[arg(short, long)]
    force: bool,
    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let plan = args.output.iter().map(|path| plan(path, args.force)).collect::<Result<Vec<_>, _>>()?;
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.model])?;
    let materials = materials(args.materials.as_deref())?;
    let model = inputs::model(&args.model)?;
    let mesh = threads::with(args.threads, || build(&model, &args.options(), &args.gmsh))??;
    let deck = args.deck(materials);
    if plan.iter().any(|(_, format)| *format == MeshFormat::Inp) {
        deck.validate(&mesh).map_err(|error| Failure::Usage(flag_names(&error.to_string())))?;
    }
    let encoding = Encoding::compressed(args.compress);
    let mut unit = Unit::default();
    for (target, format) in &plan {
        fill(&mut unit, target, args.force, *format, &mesh, &deck, encoding)?;
    }
    unit.commit()?;
    if !args.quiet {
        describe(&mesh, &model);
        plan.iter()
            .filter_map(|(target, _)| target.file())
            .for_each(|path| say::line(format!("wrote {}", path.display())));
    }
    Ok(0)
}

impl Args {
    fn options(&self) -> MeshOptions {
        MeshOptions {
            method: self.method,
            element_size_mm: self.element_size_mm,
            itz: self.itz,
            thin_itz: self.thin_itz,
            subsamples: self.subsamples,
            fit: self.fit,
            order: self.order,
        }
    }

    fn deck(&self, materials: Materials) -> DeckOptions {
        DeckOptions {
            analysis: self.analysis,
            strain: self.strain,
            loading: Loading { friction: self.friction, ..Loading::default() },
            materials,
            geometry_only: self.geometry_only,
            reduced_integration: self.reduced_integration,
            periodic_equations: self.periodic_equations,
            ..DeckOptions::default()
        }
    }
}

/// A file that holds material values.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialsFile {
    materials: Materials,
}

fn materials(path: Option<&Path>) -> Result<Materials, Failure> {
    let Some(path) = path else { return Ok(Materials::default()) };
    let text = std::fs::read_to_string(path).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    let file: MaterialsFile =
        toml::from_str(&text).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    Ok(file.materials)
}

fn plan(path: &Path, force: bool) -> Result<(Target, MeshFormat), Failure> {
    let format = if path == Path::new("-") { Some(MeshFormat::Inp) } else { MeshFormat::from_path(path) };
    let format = format.ok_or_else(|| {
        let known = MeshFormat::ALL.map(|format| format!(".{}", format.extension())).join(", ");
        let message = format!("{}: the extension names no mesh format; it must be one of {known}", path.display());
        Failure::Usage(message)
    })?;
    if format == MeshFormat::Pvtu {
        // Its number of pieces is not known yet, but that a first one would be in the way is.
        Target::new(&piece_path(path, 0), force)?;
    }
    Ok((Target::new(path, force)?, format))
}

/// Writes `mesh` to `target`, and its pieces beside it where the format has any.
pub(super) fn fill(
    unit: &mut Unit,
    target: &Target,
    force: bool,
    format: MeshFormat,
    mesh: &Mesh,
    deck: &DeckOptions,
    encoding: Encoding,
) -> Result<(), Failure> {
    let path = target.file().unwrap_or(Path::new("-"));
    for file in format.files(path, mesh) {
        let write = |out: &mut dyn Write| file.write(mesh, deck, encoding, out);
        match file.path == path {
            true => unit.fill(target, force, write)?,
            false => unit.fill(&Target::new(&file.path, force)?, force, write)?,
        }
    }
    Ok(())
}

/// Meshes; options that cannot be are wrong usage.
pub(super) fn build(model: &Model, options: &MeshOptions, gmsh: &Path) -> Result<Mesh, Failure> {
    let gmsh = Gmsh::program(gmsh);
    mesh::build_with(model, options, &|surfaces| gmsh.run(surfaces)).map_err(|error| match error {
        MeshError::Option { .. } => Failure::Usage(flag_names(&error.to_string())),
        _ => Failure::Run(error.to_string()),
    })
}

/// The core speaks of `mesh.element_size_mm`, the user typed `--element-size-mm`.
fn flag_names(message: &str) -> String {
    let rest = message.strip_prefix("mesh.").or(message.strip_prefix("deck."));
    match rest.and_then(|rest| rest.split_once(' ')) {
        Some((key, rest)) => format!("--{} {rest}", key.replace('_', "-")),
        None => message.to_owned(),
    }
}

/// Size of the mesh, and how its phases compare with the specimen.
pub(super) fn describe(mesh: &Mesh, model: &Model) {
    let volumes = PhaseVolumes::of_mesh(mesh);
    let share = |volume: f64| volume / model.spec.specimen.volume();
    let fibre = if volumes.fibre > 0.0 { format!(", fibre {:.4}", share(volumes.fibre)) } else { String::new() };
    say::line(format!(
        "meshed {} elements, {} nodes: aggregate {:.4}, ITZ {:.4}, mortar {:.4}{fibre} of the specimen",
        say::count(mesh.cell_count()),
        say::count(mesh.points.len()),
        share(volumes.aggregate),
        share(volumes.itz),
        share(volumes.mortar)
    ));
    let distance = InterfaceDistance::of(mesh, &model.bodies(), &model.spec.specimen);
    say::line(format!(
        "interface nodes lie {:.4} mm rms from the aggregates' surfaces, {:.4} mm at most",
        distance.rms_mm, distance.max_mm
    ));
    notes(mesh);
    if mesh.kind != CellKind::Hexahedron {
        angles(mesh);
    }
}

/// Cells below this are named, degrees.
const BAD_DEG: f64 = 8.0;
/// The first few of them.
const NAMED: usize = 5;

/// The worst dihedral angle, and the elements to look at.
fn angles(mesh: &Mesh) {
    let cells = quality::cells(mesh);
    let worst = cells.iter().fold(f64::INFINITY, |worst, cell| cell.min_dihedral_deg.min(worst));
    let bad = quality::bad_cells(&cells, BAD_DEG);
    let named: Vec<String> = bad.iter().take(NAMED).map(|cell| (cell + 1).to_string()).collect();
    let which = if bad.is_empty() { String::new() } else { format!(" (elements {}, ...)", named.join(", ")) };
    say::line(format!(
        "smallest dihedral angle {worst:.2} degrees; {} elements below {BAD_DEG}{which}",
        say::count(bad.len())
    ));
}

/// What the builder had to decide: gaps closed, layers thinned.
fn notes(mesh: &Mesh) {
    let notes = &mesh.notes;
    if notes.closed_gaps > 0 {
        say::line(format!(
            "closed {} places where {} pairs of aggregates come closer than the lattice can show (widest {:.2} mm); \
             a smaller --element-size-mm or a larger min_gap_mm keeps mortar there",
            say::count(notes.closed_gaps),
            say::count(notes.closed_gap_pairs),
            notes.widest_closed_gap_mm
        ));
    }
    if notes.off_surface_nodes > 0 {
        let nodes = say::count(notes.off_surface_nodes);
        say::line(format!(
            "{nodes} nodes could not be put on the surfaces with angles of 8 degrees, mostly in gaps to the specimen's sides"
        ));
    }
    if notes.thinned_itz_aggregates + notes.thinned_itz_nodes > 0 {
        say::line(format!(
            "the ITZ is thinner than asked in {} aggregates and at {} nodes; at {} of them it has no thickness",
            say::count(notes.thinned_itz_aggregates),
            say::count(notes.thinned_itz_nodes),
            say::count(notes.pinched_itz_nodes)
        ));
    }
    if notes.shifted_itz_nodes > 0 {
        let nodes = say::count(notes.shifted_itz_nodes);
        say::line(format!(
            "{nodes} inner nodes of the ITZ had to leave its exact thickness to keep angles from getting too sharp"
        ));
    }
}
