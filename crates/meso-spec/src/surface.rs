//! Specimens from surface files, put into the spec as if their triangles had been written there.

use super::library::SPECK;
use super::limits::{MAX_LENGTH_MM, MIN_LENGTH_MM, within};
use super::messages::{found, number};
use super::tree::{Node, Value};
use super::{Reading, SpecError};
use meso_collision::geometry::{SurfaceError, TriangleMesh};
use meso_collision::math::Aabb;
use meso_concrete::import::{self, Imported};
use meso_concrete::specimen::{ContainerError, Specimen};
use meso_concrete::watch::{Stage, Waiting};

const KEY: &str = "specimen.file";

/// Replaces `file` and `scale` in `specimen` by the corners and triangles of the file.
pub(super) fn inline(tree: &mut Node, reading: &mut Reading<'_>) -> Result<(), SpecError> {
    let Some(specimen) = tree.child_mut("specimen") else { return Ok(()) };
    let Some(kind) = specimen.child("kind") else { return Ok(()) };
    let Value::Text(name) = &kind.value else {
        // serde takes a number for the position of the kind in its list, which is nobody's business.
        let message = format!("is {}; it must be a name in quotes", found(&kind.unexpected()));
        let error = SpecError::value("specimen.kind", message);
        return Err(SpecError { is_wrong_type: true, line: kind.line, ..error });
    };
    if name != "mesh" {
        return Ok(());
    }
    let Some((_, Node { value, line })) = specimen.take("file") else { return Ok(()) };
    let Value::Text(name) = value else {
        let error = SpecError::value(KEY, "must be the name of a surface file (STL, PLY, OBJ, OFF) in quotes");
        return Err(SpecError { is_wrong_type: true, line, ..error });
    };
    let scale = scale(specimen)?;
    let mesh = read(&name, scale, reading)
        .map_err(|reason| SpecError { line, ..SpecError::value(KEY, format!("is {name:?}: {reason}")) })?;
    let vertices = mesh.vertices.iter().map(|v| Node::list(v.iter().map(|&x| Value::Float(x)))).collect();
    let triangles = mesh.triangles.iter().map(|t| Node::list(t.iter().map(|&i| Value::Integer(i.into())))).collect();
    if let Value::Table(entries) = &mut specimen.value {
        entries.push(("vertices_mm".to_owned(), Node { value: Value::Array(vertices), line }));
        entries.push(("triangles".to_owned(), Node { value: Value::Array(triangles), line }));
    }
    Ok(())
}

/// Millimetres in a unit of the file; 1 by default.
fn scale(specimen: &mut Node) -> Result<f64, SpecError> {
    const KEY: &str = "specimen.scale";
    let Some((_, node)) = specimen.take("scale") else { return Ok(1.0) };
    let value = match node.value {
        Value::Integer(n) => n as f64,
        Value::Float(x) => x,
        _ => {
            let message =
                format!("is {}; it must be a number: 1000 for metres, 25.4 for inches", found(&node.unexpected()));
            return Err(SpecError { is_wrong_type: true, line: node.line, ..SpecError::value(KEY, message) });
        }
    };
    within(KEY, value, MIN_LENGTH_MM, MAX_LENGTH_MM).map_err(|error| SpecError { line: node.line, ..error })?;
    Ok(value)
}

/// The closed surface in a file; one whose triangles are all clockwise is turned.
fn read(name: &str, scale: f64, reading: &mut Reading<'_>) -> Result<TriangleMesh, String> {
    let bytes = reading.files.read(name).map_err(|error| error.to_string())?;
    // Shares of the time that a million triangles take; see `Triangulated::crossing` for the rest.
    reading.watch.stage(Stage::Read, 0.02);
    let Imported { mut mesh, edges, notes } = import::read(name, &bytes).map_err(|error| error.to_string())?;
    reading.watch.stage(Stage::Read, 0.12);
    notes.iter().for_each(|note| reading.files.remark(name, note));
    edges.map_err(|error| error.to_string())?;
    let volume = mesh.volume();
    if volume == 0.0 || volume.is_nan() {
        return Err(SurfaceError::NoVolume { volume }.to_string());
    }
    if volume < 0.0 {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    mesh.vertices.iter_mut().for_each(|vertex| *vertex *= scale);
    let mesh = without_specks(name, mesh, reading);
    reading.watch.stage(Stage::Read, 0.2);
    let mesh = without_flat(name, mesh, reading);
    moved(name, &mesh, reading);
    Ok(mesh)
}

/// A surface without its specks, with a remark about how many bodies it has. Hollows stay, whatever their size.
fn without_specks(name: &str, mesh: TriangleMesh, reading: &mut Reading<'_>) -> TriangleMesh {
    let connected = mesh.component_of();
    if connected.iter().all(|first| *first == connected[0]) {
        return mesh;
    }
    let parts = mesh.components();
    let volumes: Vec<f64> = parts.iter().map(TriangleMesh::volume).collect();
    let bodies = volumes.iter().filter(|volume| **volume > 0.0).count();
    let largest = volumes.iter().copied().fold(0.0, f64::max);
    let is_speck = |volume: f64| volume > 0.0 && volume < SPECK * largest;
    let specks = volumes.iter().filter(|volume| is_speck(**volume)).count();
    if specks == 0 {
        if bodies > 1 {
            reading.files.remark(name, &format!("it has {bodies} bodies, which are one specimen together"));
        }
        return mesh;
    }
    let left = bodies - specks;
    let remark = format!(
        "it has {bodies} bodies: {specks} below {SPECK} of the volume of the largest were dropped, as scans have specks; {left} left"
    );
    reading.files.remark(name, &remark);
    let kept = parts.iter().zip(&volumes).filter(|(_, volume)| !is_speck(**volume)).map(|(part, _)| part);
    let mut all = TriangleMesh { vertices: Vec::new(), triangles: Vec::new() };
    for part in kept {
        let first = all.vertices.len() as u32;
        all.vertices.extend(&part.vertices);
        all.triangles.extend(part.triangles.iter().map(|triangle| triangle.map(|corner| first + corner)));
    }
    all
}

/// A surface that crosses itself, without its flat triangles if there are some: these lie upon their neighbours' edges.
fn without_flat(name: &str, mesh: TriangleMesh, reading: &mut Reading<'_>) -> TriangleMesh {
    let Some((mended, count)) = import::without_flat_triangles(&mesh) else { return mesh };
    let specimen = Specimen::Mesh {
        vertices_mm: mesh.vertices.iter().map(|v| (*v).into()).collect(),
        triangles: mesh.triangles.clone(),
        built: Default::default(),
    };
    let deadline = reading.time_limit_s.map_or(f64::INFINITY, |limit| reading.watch.began() + limit);
    match specimen.check_while(Waiting { watch: reading.watch, deadline }) {
        Err(ContainerError::Crossing { .. }) => {
            reading.files.remark(name, &format!("{count} triangle(s) without area were removed"));
            mended
        }
        _ => mesh,
    }
}

/// Least move that is worth a remark, as a share of the surface's size: below it a file means the origin, and rounds.
const MOVE: f64 = 1e-6;

/// Remarks on the move of a surface whose lowest corner is not the origin.
fn moved(name: &str, mesh: &TriangleMesh, reading: &mut Reading<'_>) {
    let aabb = Aabb::around(&mesh.vertices);
    if aabb.min.amax() > MOVE * aabb.size().amax() {
        let [x, y, z] = <[f64; 3]>::from(aabb.min).map(number);
        let remark = format!("its lowest corner, ({x}, {y}, {z}) mm, is the origin of the packing");
        reading.files.remark(name, &remark);
    }
}
