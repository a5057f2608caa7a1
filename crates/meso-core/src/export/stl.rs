//! Aggregate surfaces as binary STL: triangles without ids, for CAD programs and 3D printers.
//!
//! Coordinates are rounded to f32, as the format requires: at most 8e-6 mm in a 150 mm specimen. For the exact
//! polyhedra read the `.json`.

use crate::aggregate::Aggregate;
use crate::math::Vec3;
use std::io::{self, BufWriter, Write};

/// Writes every triangle of every aggregate to `out`, mm.
///
/// # Errors
/// Those of `out`.
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

fn write_triangle([a, b, c]: [Vec3; 3], out: &mut impl Write) -> io::Result<()> {
    let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::zeros);
    for value in [normal, a, b, c].iter().flat_map(|v| v.iter()) {
        out.write_all(&(*value as f32).to_le_bytes())?;
    }
    out.write_all(&[0, 0])
}
