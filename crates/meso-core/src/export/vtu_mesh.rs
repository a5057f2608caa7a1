//! Volume meshes as VTK unstructured grids (`.vtu`), binary appended: what ParaView, PyVista and meshio read.
//!
//! Cell data: `phase` (0 mortar, 1 ITZ, 2 aggregate), `aggregate` (id, -1 in the mortar) and whatever fields the caller
//! adds, e.g. quality. Everything is little-endian; array sizes are counted in 64 bits.

use crate::mesh::{CellKind, Mesh, NO_AGGREGATE};
use std::io::{self, BufWriter, Write};

/// A named value per cell.
#[derive(Clone, Copy, Debug)]
pub struct CellField<'a> {
    /// Its name in the file.
    pub name: &'a str,
    /// One value per cell.
    pub values: &'a [f32],
}

/// Writes `mesh` with its phases and `fields` to `out`, in one pass.
///
/// # Errors
/// Those of `out`.
pub fn write(mesh: &Mesh, fields: &[CellField], out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    header(mesh, fields, &mut out)?;
    out.write_all(b"<AppendedData encoding=\"raw\">\n_")?;
    data(mesh, fields, &mut out)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    out.flush()
}

/// The arrays' declarations; each starts where the one before it, with its 8 bytes of size, ends.
fn header(mesh: &Mesh, fields: &[CellField], out: &mut impl Write) -> io::Result<()> {
    let (points, cells) = (mesh.points.len(), mesh.cell_count());
    let mut offset = 0;
    let mut array = |kind: &str, name: &str, components: usize, bytes: usize| {
        let text = format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{offset}\"/>\n"
        );
        offset += 8 + bytes;
        text
    };
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">"
    )?;
    writeln!(out, "<UnstructuredGrid>\n<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">")?;
    write!(out, "<Points>\n{}</Points>\n", array("Float64", "Points", 3, 24 * points))?;
    write!(out, "<Cells>\n{}", array("Int32", "connectivity", 1, 4 * mesh.cells.len()))?;
    write!(out, "{}", array("Int64", "offsets", 1, 8 * cells))?;
    write!(out, "{}</Cells>\n<CellData Scalars=\"phase\">\n", array("UInt8", "types", 1, cells))?;
    write!(out, "{}{}", array("UInt8", "phase", 1, cells), array("Int32", "aggregate", 1, 4 * cells))?;
    for field in fields {
        write!(out, "{}", array("Float32", field.name, 1, 4 * cells))?;
    }
    writeln!(out, "</CellData>\n</Piece>\n</UnstructuredGrid>")
}

/// The arrays in the order of [`header`].
fn data(mesh: &Mesh, fields: &[CellField], out: &mut impl Write) -> io::Result<()> {
    let (nodes, cells) = (mesh.kind.nodes() as i64, mesh.cell_count());
    let kind = match mesh.kind {
        CellKind::Tetrahedron => 10,
        CellKind::Hexahedron => 12,
    };
    array(out, 24 * mesh.points.len(), mesh.points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_le_bytes))?;
    array(out, 4 * mesh.cells.len(), mesh.cells.iter().map(|node| node.to_le_bytes()))?;
    array(out, 8 * cells, (1..=cells as i64).map(|cell| (cell * nodes).to_le_bytes()))?;
    array(out, cells, std::iter::repeat_n([kind], cells))?;
    array(out, cells, mesh.phase.iter().map(|phase| [*phase as u8]))?;
    array(out, 4 * cells, mesh.aggregate.iter().map(|&id| signed(id).to_le_bytes()))?;
    fields.iter().try_for_each(|field| array(out, 4 * cells, field.values.iter().map(|value| value.to_le_bytes())))
}

fn signed(aggregate: u32) -> i32 {
    if aggregate == NO_AGGREGATE { -1 } else { aggregate as i32 }
}

fn array<const N: usize>(out: &mut impl Write, bytes: usize, values: impl Iterator<Item = [u8; N]>) -> io::Result<()> {
    out.write_all(&(bytes as u64).to_le_bytes())?;
    for value in values {
        out.write_all(&value)?;
    }
    Ok(())
}
