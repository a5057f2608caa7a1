//! Specimens from STL files, put into the spec as if their triangles had been written there.

use super::messages::found;
use super::tree::{Node, Value};
use super::{Reading, SpecError};
use meso_collision::geometry::TriangleMesh;
use meso_concrete::import::stl;
use meso_concrete::watch::Stage;

const KEY: &str = "specimen.file";

/// Replaces `file` in `specimen` by the corners and triangles of the STL it names.
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
        let error = SpecError::value(KEY, "must be the name of an STL file in quotes");
        return Err(SpecError { is_wrong_type: true, line, ..error });
    };
    let mesh = read(&name, reading)
        .map_err(|reason| SpecError { line, ..SpecError::value(KEY, format!("is {name:?}: {reason}")) })?;
    let vertices = mesh.vertices.iter().map(|v| Node::list(v.iter().map(|&x| Value::Float(x)))).collect();
    let triangles = mesh.triangles.iter().map(|t| Node::list(t.iter().map(|&i| Value::Integer(i.into())))).collect();
    if let Value::Table(entries) = &mut specimen.value {
        entries.push(("vertices_mm".to_owned(), Node { value: Value::Array(vertices), line }));
        entries.push(("triangles".to_owned(), Node { value: Value::Array(triangles), line }));
    }
    Ok(())
}

/// The closed surface in a file; one whose triangles are all clockwise is turned.
fn read(name: &str, reading: &mut Reading<'_>) -> Result<TriangleMesh, String> {
    let bytes = reading.files.read(name).map_err(|error| error.to_string())?;
    // Shares of the time that a million triangles take; see `Triangulated::crossing` for the rest.
    reading.watch.stage(Stage::Read, 0.02);
    let mut mesh = stl::read(&bytes).map_err(|error| error.to_string())?;
    reading.watch.stage(Stage::Read, 0.12);
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
    }
    mesh.check_closed().map_err(|error| error.to_string())?;
    reading.watch.stage(Stage::Read, 0.2);
    Ok(mesh)
}
