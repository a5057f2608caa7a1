//! Aggregate surfaces as Wavefront OBJ: one object per body, in the group of its material, with colours at the corners.
//!
//! Faces are the body's own polygons; numbers are the shortest that read back the same.

use super::appearance::{colour, material, name};
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::Aggregate;
use std::io::{self, BufWriter, Write};

/// Writes every body to `out`, mm.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(bodies: &[Aggregate], phases: &PhaseNames, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "# mesocrete, mm")?;
    // Corners count from 1 through the whole file.
    let mut first = 1;
    for body in bodies {
        write!(out, "o {}\ng {}\n", name(body, phases), material(body, phases))?;
        let [r, g, b] = colour(body).map(|level| f64::from(level) / 255.0);
        for vertex in body.body.vertices() {
            writeln!(out, "v {} {} {} {r:.4} {g:.4} {b:.4}", vertex.x, vertex.y, vertex.z)?;
        }
        for face in body.body.faces() {
            write!(out, "f")?;
            face.iter().try_for_each(|corner| write!(out, " {}", first + u64::from(corner)))?;
            writeln!(out)?;
        }
        first += body.body.vertices().len() as u64;
    }
    out.flush()
}
