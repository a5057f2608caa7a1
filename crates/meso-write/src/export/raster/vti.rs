//! VTK image data (`.vti`), for ParaView and PyVista: a header in XML, then the values appended as they come.
//!
//! Values belong to the cells, which are the voxels. Little-endian, the size counted in 64 bits.

use super::{Frame, ValueKind, Voxels};
use std::io::{self, Write};

/// Writes an image to `out`, slab by slab.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(frame: &Frame, mut slabs: impl Iterator<Item = Voxels>, mut out: impl Write) -> io::Result<()> {
    let Frame { counts: [nx, ny, nz], corner_mm: [x, y, z], voxel_size_mm: h, name, .. } = *frame;
    let kind = match frame.kind {
        ValueKind::Label => "UInt8",
        ValueKind::Id => "Int32",
        ValueKind::Real => "Float32",
    };
    let extent = format!("0 {nx} 0 {ny} 0 {nz}");
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    write!(out, "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" ")?;
    writeln!(out, "header_type=\"UInt64\">")?;
    writeln!(out, "<ImageData WholeExtent=\"{extent}\" Origin=\"{x} {y} {z}\" Spacing=\"{h} {h} {h}\">")?;
    writeln!(out, "<Piece Extent=\"{extent}\">\n<CellData Scalars=\"{name}\">")?;
    writeln!(out, "<DataArray type=\"{kind}\" Name=\"{name}\" format=\"appended\" offset=\"0\"/>")?;
    write!(out, "</CellData>\n</Piece>\n</ImageData>\n<AppendedData encoding=\"raw\">\n_")?;
    out.write_all(&((nx * ny * nz * frame.kind.bytes()) as u64).to_le_bytes())?;
    slabs.try_for_each(|slab| out.write_all(&slab.bytes()))?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
}
