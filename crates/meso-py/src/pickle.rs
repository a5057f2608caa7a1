//! Contents of pickles: models as saved, meshes as numpy arrays, small tables as JSON.

use crate::boundary::{mesh_error, wrong_value};
use crate::views::cell_type;
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::Itz;
use meso_core::math::Vec3;
use meso_core::mesh::{CellKind, Mesh, MeshTable, Notes, Phase, Purpose};
use meso_core::{Model, saved};
use meso_solve::results::{Snapshot, Source};
use meso_solve::{Extra, Response, Row, Summary};
use numpy::{Element, PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

const KINDS: [CellKind; 3] = [CellKind::Tetrahedron, CellKind::QuadraticTetrahedron, CellKind::Hexahedron];

/// Error of a pickle that holds nothing of ours.
pub(crate) fn damaged(what: &str) -> PyErr {
    wrong_value(format!("the pickle is damaged: {what}"))
}

pub(crate) fn json<T: serde::Serialize>(value: &T) -> PyResult<String> {
    serde_json::to_string(value).map_err(|error| wrong_value(error.to_string()))
}

pub(crate) fn from_json<T: for<'de> serde::Deserialize<'de>>(text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| damaged(&error.to_string()))
}

pub(crate) fn vector<T: Element + Copy>(array: &PyReadonlyArray1<'_, T>) -> PyResult<Vec<T>> {
    Ok(array.as_slice()?.to_vec())
}

/// Everything of a mesh: kind, periodic axes, notes, points, cells, phases, owners, ids, cohesive elements and owners.
pub(crate) fn of_mesh<'py>(py: Python<'py>, mesh: &Mesh) -> PyResult<Bound<'py, PyTuple>> {
    let points: Vec<f64> = mesh.points.iter().flat_map(|point| [point.x, point.y, point.z]).collect();
    let phases = mesh.phase.iter().map(|phase| phase.number()).collect();
    let indices = [&mesh.cells, &mesh.owner, &mesh.id_of, &mesh.cohesive, &mesh.cohesive_owner];
    let [cells, owner, id_of, cohesive, below] = indices.map(|numbers| PyArray1::from_slice(py, numbers));
    let (points, phases) = (PyArray1::from_vec(py, points), PyArray1::from_vec(py, phases));
    let names: Vec<&str> = mesh.phases.own().map(|phase| mesh.phases.name(phase)).collect();
    let head = (cell_type(mesh.kind), mesh.periodic, json(&mesh.notes)?, names);
    (head, points, cells, phases, owner, id_of, cohesive, below).into_pyobject(py)
}

type Numbers<'py> = PyReadonlyArray1<'py, u32>;
type State<'py> = (
    (String, [bool; 3], String, Vec<String>),
    PyReadonlyArray1<'py, f64>,
    Numbers<'py>,
    PyReadonlyArray1<'py, u8>,
    Numbers<'py>,
    Numbers<'py>,
    Numbers<'py>,
    Numbers<'py>,
);

pub(crate) fn to_mesh(state: &Bound<'_, PyTuple>) -> PyResult<Mesh> {
    let ((kind, periodic, notes, names), points, cells, phases, owner, id_of, cohesive, below): State<'_> =
        state.extract()?;
    let kind = KINDS.into_iter().find(|known| cell_type(*known) == kind).ok_or_else(|| damaged("kind of cell"))?;
    let names: PhaseNames = names.into_iter().collect();
    let phase = |label: &u8| names.solid().find(|phase| phase.number() == *label);
    let phase: Option<Vec<Phase>> = phases.as_slice()?.iter().map(phase).collect();
    let notes: Notes = from_json(&notes)?;
    let phase = phase.ok_or_else(|| damaged("phase"))?;
    let mesh = Mesh {
        points: points.as_slice()?.chunks_exact(3).map(Vec3::from_column_slice).collect(),
        kind,
        cells: vector(&cells)?,
        phase,
        owner: vector(&owner)?,
        id_of: vector(&id_of)?,
        cohesive: vector(&cohesive)?,
        cohesive_owner: vector(&below)?,
        periodic,
        phases: names,
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

/// A model: the bytes of a saved one, which names its version, and its report with the seconds.
pub(crate) fn of_model<'py>(py: Python<'py>, model: &Model) -> PyResult<(Bound<'py, PyBytes>, String)> {
    let mut bytes = Vec::new();
    saved::write(model, &mut bytes)?;
    Ok((PyBytes::new(py, &bytes), json(&model.report)?))
}

pub(crate) fn to_model(py: Python<'_>, model: &[u8], report: &str) -> PyResult<Model> {
    let read = py.detach(|| saved::read(model)).map_err(|error| damaged(&error.to_string()))?;
    Ok(Model { report: from_json(report)?, ..read })
}

/// Fields of a moment: the moment, displacements, stresses, strains of cracks, three kinds of damage, openings, shares of
/// the stiffness, and factors of strengths.
pub(crate) type Fields<'py> = (String, [PyReadonlyArray1<'py, f32>; 9]);

