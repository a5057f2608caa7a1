//! Aggregate surfaces as STL, for CAD programs and 3D printers: binary triangles without ids, or one named solid per body
//! as text.
//!
//! Coordinates are rounded to f32, as the format requires: at most 8e-6 mm in a 150 mm specimen. For the exact
//! polyhedra read the `.json`.

use super::appearance::name;
use meso_collision::math::Vec3;
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::Aggregate;
use std::io::{self, BufWriter, Write};

/// Writes every triangle of every aggregate to `out`, mm.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write(aggregates: &[Aggregate], out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    // 80 bytes that must not begin with "solid", by which readers know the text form.
    out.write_all(&format!("{:80}", "mesocrete aggregates, mm").as_bytes()[..80])?;
    let count: usize = aggregates.iter().map(|a| a.body.triangles().count()).sum();
    let count =
        u32::try_from(count).map_err(|_| io::Error::other("a binary STL holds at most 4294967295 triangles"))?;
    out.write_all(&count.to_le_bytes())?;
    for aggregate in aggregates {
        let vertices = aggregate.body.vertices();
        for triangle in aggregate.body.triangles() {
            write_triangle(triangle.map(|i| vertices[i as usize]), &mut out)?;
        }
    }
    out.flush()
}

/// Writes every body to `out` as a solid of its own, which has its name; the text form, some five times as long.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write_solids(bodies: &[Aggregate], phases: &PhaseNames, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    for body in bodies {
        let (name, vertices) = (name(body, phases), body.body.vertices());
        writeln!(out, "solid {name}")?;
        for triangle in body.body.triangles() {
            let corners = triangle.map(|i| vertices[i as usize]);
            writeln!(out, "facet normal {}\nouter loop", spaced(&normal(&corners)))?;
            corners.iter().try_for_each(|corner| writeln!(out, "vertex {}", spaced(corner)))?;
            out.write_all(b"endloop\nendfacet\n")?;
        }
        writeln!(out, "endsolid {name}")?;
    }
    out.flush()
}

fn spaced(v: &Vec3) -> String {
    format!("{} {} {}", v.x as f32, v.y as f32, v.z as f32)
}

fn normal([a, b, c]: &[Vec3; 3]) -> Vec3 {
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros)
}

fn write_triangle(corners: [Vec3; 3], out: &mut impl Write) -> io::Result<()> {
    let [a, b, c] = corners;
    for value in [normal(&corners), a, b, c].iter().flat_map(|v| v.iter()) {
        out.write_all(&(*value as f32).to_le_bytes())?;
    }
    out.write_all(&[0, 0])
}
