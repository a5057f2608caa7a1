//! Aggregate surfaces as polygons for ParaView, PyVista and meshio: a VTK unstructured grid (`.vtu`) or poly data (`.vtp`).
//!
//! Cell data: `aggregate` (id), `class`, `phase` (2 aggregate, 3 void, 4 fibre), `itz_thickness_mm`.

use meso_collision::geometry::Face;
use meso_concrete::aggregate::Aggregate;
use meso_view::vtk::{Array, Encoding, Grid, Layout};
use std::io::{self, Write};

/// VTK's number of a polygon cell.
const POLYGON: u8 = 7;

/// Writes the outer surfaces of `aggregates` to `out`, one polygon per face.
///
/// # Errors
/// Fails with the errors of `out`; more points than 32-bit node numbers reach.
pub(crate) fn write(aggregates: &[Aggregate], encoding: Encoding, out: impl Write) -> io::Result<()> {
    write_as(Layout::Cells, aggregates, encoding, out)
}

/// Writes the aggregates' surfaces as VTK poly data (`.vtp`).
///
/// # Errors
/// Fails like [`write`].
pub(crate) fn write_polygons(aggregates: &[Aggregate], encoding: Encoding, out: impl Write) -> io::Result<()> {
    write_as(Layout::Polygons, aggregates, encoding, out)
}

fn write_as(layout: Layout, aggregates: &[Aggregate], encoding: Encoding, out: impl Write) -> io::Result<()> {
    let sum = |count: fn(&Aggregate) -> usize| -> usize { aggregates.iter().map(count).sum() };
    let points = sum(|a| a.body.vertices().len());
    if points > i32::MAX as usize {
        return Err(io::Error::other("a file of VTK surfaces holds at most 2147483647 points"));
    }
    let (faces, corners) = (sum(|a| a.body.faces().len()), sum(|a| a.body.faces().map(Face::len).sum()));
    let positions =
        || aggregates.iter().flat_map(|a| a.body.vertices()).flat_map(|v| [v.x, v.y, v.z]).map(f64::to_le_bytes);
    let grid = Grid {
        layout,
        points,
        cells: faces,
        positions: Array::new("Float64", "Points", 3 * points, positions).of_vectors(),
        topology: [
            Array::new("Int32", "connectivity", corners, || connectivity(aggregates)),
            Array::new("Int64", "offsets", faces, || offsets(aggregates)),
            Array::new("UInt8", "types", faces, || std::iter::repeat_n([POLYGON], faces)),
        ],
        point_data: Vec::new(),
        cell_data: vec![
            Array::new("Int32", "aggregate", faces, || per_face(aggregates, |a| (a.id as i32).to_le_bytes())),
            Array::new("Int32", "class", faces, || per_face(aggregates, |a| i32::from(a.class).to_le_bytes())),
            Array::new("UInt8", "phase", faces, || per_face(aggregates, |a| [a.phase().number()])),
            Array::new("Float64", "itz_thickness_mm", faces, || {
                per_face(aggregates, |a| a.itz_thickness_mm.to_le_bytes())
            }),
        ],
    };
    grid.write(encoding, out)
}

/// The faces' node numbers: every aggregate brings its own points.
fn connectivity(aggregates: &[Aggregate]) -> impl Iterator<Item = [u8; 4]> {
    let mut first = 0;
    aggregates.iter().flat_map(move |aggregate| {
        let offset = first;
        first += aggregate.body.vertices().len() as i32;
        aggregate.body.faces().flat_map(Face::iter).map(move |i| (offset + i as i32).to_le_bytes())
    })
}

/// Where every face's node numbers end.
fn offsets(aggregates: &[Aggregate]) -> impl Iterator<Item = [u8; 8]> {
    let mut end = 0;
    aggregates.iter().flat_map(|a| a.body.faces()).map(move |face| {
        end += face.len() as i64;
        end.to_le_bytes()
    })
}

fn per_face<const N: usize>(
    aggregates: &[Aggregate],
    value: impl Fn(&Aggregate) -> [u8; N],
) -> impl Iterator<Item = [u8; N]> {
    aggregates.iter().flat_map(move |a| std::iter::repeat_n(value(a), a.body.faces().len()))
}
