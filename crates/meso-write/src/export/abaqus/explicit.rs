//! Quasi-static compression and tension by `*DYNAMIC, EXPLICIT` (Sec. 3.2 of the method paper).
//!
//! Compression: two rigid plates with friction, the lower one held, the upper one moved down along a smooth step.
//! Tension: the same loading of two rigid bodies that hold the nodes of ZMIN and ZMAX, as glued platens do.

use super::geometry::present;
use super::limits::DECK;
use super::lines::real;
use super::{Analysis, DeckOptions, LAW};
use crate::export::lines::Lines;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::OutOfRange;
use meso_mesh::cells::Sides;
use meso_mesh::cells::{Mesh, Phase};
use std::io::{self, Write};

/// The plates reach beyond the specimen by this share of its width, so that its sides can bulge.
pub(super) const OVERHANG: f64 = 0.1;
/// Rows of history output in a step.
pub(super) const HISTORY: f64 = 500.0;
/// Frames of stresses and strains.
const STRESS_FRAMES: u32 = 5;

/// Plates or held faces, contact, and the step.
pub(super) fn write(
    lines: &mut Lines<impl Write>,
    mesh: &Mesh,
    sides: &Sides,
    options: &DeckOptions,
) -> io::Result<()> {
    let aabb = Aabb::around(&mesh.points);
    let compression = options.analysis == Analysis::Compression;
    let references = reference_nodes(lines, mesh, &aabb)?;
    if compression {
        slaves(lines)?;
        plates(lines, mesh, &aabb, references)?;
        contact(lines, options.loading.friction)?;
    } else {
        held_faces(lines, sides, references)?;
    }
    let travel = options.final_strain() * aabb.size().z * if compression { -1.0 } else { 1.0 };
    step(lines, mesh, options, travel, compression)
}

/// Finds out whether the specimen has faces that plates can press on: a spike has none.
pub(super) fn check(sides: &Sides) -> Result<(), OutOfRange> {
    for (bit, surface) in [(4, "S_ZMIN"), (5, "S_ZMAX")] {
        if sides.faces()[bit].is_empty() {
            let why =
                "no face of the specimen points that way within 45 degrees; take tension, which holds nodes, or none";
            return Err(DECK.error("analysis", "compression", format!("a plate presses on {surface}, and {why}")));
        }
    }
    Ok(())
}

/// The nodes of ZMIN and ZMAX as surfaces of contact pairs.
///
/// Faces of a contact surface must be connected by edges, not by single nodes. Faces of separated aggregates, caps of
/// spheres and voids at a side are not; a surface of nodes has no such rule.
fn slaves(lines: &mut Lines<impl Write>) -> io::Result<()> {
    for side in ["ZMIN", "ZMAX"] {
        lines.line(format!("*SURFACE, TYPE=NODE, NAME=N_{side}"))?;
        lines.line(side)?;
    }
    Ok(())
}

/// Two nodes below and above the specimen, named REF_BOTTOM and REF_TOP; returns their numbers.
fn reference_nodes(lines: &mut Lines<impl Write>, mesh: &Mesh, aabb: &Aabb) -> io::Result<[u64; 2]> {
    let middle = (aabb.min + aabb.max) / 2.0;
    let first = mesh.points.len() as u64 + 1;
    for (number, name, z) in [(first, "REF_BOTTOM", aabb.min.z), (first + 1, "REF_TOP", aabb.max.z)] {
        lines.line(format!("*NODE, NSET={name}"))?;
        lines.node(number, [middle.x, middle.y, z])?;
    }
    Ok([first, first + 1])
}

/// A rigid facet under and over the specimen, each with its positive side towards it.
fn plates(lines: &mut Lines<impl Write>, mesh: &Mesh, aabb: &Aabb, references: [u64; 2]) -> io::Result<()> {
    let margin = Vec3::new(aabb.size().x, aabb.size().y, 0.0) * OVERHANG;
    let (low, high) = (aabb.min - margin, aabb.max + margin);
    let element = (mesh.cell_count() + mesh.cohesive().len()) as u64 + 1;
    for (i, (name, z)) in [("PLATE_BOTTOM", aabb.min.z), ("PLATE_TOP", aabb.max.z)].into_iter().enumerate() {
        let first = references[1] + 1 + 4 * i as u64;
        let mut corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
        if i == 1 {
            corners.reverse();
        }
        lines.line("*NODE")?;
        (first..).zip(corners).try_for_each(|(number, (x, y))| lines.node(number, [x, y, z]))?;
        lines.line(format!("*ELEMENT, TYPE=R3D4, ELSET={name}"))?;
        lines.element(element + i as u64, &[0, 1, 2, 3].map(|corner| first as u32 + corner - 1))?;
        lines.line(format!("*RIGID BODY, REF NODE={}, ELSET={name}", references[i]))?;
        // No thickness: half of any would be overclosure.
        lines.line("0.,")?;
        lines.line(format!("*SURFACE, TYPE=ELEMENT, NAME=S_{name}"))?;
        lines.line(format!("{name}, SPOS"))?;
    }
    Ok(())
}

