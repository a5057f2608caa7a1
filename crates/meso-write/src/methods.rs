//! A paragraph for the methods section of a paper, with the figures of one packing and the sources to cite.

use meso_concrete::aggregate::{ShapeKind, SizeDefinition};
use meso_concrete::specimen::Specimen;
use meso_concrete::{short, thousands};
use meso_mesh::materials::Materials;
use meso_mesh::{CellKind, Fit, Mesh, MeshOptions, Method, PhaseOff, PhaseVolumes};
use meso_pack::Spec;
use meso_pack::model::Model;
use meso_pack::packing::{LabelReport, OwnPhaseReport, PhaseReport, Report, StopReason};

/// The software and the paper behind its method, as a list of references.
const SOURCES: &str = "\
[1] The mesocrete developers. mesocrete: mesoscale concrete, packed without overlap. Version {version}.
[2] Rapid Generation of 3D Mesoscale Concrete Models Using an Improved GJK Algorithm for Collision Detection. Buildings
    2025, 15(21), 3883. doi:10.3390/buildings15213883";

/// Describes how `model` was made, and what `further` sentences add, in words that can be copied, and lists the sources.
pub fn paragraph(model: &Model, further: &[String]) -> String {
    let (report, spec) = (&model.report, &model.spec);
    let sentences = [
        format!(
            "The mesoscale model was generated with mesocrete {} [1], which implements and extends the method of [2].",
            report.version
        ),
        format!(
            "The specimen is a {} ({} mm3).",
            specimen(&spec.specimen, &report.specimen.kind),
            thousands(report.specimen.volume_mm3.round() as usize)
        ),
        origin(report).unwrap_or_else(|| shapes(spec)),
        format!("Sizes follow {}, and are {}.", report.grading, size(spec)),
        placed(report),
        if report.labels.is_none() { classes(model) } else { String::new() },
        inclusions(model),
        gaps(spec),
        itz(spec),
        format!(
            "The same version, {} give the same model, bit for bit.",
            if report.labels.is_some() { "labels and options" } else { "spec and seed" }
        ),
    ];
    let sentences = sentences.into_iter().chain(further.iter().cloned());
    let text: Vec<String> = sentences.filter(|sentence| !sentence.is_empty()).collect();
    format!("{}\n\n{}", wrapped(&text.join(" ")), SOURCES.replace("{version}", &report.version))
}

/// A sentence about a mesh of a model.
pub fn of_mesh(mesh: &Mesh, options: &MeshOptions, model: &Model) -> String {
    let cells = match mesh.kind {
        CellKind::Hexahedron => "hexahedra",
        CellKind::Tetrahedron => "tetrahedra",
        CellKind::QuadraticTetrahedron => "second-order tetrahedra",
    };
    let method = match options.method {
        Method::Voxel { .. } => "voxel",
        Method::Lattice { fit: Fit::Plain, .. } => "plain lattice",
        Method::Lattice { .. } => "lattice fitted to the aggregates",
        Method::Conforming { .. } => "conforming, by gmsh",
    };
    let [nodes, count] = [mesh.points.len(), mesh.phase.len()].map(thousands);
    let cohesive = match mesh.cohesive.len() {
        0 => String::new(),
        faces => format!(", and {} cohesive elements on the aggregates", thousands(faces)),
    };
    let exact = PhaseVolumes::exact_for(mesh, &model.bodies(), &model.spec.specimen);
    let off =
        exact.and_then(|exact| PhaseOff::between(&PhaseVolumes::of_bodies(mesh), &exact, model.spec.specimen.volume()));
    let off = off.map_or(String::new(), |off| {
        let percent = 100.0 * (off.meshed / off.exact - 1.0);
        format!("; of all phases the {} is farthest off its exact volume, {percent:+.2} %", mesh.phases.name(off.phase))
    });
    format!(
        "The mesh has {count} {cells} of {} mm ({}) with {nodes} nodes{cohesive}{off}.",
        options.element_size_mm, method
    )
}

