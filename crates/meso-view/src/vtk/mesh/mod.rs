//! Volume meshes as VTK unstructured grids (`.vtu`), for ParaView, PyVista and meshio.
//!
//! Cell data: `phase` (0 mortar, 1 ITZ, 2 aggregate, 4 fibre), `aggregate` (id, -1 in the mortar) and, for tetrahedra,
//! `radius_ratio` and `min_dihedral_deg`. Cohesive elements follow the cells, as wedges (hexahedra between voxels) of the
//! ITZ; they have no volume, and NaN for their quality. Fields of a test have no values there, so its frames leave them out.

mod read;

pub use read::{Stored, Unread};

use super::{Array, Encoding, Grid, Layout, Still};
use meso_mesh::cells::{CellKind, Mesh, Phase, PhaseNames};
use meso_mesh::figures::CellQuality;
use std::collections::BTreeSet;
use std::io::{self, Write};

/// Writes `mesh` with its phases and quality to `out`; `compress` is by zlib.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write(mesh: &Mesh, compress: bool, out: impl Write) -> io::Result<()> {
    let quality = match mesh.kind {
        CellKind::Hexahedron => Vec::new(),
        _ => CellQuality::each(mesh, |q| [q.radius_ratio as f32, q.min_dihedral_deg as f32]),
    };
    let mut cell_data: Vec<Array> = bodies(mesh, Joints::Written).collect();
    if !quality.is_empty() {
        let measure = |name, place: usize| {
            let quality = &quality;
            let joints = mesh.cohesive().len();
            Array::new("Float32", name, quality.len() + joints, move || {
                let values = quality.iter().map(move |of_cell| of_cell[place]);
                values.chain(std::iter::repeat_n(f32::NAN, joints)).map(f32::to_le_bytes)
            })
        };
        cell_data.push(measure("radius_ratio", 0));
        cell_data.push(measure("min_dihedral_deg", 1));
    }
    grid(mesh, Joints::Written, cell_data).write(Encoding::compressed(compress), out)
}

/// Values at the points or in the cells of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Field<'a> {
    /// As a viewer shows it.
    pub name: &'a str,
    /// Values for each point or cell: 1, 3 for vectors, 6 for symmetric tensors (xx yy zz xy yz xz).
    pub components: usize,
    /// All of them, point by point or cell by cell.
    pub values: &'a [f32],
}

/// Writes `mesh` with fields at its points and in its cells, compressed. Viewers display the first
/// of `cells`. The mesh itself is compressed once for all files of a series, whose first one is given an empty `still`.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_fields(
    mesh: &Mesh,
    points: &[Field],
    cells: &[Field],
    still: &mut Still,
    out: impl Write,
) -> io::Result<()> {
    let cell_data = cells.iter().map(Field::array).chain(bodies(mesh, Joints::LeftOut)).collect();
    Grid { point_data: points.iter().map(Field::array).collect(), ..grid(mesh, Joints::LeftOut, cell_data) }
        .write_next(still, out)
}

/// The mesh of a file by [`write_fields`], without cohesive elements, notes and names of phases, and the file's arrays.
///
/// # Errors
/// A file that [`write_fields`] did not write, or that was changed.
pub fn read(bytes: &[u8]) -> Result<(Mesh, Stored<'_>), Unread> {
    let stored = Stored::of(bytes)?;
    let (points, cells) = (stored.points, stored.cells);
    let positions = stored.values(("Float64", "Points"), [3, points], f64::from_le_bytes)?;
    let types = stored.values(("UInt8", "types"), [1, cells], |[kind]| kind)?;
    let kind = match types.first() {
        Some(10) => CellKind::Tetrahedron,
        Some(12) => CellKind::Hexahedron,
        _ => return Err(Unread::Foreign),
    };
    let nodes = kind.nodes().checked_mul(cells).ok_or(Unread::Foreign)?;
    let nodes = stored.values(("Int32", "connectivity"), [1, nodes], u32::from_le_bytes)?;
    let is_known = |label: u8| label < PhaseNames::ROOM as u8 && label != Phase::Void.number();
    let phase = |label: u8| is_known(label).then(|| Phase::numbered(label));
    let phases: Option<Vec<Phase>> =
        stored.values(("UInt8", "phase"), [1, cells], |[label]| phase(label))?.into_iter().collect();
    let ids = stored.values(("Int32", "aggregate"), [1, cells], i32::from_le_bytes)?;
    let id_of: BTreeSet<u32> = ids.iter().filter_map(|id| u32::try_from(*id).ok()).collect();
    let id_of: Vec<u32> = id_of.into_iter().collect();
    let owner = |id: &i32| u32::try_from(*id).ok().and_then(|id| id_of.binary_search(&id).ok());
    let owner = ids.iter().map(|id| owner(id).map_or(Mesh::NO_BODY, |body| body as u32)).collect();
    let is_fit = types.iter().all(|other| *other == types[0]) && nodes.iter().all(|node| (*node as usize) < points);
    if !is_fit || positions.iter().any(|x| !x.is_finite()) {
        return Err(Unread::Damaged("connectivity"));
    }
    let points = positions.as_chunks().0.iter().map(|p: &[f64; 3]| (*p).into()).collect();
    let mesh = Mesh::of(kind, points, nodes, phases.ok_or(Unread::Damaged("phase"))?, owner);
    Ok((Mesh { id_of, ..mesh }, stored))
}