/// The nodes of ZMIN and ZMAX as parts of rigid bodies.
fn held_faces(lines: &mut Lines<impl Write>, sides: &Sides, references: [u64; 2]) -> io::Result<()> {
    for (bit, (set, reference)) in (4..).zip([("ZMIN", references[0]), ("ZMAX", references[1])]) {
        debug_assert!(sides.members(bit).next().is_some());
        lines.line(format!("*RIGID BODY, REF NODE={reference}, PIN NSET={set}"))?;
    }
    Ok(())
}

fn contact(lines: &mut Lines<impl Write>, friction: f64) -> io::Result<()> {
    lines.line("*SURFACE INTERACTION, NAME=PLATEN")?;
    lines.line("*FRICTION")?;
    lines.line(format!("{},", real(friction)))
}

fn step(
    lines: &mut Lines<impl Write>,
    mesh: &Mesh,
    options: &DeckOptions,
    travel: f64,
    contact: bool,
) -> io::Result<()> {
    let loading = &options.loading;
    let duration = real(loading.duration_s);
    lines.line("*AMPLITUDE, NAME=SMOOTH, DEFINITION=SMOOTH STEP")?;
    lines.line(format!("0.0, 0.0, {duration}, 1.0"))?;
    lines.line("*STEP, NLGEOM=YES")?;
    lines.line("*DYNAMIC, EXPLICIT")?;
    lines.line(format!(", {duration}"))?;
    lines.line(format!("*FIXED MASS SCALING, DT={}, TYPE=BELOW MIN", real(loading.time_increment_s)))?;
    lines.line("*BOUNDARY")?;
    lines.line("REF_BOTTOM, 1, 6")?;
    lines.line("REF_TOP, 1, 2")?;
    lines.line("REF_TOP, 4, 6")?;
    lines.line("*BOUNDARY, TYPE=DISPLACEMENT, AMPLITUDE=SMOOTH")?;
    lines.line(format!("REF_TOP, 3, 3, {travel:.9e}"))?;
    if contact {
        for (slave, master) in [("N_ZMIN", "S_PLATE_BOTTOM"), ("N_ZMAX", "S_PLATE_TOP")] {
            lines.line("*CONTACT PAIR, INTERACTION=PLATEN, MECHANICAL CONSTRAINT=KINEMATIC")?;
            lines.line(format!("{slave}, {master}"))?;
        }
    }
    restart(lines)?;
    fields(lines, mesh, options)?;
    let plates = ["REF_BOTTOM", "REF_TOP"].map(|set| (set.to_owned(), 3));
    history(lines, plates.into_iter(), options.loading.duration_s / HISTORY)?;
    lines.line("*END STEP")
}

/// States from which a job of days goes on after it was killed.
pub(super) fn restart(lines: &mut Lines<impl Write>) -> io::Result<()> {
    lines.line("*RESTART, WRITE, NUMBER INTERVAL=4")
}

/// Damage and displacements at every frame; stresses and strains, most of the size, at few.
pub(super) fn fields(lines: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions) -> io::Result<()> {
    let frames = options.loading.frames;
    lines.line(format!("*OUTPUT, FIELD, NUMBER INTERVAL={frames}"))?;
    lines.line("*NODE OUTPUT")?;
    lines.line("U")?;
    for phase in present(mesh).filter(|phase| options.materials.strength(*phase, LAW).is_some()) {
        element_output(lines, phase, "PEEQ, PEEQT, DAMAGEC, DAMAGET, SDEG")?;
    }
    if !mesh.cohesive.is_empty() {
        element_output(lines, Phase::Itz, "S, LE, SDEG, QUADSCRT, STATUS")?;
    }
    lines.line(format!("*OUTPUT, FIELD, NUMBER INTERVAL={}", frames.min(STRESS_FRAMES)))?;
    for phase in present(mesh) {
        let plastic = if options.materials.strength(phase, LAW).is_some() { ", PE" } else { "" };
        element_output(lines, phase, &format!("S, LE{plastic}"))?;
    }
    Ok(())
}

fn element_output(lines: &mut Lines<impl Write>, phase: Phase, variables: &str) -> io::Result<()> {
    lines.line(format!("*ELEMENT OUTPUT, ELSET={}", phase.name()))?;
    lines.line(variables)
}

/// Forces and displacements of the plates, filtered since contact forces alias; energies; the increments and the mass that
/// scaling adds. `plates` are sets of reference nodes, each with the degree of freedom along its axis.
pub(super) fn history(
    lines: &mut Lines<impl Write>,
    plates: impl Iterator<Item = (String, usize)>,
    interval: f64,
) -> io::Result<()> {
    let interval = real(interval);
    lines.line(format!("*OUTPUT, HISTORY, TIME INTERVAL={interval}, FILTER=ANTIALIASING"))?;
    for (set, dof) in plates {
        lines.line(format!("*NODE OUTPUT, NSET={set}"))?;
        lines.line(format!("U{dof}, RF{dof}"))?;
    }
    lines.line(format!("*OUTPUT, HISTORY, TIME INTERVAL={interval}"))?;
    lines.line("*ENERGY OUTPUT")?;
    lines.line("ALLIE, ALLKE, ALLWK, ALLSE, ALLPD, ALLDMD, ALLFD, ALLAE, ALLVD, ALLMW, ETOTAL")?;
    lines.line("*INCREMENTATION OUTPUT")?;
    lines.line("DT, DMASS")
}
