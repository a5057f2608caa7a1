//! Pickles of meshes and frames: numpy arrays, and small tables as JSON.

use crate::arrays;
use crate::boundary::{guard, wrong_value};
use crate::mesh::PyMesh;
use crate::packing::PyPacking;
use crate::response::PyFrame;
use crate::views::cell_type;
use meso_core::math::Vec3;
use meso_core::mesh::{CellKind, Mesh, MeshTable, Notes, Phase, Purpose};
use meso_solve::results::{Moment, Snapshot};
use numpy::{Element, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use std::sync::Arc;

const KINDS: [CellKind; 3] = [CellKind::Tetrahedron, CellKind::QuadraticTetrahedron, CellKind::Hexahedron];
const PHASES: [Phase; 4] = Phase::ALL;

fn damaged(what: &str) -> PyErr {
    wrong_value(format!("the pickle is damaged: {what}"))
}

fn json<T: serde::Serialize>(value: &T) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| wrong_value(error.to_string()))
}

fn from_json<T: for<'de> serde::Deserialize<'de>>(text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| damaged(&error.to_string()))
}

fn vector<T: Element + Copy>(array: &PyReadonlyArray1<'_, T>) -> PyResult<Vec<T>> {
    Ok(array.as_slice()?.to_vec())
}

/// Everything of a mesh: kind, periodic axes, notes, points, cells, phases, owners, ids, cohesive elements and owners.
pub(crate) fn of_mesh<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyTuple>> {
    let points: Vec<f64> = mesh.points.iter().flat_map(|point| [point.x, point.y, point.z]).collect();
    let phases = mesh.phase.iter().map(|&phase| phase as u8).collect();
    let indices = [&mesh.cells, &mesh.owner, &mesh.id_of, &mesh.cohesive, &mesh.cohesive_owner];
    let [cells, owner, id_of, cohesive, below] = indices.map(|numbers| PyArray1::from_slice(py, numbers));
    let (points, phases) = (PyArray1::from_vec(py, points), PyArray1::from_vec(py, phases));
    let head = (cell_type(mesh.kind), mesh.periodic, json(&mesh.notes)?);
    (head, points, cells, phases, owner, id_of, cohesive, below).into_pyobject(py)
}

type Numbers<'py> = PyReadonlyArray1<'py, u32>;
type State<'py> = (
    (String, [bool; 3], String),
    PyReadonlyArray1<'py, f64>,
    Numbers<'py>,
    PyReadonlyArray1<'py, u8>,
    Numbers<'py>,
    Numbers<'py>,
    Numbers<'py>,
    Numbers<'py>,
);

fn to_mesh(state: &Bound<'_, PyTuple>) -> PyResult<Mesh> {
    let ((kind, periodic, notes), points, cells, phases, owner, id_of, cohesive, below): State<'_> = state.extract()?;
    let kind = KINDS.into_iter().find(|known| cell_type(*known) == kind).ok_or_else(|| damaged("kind of cell"))?;
    let phase = |label: &u8| PHASES.into_iter().find(|phase| *phase as u8 == *label);
    let phase: Option<Vec<Phase>> = phases.as_slice()?.iter().map(phase).collect();
    let notes: Notes = from_json(&notes)?;
    let mesh = Mesh {
        points: points.as_slice()?.chunks_exact(3).map(Vec3::from_column_slice).collect(),
        kind,
        cells: vector(&cells)?,
        phase: phase.ok_or_else(|| damaged("phase"))?,
        owner: vector(&owner)?,
        id_of: vector(&id_of)?,
        cohesive: vector(&cohesive)?,
        cohesive_owner: vector(&below)?,
        periodic,
        notes,
    };
    if is_whole(&mesh) { Ok(mesh) } else { Err(damaged("its arrays do not fit each other")) }
}

