//! One row per aggregate, void and fibre, for spreadsheets and pandas.

use meso_collision::math::longest_distance;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{PhaseNames, parallel};
use std::io::{self, BufWriter, Write};

/// The columns; lengths in mm.
const HEADER: &str = "id,class,size_mm,sieve_size_mm,volume_mm3,area_mm2,sphericity,centroid_x_mm,centroid_y_mm,centroid_z_mm,\
itz_thickness_mm,vertices,faces,phase";

/// Writes a header and one row per body to `out`; numbers are the shortest that read back the same.
///
/// `size_mm` is the longest distance between two vertices: the longest axis 2a of the ellipsoid they were drawn on.
/// `sieve_size_mm` is the smallest square opening that it passes. `sphericity` is Wadell's: the area of the sphere of equal
/// volume over the body's area.
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
    let bodies: Vec<&Aggregate> = bodies.into_iter().collect();
    let sieved = parallel::map_each(&bodies, |aggregate| aggregate.body.sieve_size());
    for (aggregate, sieve_size) in bodies.into_iter().zip(sieved) {
        let Aggregate { id, class, itz_thickness_mm, body, .. } = aggregate;
        let (mass, area) = (body.mass_properties(), body.area());
        let size = longest_distance(body.vertices());
        let sphericity = body.sphericity();
        let [x, y, z] = mass.centroid.into();
        let (vertices, faces) = (body.vertices().len(), body.faces().len());
        writeln!(
            out,
            "{id},{class},{size},{sieve_size},{},{area},{sphericity},{x},{y},{z},{itz_thickness_mm},{vertices},{faces},{}",
            mass.volume,
            phases.name(aggregate.phase())
        )?;
    }
    out.flush()
}
