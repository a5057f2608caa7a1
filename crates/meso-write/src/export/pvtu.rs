//! Large meshes in pieces (`.pvtu`): an index that names `.vtu` files beside it, which ParaView reads at the same time.
//!
//! A piece has its own nodes; those between two pieces are in both. Cohesive elements are shared out like cells.

use super::vtu_mesh;
use meso_concrete::parallel;
use meso_mesh::cells::Mesh;
use rayon::prelude::*;
use std::io::{self, Write};
use std::ops::Range;

/// Most cells of a piece: some 50 MB, raw.
pub(crate) const PIECE_CELLS: usize = 500_000;

/// Number of pieces of `mesh`, at least one.
pub(crate) fn pieces(mesh: &Mesh) -> usize {
    mesh.cell_count().div_ceil(PIECE_CELLS).max(1)
}

/// Piece `index` of `mesh`.
pub(crate) fn piece(mesh: &Mesh, index: usize) -> Mesh {
    // Equal shares, so that no piece is a rest.
    let share = |count: usize| index * count / pieces(mesh)..(index + 1) * count / pieces(mesh);
    part(mesh, share(mesh.cell_count()), share(mesh.cohesive_owner.len()))
}

fn part(mesh: &Mesh, range: Range<usize>, joints: Range<usize>) -> Mesh {
    let (width, of_joint) = (mesh.kind.nodes(), 2 * mesh.kind.faces()[0].len());
    let cells = &mesh.cells[width * range.start..width * range.end];
    let cohesive = &mesh.cohesive[of_joint * joints.start..of_joint * joints.end];
    let mut nodes = [cells, cohesive].concat();
    nodes.par_sort_unstable();
    nodes.dedup();
    let number = |node: &u32| nodes.partition_point(|other| other < node) as u32;
    let points = nodes.iter().map(|&node| mesh.points[node as usize]).collect();
    let (phase, owner) = (mesh.phase[range.clone()].to_vec(), mesh.owner[range].to_vec());
    let part = Mesh::of(mesh.kind, points, parallel::map_short(cells.len(), |k| number(&cells[k])), phase, owner);
    let cohesive = parallel::map_short(cohesive.len(), |k| number(&cohesive[k]));
    Mesh { id_of: mesh.id_of.clone(), cohesive, cohesive_owner: mesh.cohesive_owner[joints].to_vec(), ..part }
}

/// Writes the index of the pieces of `mesh`, which are the files `names` beside it.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(mesh: &Mesh, names: &[String], mut out: impl Write) -> io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    write!(out, "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" ")?;
    writeln!(out, "header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">")?;
    writeln!(out, "<PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n</PPoints>")?;
    writeln!(out, "<PCellData Scalars=\"phase\">")?;
    for (kind, name) in vtu_mesh::declared(mesh.kind) {
        writeln!(out, "<PDataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"1\"/>")?;
    }
    writeln!(out, "</PCellData>")?;
    names.iter().try_for_each(|name| writeln!(out, "{}", entry(name)))?;
    writeln!(out, "</PUnstructuredGrid>\n</VTKFile>")
}

/// The entry of a piece with this name.
pub(crate) fn entry(name: &str) -> String {
    format!("<Piece Source=\"{}\"/>", escaped(name))
}

/// Escapes the characters of a file's name that XML does not allow.
fn escaped(name: &str) -> String {
    name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