/// Whether all lengths and indices of a mesh fit each other.
fn is_whole(mesh: &Mesh) -> bool {
    let count = mesh.phase.len();
    let faces = mesh.kind.face_nodes()[0].len();
    let body = |owner: &u32| *owner == Mesh::NO_BODY || (*owner as usize) < mesh.id_of.len();
    mesh.cells.len() == count * mesh.kind.nodes()
        && mesh.owner.len() == count
        && mesh.cohesive.len() == mesh.cohesive_owner.len() * 2 * faces
        && mesh.cells.iter().chain(&mesh.cohesive).all(|node| (*node as usize) < mesh.points.len())
        && mesh.owner.iter().chain(&mesh.cohesive_owner).all(body)
}

/// What makes a mesh again: the function and its arguments.
pub(crate) fn reduce_mesh<'py>(py: Python<'py>, mesh: &PyMesh) -> PyResult<Bound<'py, PyTuple>> {
    let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_mesh")?;
    let PyMesh(mesh, model, options) = mesh;
    let packing = PyPacking(Arc::clone(model)).into_pyobject(py)?;
    (restore, (of_mesh(py, mesh)?, packing, json(options)?)).into_pyobject(py)
}

/// Unpickles a `Mesh`.
#[pyfunction(name = "_restore_mesh")]
pub(crate) fn restore_mesh(
    py: Python<'_>,
    state: &Bound<'_, PyTuple>,
    packing: PyRef<'_, PyPacking>,
    options: &str,
) -> PyResult<PyMesh> {
    arrays::load_numpy(py)?;
    guard(|| {
        let (model, table) = (Arc::clone(&packing.0), from_json::<MeshTable>(options)?);
        let options = table.resolve(Purpose::Mesh, &model.spec.itz).map_err(|error| damaged(&error.to_string()))?;
        Ok(PyMesh(Arc::new(to_mesh(state)?), model, options))
    })
}

/// What makes a frame again: the function and its arguments.
pub(crate) fn reduce_frame<'py>(py: Python<'py>, frame: &PyFrame) -> PyResult<Bound<'py, PyTuple>> {
    let restore = py.import("mesocrete._mesocrete")?.getattr("_restore_frame")?;
    let PyFrame(mesh, fields) = frame;
    let wide = [fields.displacement.as_flattened(), fields.stress.as_flattened()];
    let narrow = [&fields.damage, &fields.tension, &fields.compression, &fields.opening_mm].map(Vec::as_slice);
    let arrays: Vec<_> = wide.into_iter().chain(narrow).map(|values| PyArray1::from_slice(py, values)).collect();
    (restore, (of_mesh(py, mesh)?, json(&fields.moment)?, arrays)).into_pyobject(py)
}

/// Unpickles a `Frame`.
#[pyfunction(name = "_restore_frame")]
pub(crate) fn restore_frame(
    py: Python<'_>,
    state: &Bound<'_, PyTuple>,
    moment: &str,
    fields: [PyReadonlyArray1<'_, f32>; 6],
) -> PyResult<PyFrame> {
    arrays::load_numpy(py)?;
    guard(|| {
        let (mesh, moment): (Mesh, Moment) = (to_mesh(state)?, from_json(moment)?);
        let [displacement, stress, damage, tension, compression, opening_mm] = fields.map(|array| vector(&array));
        let snapshot = Snapshot {
            moment,
            displacement: displacement?.as_chunks().0.to_vec(),
            stress: stress?.as_chunks().0.to_vec(),
            damage: damage?,
            tension: tension?,
            compression: compression?,
            opening_mm: opening_mm?,
        };
        let cells = [&snapshot.damage, &snapshot.tension, &snapshot.compression, &snapshot.opening_mm];
        let fits = snapshot.displacement.len() == mesh.points.len()
            && snapshot.stress.len() == mesh.cell_count()
            && cells.iter().all(|values| values.len() == mesh.cell_count());
        if fits {
            Ok(PyFrame(Arc::new(mesh), Arc::new(snapshot)))
        } else {
            Err(damaged("its fields do not fit its mesh"))
        }
    })
}
