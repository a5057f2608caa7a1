//! Aggregate surfaces as polygons in a VTK unstructured grid (`.vtu`), what ParaView, PyVista and meshio read.
//!
//! Binary appended, little-endian, array sizes counted in 64 bits. Cell data: `aggregate` (id), `class`, `phase` (2),
//! `itz_thickness_mm`. VTK, PyVista and meshio all read raw appended data; meshio wants the offsets unpadded and in the
//! order of the arrays, and one line break after the last.

use crate::aggregate::Aggregate;
use crate::geometry::Face;
use crate::mesh::Phase;
use std::io::{self, BufWriter, Write};

/// VTK's number of a polygon cell.
const POLYGON: u8 = 7;

/// Writes the outer surfaces of `aggregates` to `out`, one polygon per face.
///
/// # Errors
/// Those of `out`; more points than 32-bit node numbers reach.
pub fn write(aggregates: &[Aggregate], out: impl Write) -> io::Result<()> {
    let size = Size::of(aggregates);
    if size.points > i32::MAX as usize {
        return Err(io::Error::other("a .vtu of surfaces holds at most 2147483647 points"));
    }
    let mut out = BufWriter::new(out);
    header(&size, &mut out)?;
    out.write_all(b"<AppendedData encoding=\"raw\">\n_")?;
    data(aggregates, &size, &mut out)?;
    out.write_all(b"\n</AppendedData>\n</VTKFile>\n")?;
    out.flush()
}

/// Lengths of the arrays.
struct Size {
    points: usize,
    cells: usize,
    corners: usize,
}

impl Size {
    fn of(aggregates: &[Aggregate]) -> Self {
        let sum = |count: fn(&Aggregate) -> usize| aggregates.iter().map(count).sum();
        Self {
            points: sum(|a| a.body.vertices().len()),
            cells: sum(|a| a.body.faces().len()),
            corners: sum(|a| a.body.faces().map(Face::len).sum()),
        }
    }
}

/// The arrays' declarations; each begins where the one before it, with its 8 bytes of size, ends.
fn header(size: &Size, out: &mut impl Write) -> io::Result<()> {
    let Size { points, cells, corners } = *size;
    let mut offset = 0;
    let mut array = |kind: &str, name: &str, components: usize, bytes: usize| {
        let begin = offset;
        offset += 8 + bytes;
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{begin}\"/>\n"
        )
    };
    out.write_all(b"<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" ")?;
    out.write_all(b"byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n")?;
    writeln!(out, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">")?;
    write!(out, "<Points>\n{}</Points>\n", array("Float64", "Points", 3, 24 * points))?;
    write!(out, "<Cells>\n{}", array("Int32", "connectivity", 1, 4 * corners))?;
    write!(out, "{}", array("Int64", "offsets", 1, 8 * cells))?;
    write!(out, "{}</Cells>\n<CellData Scalars=\"aggregate\">\n", array("UInt8", "types", 1, cells))?;
    write!(out, "{}", array("Int32", "aggregate", 1, 4 * cells))?;
    write!(out, "{}", array("Int32", "class", 1, 4 * cells))?;
    write!(out, "{}", array("UInt8", "phase", 1, cells))?;
    write!(out, "{}", array("Float64", "itz_thickness_mm", 1, 8 * cells))?;
    writeln!(out, "</CellData>\n</Piece>\n</UnstructuredGrid>")
}

/// The arrays in the order of [`header`].
fn data(aggregates: &[Aggregate], size: &Size, out: &mut impl Write) -> io::Result<()> {
    let points = aggregates.iter().flat_map(|a| a.body.vertices()).flat_map(|v| [v.x, v.y, v.z]);
    array(out, 24 * size.points, points.map(f64::to_le_bytes))?;
    connectivity(aggregates, size, out)?;
    let mut end = 0;
    let ends = aggregates.iter().flat_map(|a| a.body.faces()).map(|face| {
        end += face.len() as i64;
        end.to_le_bytes()
    });
    array(out, 8 * size.cells, ends)?;
    array(out, size.cells, std::iter::repeat_n([POLYGON], size.cells))?;
    array(out, 4 * size.cells, per_face(aggregates, |a| (a.id as i32).to_le_bytes()))?;
    array(out, 4 * size.cells, per_face(aggregates, |a| i32::from(a.class).to_le_bytes()))?;
    array(out, size.cells, std::iter::repeat_n([Phase::Aggregate as u8], size.cells))?;
    array(out, 8 * size.cells, per_face(aggregates, |a| a.itz_thickness_mm.to_le_bytes()))
}

/// The faces' node numbers: every aggregate brings its own points.
fn connectivity(aggregates: &[Aggregate], size: &Size, out: &mut impl Write) -> io::Result<()> {
    let mut first = 0;
    let nodes = aggregates.iter().flat_map(|aggregate| {
        let offset = first;
        first += aggregate.body.vertices().len() as i32;
        aggregate.body.faces().flat_map(Face::iter).map(move |i| (offset + i as i32).to_le_bytes())
    });
    array(out, 4 * size.corners, nodes)
}

fn per_face<const N: usize>(
    aggregates: &[Aggregate],
    value: impl Fn(&Aggregate) -> [u8; N],
) -> impl Iterator<Item = [u8; N]> {
    aggregates.iter().flat_map(move |a| std::iter::repeat_n(value(a), a.body.faces().len()))
}

/// One array: its size in bytes, then its values.
fn array<const N: usize>(out: &mut impl Write, bytes: usize, values: impl Iterator<Item = [u8; N]>) -> io::Result<()> {
    out.write_all(&(bytes as u64).to_le_bytes())?;
    for value in values {
        out.write_all(&value)?;
    }
    Ok(())
}
