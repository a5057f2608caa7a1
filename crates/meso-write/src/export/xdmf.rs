//! Volume meshes as XDMF 3 in one file, its numbers as text: ParaView, meshio, and through meshio FEniCSx.
//!
//! Cell data: `phase` (0 mortar, 1 ITZ, 2 aggregate, 4 fibre) and `aggregate` (id, -1 in the mortar). Cohesive elements
//! follow the cells, as wedges (hexahedra between voxels) of the ITZ.

use super::lines::Lines;
use meso_mesh::cells::{CellKind, Mesh, Phase};
use std::io::{self, Write};

/// Name of a topology, and its number among mixed cells.
fn topology(kind: CellKind) -> (&'static str, u64) {
    match kind {
        CellKind::Tetrahedron => ("Tetrahedron", 6),
        CellKind::QuadraticTetrahedron => ("Tetrahedron_10", 0x26),
        CellKind::Hexahedron => ("Hexahedron", HEXAHEDRON),
    }
}

const WEDGE: u64 = 8;
const HEXAHEDRON: u64 = 9;

/// Writes `mesh` to `out`, streamed.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(mesh: &Mesh, out: impl Write) -> io::Result<()> {
    let mut lines = Lines::new(out);
    let (points, cells) = (mesh.points.len(), mesh.cell_count() + mesh.cohesive_owner.len());
    lines.line("<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\"><Domain><Grid Name=\"mesocrete\">")?;
    lines.line(format!("<Geometry GeometryType=\"XYZ\">{}", item(&format!("{points} 3"), "Float", 8)))?;
    mesh.points.iter().try_for_each(|p| lines.line(format!("{:?} {:?} {:?}", p.x, p.y, p.z)))?;
    lines.line("</DataItem></Geometry>")?;
    cells_of(&mut lines, mesh)?;
    lines.line("</DataItem></Topology>")?;
    attribute(&mut lines, "phase", cells, ("UInt", 1))?;
    let joints = mesh.cohesive_owner.len();
    let phases = mesh.phase.iter().copied().chain(std::iter::repeat_n(Phase::Itz, joints));
    phases.into_iter().try_for_each(|phase| row(&mut lines, None, &[phase.number().into()]))?;
    lines.line("</DataItem></Attribute>")?;
    attribute(&mut lines, "aggregate", cells, ("Int", 4))?;
    let ids = mesh.ids().chain(mesh.cohesive_owner.iter().map(|&owner| mesh.id(owner)));
    for id in ids {
        if id == Mesh::NO_BODY { lines.line("-1")? } else { row(&mut lines, None, &[id])? }
    }
    lines.line("</DataItem></Attribute>\n</Grid></Domain></Xdmf>")?;
    lines.finish()
}

/// Opens the data of an array.
fn item(dimensions: &str, number: &str, precision: u8) -> String {
    format!("<DataItem Dimensions=\"{dimensions}\" NumberType=\"{number}\" Precision=\"{precision}\" Format=\"XML\">")
}

fn attribute(lines: &mut Lines<impl Write>, name: &str, cells: usize, number: (&str, u8)) -> io::Result<()> {
    let data = item(&cells.to_string(), number.0, number.1);
    lines.line(format!("<Attribute Name=\"{name}\" AttributeType=\"Scalar\" Center=\"Cell\">{data}"))
}

/// Node numbers of the cells; among cells of two kinds, each after the number of its kind.
fn cells_of(lines: &mut Lines<impl Write>, mesh: &Mesh) -> io::Result<()> {
    let (name, number) = topology(mesh.kind);
    let (cells, joints, nodes) = (mesh.cell_count(), mesh.cohesive_owner.len(), mesh.kind.nodes());
    let is_mixed = joints > 0 && mesh.kind != CellKind::Hexahedron;
    let of_joint = if mesh.kind == CellKind::Hexahedron { HEXAHEDRON } else { WEDGE };
    let (name, dimensions) = if is_mixed {
        ("Mixed", (mesh.cells.len() + mesh.cohesive.len() + cells + joints).to_string())
    } else {
        (name, format!("{} {nodes}", cells + joints))
    };
    let data = item(&dimensions, "Int", 4);
    lines.line(format!("<Topology TopologyType=\"{name}\" NumberOfElements=\"{}\">{data}", cells + joints))?;
    mesh.cells().try_for_each(|cell| row(lines, is_mixed.then_some(number), cell))?;
    mesh.cohesive().try_for_each(|joint| row(lines, is_mixed.then_some(of_joint), joint))
}

fn row(lines: &mut Lines<impl Write>, kind: Option<u64>, nodes: &[u32]) -> io::Result<()> {
    if let Some(kind) = kind {
        lines.integer(1, kind);
        lines.text(1, " ");
    }
    for (i, &node) in nodes.iter().enumerate() {
        if i > 0 {
            lines.text(1, " ");
        }
        lines.integer(1, u64::from(node));
    }
    lines.end()
}
