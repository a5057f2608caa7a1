//! The geometry part of a deck: nodes, elements by phase, node sets and surfaces of the bounding planes.

use super::DeckOptions;
use crate::export::lines::Lines;
use meso_mesh::cells::{CellKind, Mesh, Phase};
use meso_mesh::cells::{SIDES, Sides};
use std::io::{self, Write};

/// A node that no cell has: a reference node, or the corner of a plate.
pub(super) struct ExtraNodes {
    pub(super) number: u64,
    pub(super) position: [f64; 3],
    /// Name of its node set; none for corners.
    pub(super) set: Option<String>,
}

/// The deck's heading; of geometry alone comments, since a deck that includes it, perhaps within a part, has its own.
pub(super) fn heading(lines: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions) -> io::Result<()> {
    let comment = if options.geometry_only { "** " } else { "" };
    if !options.geometry_only {
        lines.line("*HEADING")?;
    }
    let version = env!("CARGO_PKG_VERSION");
    lines.line(format!("{comment}mesocrete {version} deck; units mm, N, MPa, tonne, s"))?;
    lines.line(format!("{comment}{}", counts(mesh)))?;
    options.heading.iter().try_for_each(|line| lines.line(format!("{comment}{line:.76}")))?;
    if options.has_curve() {
        lines.line("check: abaqus datacheck job=NAME input=THIS.inp double=both")?;
        lines.line("run: abaqus job=NAME input=THIS.inp double=both cpus=16")?;
    }
    Ok(())
}

/// How many nodes the mesh has, and elements of each phase.
fn counts(mesh: &Mesh) -> String {
    let of = |phase: Phase| {
        let cells = mesh.phase.iter().filter(|p| **p == phase).count();
        format!(
            "{} {}",
            mesh.phases.set_name(phase),
            cells + if phase == Phase::Itz { mesh.cohesive().len() } else { 0 }
        )
    };
    let joints = (!mesh.cohesive.is_empty()).then_some(Phase::Itz);
    let elements: Vec<String> = present(mesh).chain(joints).map(of).collect();
    format!("{} nodes; elements {}", mesh.points.len(), elements.join(", "))
}

pub(super) fn write(
    lines: &mut Lines<impl Write>,
    mesh: &Mesh,
    sides: &Sides,
    options: &DeckOptions,
    extras: &[ExtraNodes],
) -> io::Result<()> {
    nodes(lines, mesh, extras)?;
    elements(lines, mesh, options)?;
    node_sets(lines, sides)?;
    surfaces(lines, sides)
}

/// One block of all nodes: readers such as meshio keep one alone. `ALLNODES` are the mesh's.
fn nodes(lines: &mut Lines<impl Write>, mesh: &Mesh, extras: &[ExtraNodes]) -> io::Result<()> {
    lines.line(if extras.is_empty() { "*NODE, NSET=ALLNODES" } else { "*NODE" })?;
    (1..).zip(&mesh.points).try_for_each(|(number, p)| lines.node(number, [p.x, p.y, p.z]))?;
    if extras.is_empty() {
        return Ok(());
    }
    extras.iter().try_for_each(|extra| lines.node(extra.number, extra.position))?;
    lines.line("*NSET, NSET=ALLNODES, GENERATE")?;
    // meshio wants the increment, too.
    lines.line(format!("1, {}, 1", mesh.points.len()))?;
    for (extra, set) in extras.iter().filter_map(|extra| Some((extra, extra.set.as_ref()?))) {
        node_set(lines, set, std::iter::once(extra.number))?;
    }
    Ok(())
}

/// One element block per phase, so that the block's ELSET is the phase's set.
fn elements(lines: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions) -> io::Result<()> {
    let kind = match mesh.kind {
        CellKind::Tetrahedron => "C3D4",
        // The second-order tetrahedron that is made for contact and for *DYNAMIC, EXPLICIT.
        CellKind::QuadraticTetrahedron if options.is_explicit() => "C3D10M",
        CellKind::QuadraticTetrahedron => "C3D10",
        CellKind::Hexahedron if options.reduced_integration => "C3D8R",
        CellKind::Hexahedron => "C3D8",
    };
    for phase in present(mesh) {
        lines.line(format!("*ELEMENT, TYPE={kind}, ELSET={}", mesh.phases.set_name(phase)))?;
        for ((number, cell), cell_phase) in (1..).zip(mesh.cells()).zip(&mesh.phase) {
            if *cell_phase == phase {
                lines.element(number, cell)?;
            }
        }
    }
    cohesive(lines, mesh)
}

/// Cohesive elements are numbered after the cells; they are the set ITZ.
fn cohesive(lines: &mut Lines<impl Write>, mesh: &Mesh) -> io::Result<()> {
    if mesh.cohesive.is_empty() {
        return Ok(());
    }
    let kind = if mesh.kind == CellKind::Hexahedron { "COH3D8" } else { "COH3D6" };
    lines.line(format!("*ELEMENT, TYPE={kind}, ELSET=ITZ"))?;
    let first = mesh.cell_count() as u64 + 1;
    (first..).zip(mesh.cohesive()).try_for_each(|(number, nodes)| lines.element(number, nodes))
}

/// The phases that have elements: an empty set would be an error to Abaqus.
pub(super) fn present(mesh: &Mesh) -> impl Iterator<Item = Phase> {
    mesh.phases.solid().filter(|phase| mesh.phase.contains(phase))
}

fn node_sets(lines: &mut Lines<impl Write>, sides: &Sides) -> io::Result<()> {
    for (bit, (_, _, name)) in SIDES.iter().enumerate() {
        node_set(lines, name, sides.members(bit).map(|node| u64::from(node) + 1))?;
    }
    Ok(())
}

/// A node set of these numbers.
pub(super) fn node_set(
    lines: &mut Lines<impl Write>,
    name: &str,
    numbers: impl Iterator<Item = u64>,
) -> io::Result<()> {
    lines.line(format!("*NSET, NSET={name}"))?;
    lines.members(numbers)
}

/// The element faces on each side.
fn surfaces(lines: &mut Lines<impl Write>, sides: &Sides) -> io::Result<()> {
    for ((_, _, name), faces) in SIDES.iter().zip(sides.faces()).filter(|(_, faces)| !faces.is_empty()) {
        lines.line(format!("*SURFACE, TYPE=ELEMENT, NAME=S_{name}"))?;
        faces.iter().try_for_each(|&(cell, face)| lines.face(u64::from(cell) + 1, face))?;
    }
    Ok(())
}
