//! Aggregate surfaces as binary PLY: triangles with ids and colours, for mesh viewers and Python's `trimesh`.
//!
//! Each face has `red`, `green`, `blue`, `aggregate`, `class`, `phase` and `itz_thickness_mm`; coordinates are f64.

use super::appearance::colour;
use meso_concrete::aggregate::Aggregate;
use std::io::{self, BufWriter, Write};

/// Writes every triangle of every body to `out`, mm.
///
/// # Errors
/// Fails with the errors of `out`; more points than the format's 32-bit numbers reach.
pub(crate) fn write(bodies: &[Aggregate], out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let points: usize = bodies.iter().map(|body| body.body.vertices().len()).sum();
    if points > i32::MAX as usize {
        return Err(io::Error::other("a .ply holds at most 2147483647 points"));
    }
    let triangles: usize = bodies.iter().map(|body| body.body.triangles().count()).sum();
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment mesocrete, mm\nelement vertex {points}")?;
    writeln!(out, "property double x\nproperty double y\nproperty double z\nelement face {triangles}")?;
    writeln!(out, "property list uchar int vertex_indices")?;
    writeln!(out, "property uchar red\nproperty uchar green\nproperty uchar blue")?;
    writeln!(out, "property int aggregate\nproperty int class\nproperty uchar phase")?;
    writeln!(out, "property double itz_thickness_mm\nend_header")?;
    for x in bodies.iter().flat_map(|body| body.body.vertices()).flat_map(|vertex| [vertex.x, vertex.y, vertex.z]) {
        out.write_all(&x.to_le_bytes())?;
    }
    let mut first = 0;
    for body in bodies {
        write_faces(body, first, &mut out)?;
        first += body.body.vertices().len() as i32;
    }
    out.flush()
}

fn write_faces(body: &Aggregate, first: i32, out: &mut impl Write) -> io::Result<()> {
    let mut values = colour(body).to_vec();
    values.extend((body.id as i32).to_le_bytes());
    values.extend(i32::from(body.class).to_le_bytes());
    values.push(body.phase().number());
    values.extend(body.itz_thickness_mm.to_le_bytes());
    for corners in body.body.triangles() {
        out.write_all(&[3])?;
        corners.iter().try_for_each(|&corner| out.write_all(&(first + corner as i32).to_le_bytes()))?;
        out.write_all(&values)?;
    }
    Ok(())
}
