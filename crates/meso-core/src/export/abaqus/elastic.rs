//! Linear elastic compression between two frictionless planes, for Abaqus/Standard and CalculiX.
//!
//! ZMIN is held and ZMAX moved along z, all other directions free: the reaction over the area is the mean stress, and
//! over the strain it is the effective modulus. Three pinned displacements take the rigid motions that are left.

use super::lines::Lines;
use crate::math::{Aabb, Vec3};
use crate::mesh::Mesh;
use crate::mesh::sides::Sides;
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
    for set in ["ZMIN", "ZMAX"] {
        lines.line(format!("*NODE PRINT, NSET={set}, TOTALS=YES"))?;
        lines.line("RF")?;
    }
    lines.line("*NODE FILE")?;
    lines.line("U, RF")?;
    lines.line("*EL FILE")?;
    lines.line("S, E")?;
    lines.line("*END STEP")
}

/// Number of the node on ZMIN nearest to `corner`; of equally near ones the first.
fn nearest(mesh: &Mesh, sides: &Sides, corner: Vec3) -> u64 {
    let distance = |node: &u32| (mesh.points[*node as usize] - corner).norm_squared();
    let node = sides.members(4).min_by(|a, b| distance(a).total_cmp(&distance(b)));
    u64::from(node.expect("a mesh has a lowest node")) + 1
}
