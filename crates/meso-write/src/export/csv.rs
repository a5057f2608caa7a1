//! One row per aggregate, void and fibre, for spreadsheets and pandas.

use meso_collision::math::longest_distance;
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::Aggregate;
use std::f64::consts::PI;
use std::io::{self, BufWriter, Write};

/// The columns; lengths in mm.
const HEADER: &str = "id,class,size_mm,volume_mm3,area_mm2,sphericity,centroid_x_mm,centroid_y_mm,centroid_z_mm,\
itz_thickness_mm,vertices,faces,phase";

/// Writes a header and one row per body to `out`; numbers are the shortest that read back the same.
///
/// `size_mm` is the longest distance between two vertices: the longest axis 2a of the ellipsoid they were drawn on.
/// `sphericity` is Wadell's: the area of the sphere of equal volume over the body's area.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write<'a>(
    bodies: impl IntoIterator<Item = &'a Aggregate>,
    phases: &PhaseNames,
    out: impl Write,
) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    writeln!(out, "{HEADER}")?;
    for aggregate in bodies {
        let Aggregate { id, class, itz_thickness_mm, body, .. } = aggregate;
        let (mass, area) = (body.mass_properties(), body.area());
        let size = longest_distance(body.vertices());
        let sphericity = libm::cbrt(PI) * libm::cbrt(6.0 * mass.volume).powi(2) / area;
        let [x, y, z] = mass.centroid.into();
        let (vertices, faces) = (body.vertices().len(), body.faces().len());
        writeln!(
            out,
            "{id},{class},{size},{},{area},{sphericity},{x},{y},{z},{itz_thickness_mm},{vertices},{faces},{}",
            mass.volume,
            phases.name(aggregate.phase())
        )?;
    }
    out.flush()
}