impl<'a> Field<'a> {
    fn array(&self) -> Array<'a> {
        let Self { name, components, values } = *self;
        Array::new("Float32", name, values.len(), || values.iter().map(|value| value.to_le_bytes()))
            .in_groups_of(components)
    }
}

/// The cell data of such a file: VTK's type and the name of every array.
pub fn declared(kind: CellKind) -> &'static [(&'static str, &'static str)] {
    const ALL: [(&str, &str); 4] =
        [("UInt8", "phase"), ("Int32", "aggregate"), ("Float32", "radius_ratio"), ("Float32", "min_dihedral_deg")];
    if kind == CellKind::Hexahedron { &ALL[..2] } else { &ALL }
}

/// Whether cohesive elements are cells of the file.
#[derive(Clone, Copy, PartialEq)]
enum Joints {
    Written,
    LeftOut,
}

impl Joints {
    /// Nodes of the cohesive elements in the file, and the bodies below these.
    fn of(self, mesh: &Mesh) -> (&[u32], &[u32]) {
        match self {
            Self::Written => (&mesh.cohesive, &mesh.cohesive_owner),
            Self::LeftOut => (&[], &[]),
        }
    }
}

/// The phase of every cell, and the body that it belongs to.
fn bodies(mesh: &Mesh, joints: Joints) -> impl Iterator<Item = Array<'_>> {
    let (_, below) = joints.of(mesh);
    let cells = mesh.cell_count() + below.len();
    let phase = Array::new("UInt8", "phase", cells, move || {
        mesh.phase.iter().map(|phase| [phase.number()]).chain(std::iter::repeat_n([Phase::Itz.number()], below.len()))
    });
    let ids = Array::new("Int32", "aggregate", cells, move || {
        mesh.ids().chain(below.iter().map(|&owner| mesh.id(owner))).map(|id| signed(id).to_le_bytes())
    });
    [phase, ids].map(Array::still).into_iter()
}

fn grid<'a>(mesh: &'a Mesh, joints: Joints, cell_data: Vec<Array<'a>>) -> Grid<'a> {
    let (joined, below) = joints.of(mesh);
    let (nodes, solids, joints) = (mesh.kind.nodes() as i64, mesh.cell_count() as i64, below.len() as i64);
    let (kind, joint) = match mesh.kind {
        CellKind::Tetrahedron => (10, 13),
        CellKind::QuadraticTetrahedron => (24, 13),
        CellKind::Hexahedron => (12, 12),
    };
    let of_joint = joined.len() as i64 / joints.max(1);
    let positions = || mesh.points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f64::to_le_bytes);
    let cells = (solids + joints) as usize;
    Grid {
        layout: Layout::Cells,
        points: mesh.points.len(),
        cells,
        positions: Array::new("Float64", "Points", 3 * mesh.points.len(), positions).of_vectors().still(),
        topology: [
            Array::new("Int32", "connectivity", mesh.cells.len() + joined.len(), move || {
                mesh.cells.iter().chain(joined).map(|node| node.to_le_bytes())
            }),
            Array::new("Int64", "offsets", cells, move || {
                let of_joints = (1..=joints).map(move |joint| solids * nodes + joint * of_joint);
                (1..=solids).map(move |cell| cell * nodes).chain(of_joints).map(i64::to_le_bytes)
            }),
            Array::new("UInt8", "types", cells, move || {
                std::iter::repeat_n([kind], solids as usize).chain(std::iter::repeat_n([joint], joints as usize))
            }),
        ]
        .map(Array::still),
        point_data: Vec::new(),
        cell_data,
    }
}

fn signed(aggregate: u32) -> i32 {
    if aggregate == Mesh::NO_BODY { -1 } else { aggregate as i32 }
}