pub(crate) fn of_snapshot<'py>(py: Python<'py>, fields: &Snapshot) -> PyResult<Bound<'py, PyTuple>> {
    let six = [&fields.stress, &fields.crack_strain].map(|six| six.as_flattened());
    let Snapshot { damage, tension, compression, opening_mm, stiffness_left, strength, .. } = fields;
    let narrow = [damage, tension, compression, opening_mm, stiffness_left, strength].map(Vec::as_slice);
    let wide = std::iter::once(fields.displacement.as_flattened()).chain(six);
    let arrays: Vec<_> = wide.chain(narrow).map(|values| PyArray1::from_slice(py, values)).collect();
    (json(&fields.moment)?, arrays).into_pyobject(py)
}

pub(crate) fn to_snapshot(mesh: &Mesh, (moment, fields): Fields<'_>) -> PyResult<Snapshot> {
    let [displacement, stress, strain, damage, tension, compression, opening_mm, left, strength] =
        fields.map(|array| vector(&array));
    let snapshot = Snapshot {
        moment: from_json(&moment)?,
        displacement: displacement?.as_chunks().0.to_vec(),
        stress: stress?.as_chunks().0.to_vec(),
        damage: damage?,
        tension: tension?,
        compression: compression?,
        opening_mm: opening_mm?,
        strength: strength?,
        stiffness_left: left?,
        crack_strain: strain?.as_chunks().0.to_vec(),
    };
    let Snapshot { damage, tension, compression, opening_mm, stiffness_left, .. } = &snapshot;
    let cells = [damage, tension, compression, opening_mm, stiffness_left];
    let six = [&snapshot.stress, &snapshot.crack_strain];
    let fits = snapshot.displacement.len() == mesh.points.len()
        && six.iter().all(|values| values.len() == mesh.cell_count())
        && [0, mesh.cell_count()].contains(&snapshot.strength.len())
        && cells.iter().all(|values| values.len() == mesh.cell_count());
    if fits { Ok(snapshot) } else { Err(damaged("its fields do not fit its mesh")) }
}

/// A curve and its figures, from the values of its rows and those of its further columns.
pub(crate) fn to_response(
    rows: &PyReadonlyArray1<'_, f64>,
    extra: &PyReadonlyArray1<'_, f64>,
    figures: &str,
) -> PyResult<Response> {
    let result: Summary = from_json(figures)?;
    let curve: Vec<Row> = rows.as_slice()?.as_chunks().0.iter().map(|values| Row::from_values(*values)).collect();
    let extra = Extra { names: result.columns.clone(), values: vector(extra)? };
    if extra.values.len() == curve.len() * extra.names.len() {
        Ok(Response { curve, extra, result })
    } else {
        Err(damaged("its columns do not fit its curve"))
    }
}

/// Source of a tested mesh: version, seed, fraction and options.
pub(crate) fn of_source(source: &Source) -> PyResult<(&str, u64, f64, String)> {
    Ok((&source.version, source.seed, source.fraction, json(&source.mesh)?))
}

pub(crate) fn to_source((version, seed, fraction, options): (String, u64, f64, String)) -> PyResult<Source> {
    // The table names its ITZ, so that of the packing has no say.
    let mesh = from_json::<MeshTable>(&options)?.resolve(Purpose::Mesh, &Itz::default()).map_err(mesh_error)?;
    Ok(Source { version, seed, fraction, mesh })
}