/// A number of four figures, without those that say nothing.
fn figures(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// A sentence about the values of the phases.
pub fn of_materials(materials: &Materials) -> String {
    let Materials { aggregate, mortar, mortar_strength: strength, .. } = materials;
    let [stone, matrix] = [aggregate, mortar].map(|elastic| figures(elastic.youngs_modulus_mpa));
    let strengths = [
        strength.compressive_mpa.map(|mpa| format!("a compressive strength of {} MPa", figures(mpa))),
        Some(format!("a tensile strength of {} MPa", figures(strength.tensile_mpa))),
        strength.fracture_energy_n_per_mm.map(|energy| format!("a fracture energy of {} N/mm", figures(energy))),
    ];
    let strengths: Vec<String> = strengths.into_iter().flatten().collect();
    format!(
        "Young's modulus is {matrix} MPa in the mortar and {stone} MPa in the aggregates; the mortar has {}, and the ITZ {} of its \
         strengths.",
        strengths.join(", "),
        materials.itz_strength_ratio
    )
}

/// A specimen with its dimensions.
fn specimen(specimen: &Specimen, kind: &str) -> String {
    let size = |size: [f64; 3]| size.map(|mm| short(mm).to_string()).join(" x ");
    match *specimen {
        Specimen::Cube { side_mm, .. } => format!("cube of {side_mm} mm"),
        Specimen::Cylinder { diameter_mm, height_mm } => {
            format!("cylinder of {diameter_mm} mm in diameter and {height_mm} mm in height")
        }
        Specimen::Sphere { diameter_mm } => format!("sphere of {diameter_mm} mm in diameter"),
        Specimen::NotchedPrism { notch_depth_mm, notch_width_mm, notch_at_mm, .. } => {
            let within = size(specimen.aabb().size().into());
            let place = if notch_at_mm == 0.0 { String::new() } else { format!(", {notch_at_mm} mm from its middle") };
            format!("prism of {within} mm with a notch of {notch_width_mm} x {notch_depth_mm} mm{place}")
        }
        _ => format!("{} of {} mm", kind.replace('-', " "), size(specimen.aabb().size().into())),
    }
}

/// Where grains that were not packed come from.
fn origin(report: &Report) -> Option<String> {
    let LabelReport { voxels: [nx, ny, nz], voxel_size_mm: [x, y, z], .. } = report.labels.as_ref()?;
    let size = if x == y && y == z { format!("{x} mm") } else { format!("{x} x {y} x {z} mm") };
    Some(format!(
        "Aggregates are the connected grains of a label volume of {nx} x {ny} x {nz} voxels of {size}, as smooth surfaces of the volume of their voxels."
    ))
}

fn placed(report: &Report) -> String {
    let Report { strategy, seed, .. } = report;
    let fraction = report.coated_fraction.unwrap_or(report.fraction);
    let how = if report.labels.is_some() { String::new() } else { format!(" ({strategy}, seed {seed})") };
    let verb = if report.labels.is_some() { "found" } else { "placed" };
    let aggregates = thousands(report.aggregates);
    format!("{aggregates} aggregates were {verb}{how}, which is a volume fraction of {fraction:.4}, ITZ included.")
}

fn shapes(spec: &Spec) -> String {
    let [fewest, most] = spec.shape.vertices;
    match spec.shape.kind {
        ShapeKind::Library if spec.shape.has_dents() => {
            "Aggregates are given grains, some with dents, scaled to their size.".to_owned()
        }
        ShapeKind::Library => "Aggregates are the convex hulls of given grains, scaled to their size.".to_owned(),
        ShapeKind::Sphere => "Aggregates are spheres.".to_owned(),
        ShapeKind::Ellipsoid => "Aggregates are ellipsoids.".to_owned(),
        ShapeKind::Polyhedron => format!("Aggregates are random convex polyhedra with {fewest} to {most} vertices."),
        ShapeKind::Rounded => format!("Aggregates are rounded convex polyhedra with {fewest} to {most} vertices."),
        ShapeKind::Crushed => format!("Aggregates are angular convex polyhedra with {fewest} to {most} vertices."),
    }
}

fn size(spec: &Spec) -> &'static str {
    match spec.grading.size {
        SizeDefinition::Sieve => "widths of the smallest square opening that a grain passes",
        SizeDefinition::LongestAxis => "longest axes",
    }
}

/// Error of the grading; a run that fell short says so.
fn classes(model: &Model) -> String {
    let off = model.report.worst_class().unwrap_or(0.0);
    let worst = format!("The volume of the worst size class is {:+.2} % off its target.", 100.0 * off);
    match model.report.stop_reason {
        StopReason::TargetReached => worst,
        _ => format!("The target of {} was not reached. {worst}", model.report.target_fraction),
    }
}

fn inclusions(model: &Model) -> String {
    let phase = |phase: &PhaseReport| format!("{} ({:.4})", phase.phase.plural(), phase.fraction);
    let phases: Vec<String> = model.report.phases.iter().map(phase).collect();
    let own = |own: &OwnPhaseReport| format!("{} ({:.4})", own.phase, own.fraction);
    let own: Vec<String> = model.report.own_phases.iter().map(own).collect();
    let of_own = if own.is_empty() { String::new() } else { format!("Of the aggregates are {}.", own.join(" and ")) };
    let further = if phases.is_empty() { String::new() } else { format!("It also has {}.", phases.join(" and ")) };
    [of_own, further].into_iter().filter(|sentence| !sentence.is_empty()).collect::<Vec<_>>().join(" ")
}

fn gaps(spec: &Spec) -> String {
    match spec.placement.min_gap_mm {
        0.0 => "Every pair of aggregates is proved to share no point.".to_owned(),
        gap => format!("Every pair of aggregates is proved to be at least {gap} mm apart."),
    }
}

fn itz(spec: &Spec) -> String {
    let [low, high] = spec.itz.thickness_mm;
    match high {
        0.0 => "There is no ITZ.".to_owned(),
        _ if low == high => format!("Each aggregate has an ITZ shell {low} mm thick."),
        _ => format!("Each aggregate has an ITZ shell of constant thickness, uniform between {low} and {high} mm."),
    }
}

/// Columns of the paragraph.
const WIDTH: usize = 100;

fn wrapped(text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        if lines.last().is_some_and(|line| !line.is_empty() && line.len() + 1 + word.len() > WIDTH) {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            let space = if line.is_empty() { "" } else { " " };
            *line += &format!("{space}{word}");
        }
    }
    lines.join("\n")
}
