//! Linear elastic compression between two frictionless planes, for Abaqus/Standard and CalculiX.
//!
//! Between planes, ZMIN is held and ZMAX moved along z, all other directions free: the reaction over the area is the mean stress, and
//! over the strain it is the effective modulus. Three pinned displacements take the rigid motions that are left. A
//! periodic box is compressed in the mean instead, by its reference nodes.

use super::geometry::present;
use super::periodic::REFERENCES;
use crate::export::lines::Lines;
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::cells::Mesh;
use meso_mesh::cells::Sides;
use std::io::{self, Write};

/// The step: displacement of ZMAX by -`strain` times the height, reactions of both planes.
pub(super) fn write(lines: &mut Lines<impl Write>, mesh: &Mesh, sides: &Sides, strain: f64) -> io::Result<()> {
    let aabb = Aabb::around(&mesh.points);
    let pin = nearest(mesh, sides, aabb.min);
    let guide = nearest(mesh, sides, Vec3::new(aabb.max.x, aabb.min.y, aabb.min.z));
    lines.line("*STEP")?;
    lines.line("*STATIC")?;
    lines.line("*BOUNDARY")?;
    lines.line("ZMIN, 3, 3")?;
    lines.line(format!("{pin}, 1, 2"))?;
    lines.line(format!("{guide}, 2, 2"))?;
    lines.line(format!("ZMAX, 3, 3, {:.12e}", -strain * aabb.size().z))?;
    end(lines, &["ZMIN", "ZMAX"], "RF", &[])
}

/// The step of a periodic box: mean strain -`strain` along z, all other mean stresses zero, the reactions over the
/// areas being the mean stresses.
///
/// The reference nodes hold the columns of the displacement gradient H: with H21, H31 and H32 zero the box does not turn,
/// and may shear.
pub(super) fn write_periodic(lines: &mut Lines<impl Write>, mesh: &Mesh, sides: &Sides, strain: f64) -> io::Result<()> {
    let aabb = Aabb::around(&mesh.points);
    lines.line("*STEP")?;
    lines.line("*STATIC")?;
    lines.line("*BOUNDARY")?;
    lines.line(format!("{}, 1, 3", nearest(mesh, sides, aabb.min)))?;
    lines.line("REF_X, 2, 3")?;
    lines.line("REF_Y, 3, 3")?;
    lines.line(format!("REF_Z, 3, 3, {:.12e}", -strain * aabb.size().z))?;
    let sets: Vec<_> = present(mesh).map(|phase| mesh.phases.set_name(phase)).collect();
    let sets: Vec<&str> = sets.iter().map(AsRef::as_ref).collect();
    end(lines, &REFERENCES, "U, RF", &sets)
}

/// Writes the output requests of `sets` and fields, and the end of the step.
///
/// The strain energy of `energies`, element sets, is printed in all: CalculiX leaves forces of equations out of reactions.
pub(super) fn end(lines: &mut Lines<impl Write>, sets: &[&str], printed: &str, energies: &[&str]) -> io::Result<()> {
    lines.line("*OUTPUT, FIELD")?;
    lines.line("*NODE OUTPUT")?;
    lines.line("U, RF")?;
    lines.line("*ELEMENT OUTPUT")?;
    lines.line("S, E")?;
    for set in sets {
        lines.line(format!("*NODE PRINT, NSET={set}, TOTALS=YES"))?;
        lines.line(printed)?;
    }
    for set in energies {
        lines.line(format!("*EL PRINT, ELSET={set}, TOTALS=YES"))?;
        lines.line("ELSE")?;
    }
    lines.line("*NODE FILE")?;
    lines.line("U, RF")?;
    lines.line("*EL FILE")?;
    lines.line("S, E")?;
    lines.line("*END STEP")
}

/// The mesh's node nearest to `corner`; of equally near ones the first.
pub(super) fn nearest_node(mesh: &Mesh, corner: Vec3) -> u32 {
    let distance = |node: &u32| (mesh.points[*node as usize] - corner).norm_squared();
    let nodes = 0..mesh.points.len() as u32;
    nodes.min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a mesh has nodes")
}

/// Number of the node on ZMIN nearest to `corner`; of equally near ones the first.
fn nearest(mesh: &Mesh, sides: &Sides, corner: Vec3) -> u64 {
    let distance = |node: &u32| (mesh.points[*node as usize] - corner).norm_squared();
    let node = sides.members(4).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    u64::from(node.expect("a mesh has a lowest node")) + 1
}
