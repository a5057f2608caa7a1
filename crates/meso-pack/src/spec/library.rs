//! Grain libraries from surface and JSON files, put into the spec as if their vertices had been written there.

use super::SpecError;
use super::files::Files;
use super::messages::found;
use super::tree::{Node, Value};
use crate::distinct;
use meso_collision::geometry::{TriangleMesh, convex_hull};
use meso_collision::math::Vec3;
use meso_concrete::import;
use serde::Deserialize;

const KEY: &str = "shape.library";
const HULL: &str = "shape.hull";
/// A surface that holds less than this share of its hull is not convex; coordinates in f32 dent a convex one by 1e-6.
const CONVEX: f64 = 0.999;
const NO_LIST: &str = "it is not a list of grains, each its vertices, [[x, y, z], ...], or with its faces, {\"vertices\": [[x, y, z], \
                       ...], \"faces\": [[0, 1, 2], ...]}";

/// Replaces `shape.library` by the grains that its file, or the files of its folder, hold. With `shape.hull` each is the
/// convex hull of its body.
pub(super) fn inline(tree: &mut Node, files: &mut dyn Files) -> Result<(), SpecError> {
    let Some(shape) = tree.child_mut("shape") else { return Ok(()) };
    let hull = shape.take("hull").map(|(_, node)| node);
    let Some((_, Node { value, line })) = shape.take("library") else {
        let message = "counts only for a library, the grains of a file; leave it out";
        return hull.map_or(Ok(()), |node| Err(SpecError { line: node.line, ..SpecError::value(HULL, message) }));
    };
    let takes_hull = match hull {
        None => false,
        Some(Node { value: Value::Bool(flag), .. }) => flag,
        Some(node) => {
            let message = format!("is {}; it must be true or false", found(&node.unexpected()));
            return Err(SpecError { is_wrong_type: true, line: node.line, ..SpecError::value(HULL, message) });
        }
    };
    let Value::Text(name) = value else {
        let message = "must be the name of a folder, or of a file of grains (STL, PLY, OBJ, OFF, JSON) in quotes";
        return Err(SpecError { is_wrong_type: true, line, ..SpecError::value(KEY, message) });
    };
    let grains = Reader { files, takes_hull }
        .grains(&name)
        .map_err(|reason| SpecError { line, ..SpecError::value(KEY, format!("is {name:?}: {reason}")) })?;
    let kind = shape.child("kind").is_some();
    if let Value::Table(entries) = &mut shape.value {
        let grains = grains.iter().map(|grain| node(Value::Array(grain.iter().map(row).collect()), line));
        entries.push(("grains".to_owned(), node(Value::Array(grains.collect()), line)));
        if !kind {
            entries.push(("kind".to_owned(), node(Value::Text("library".to_owned()), line)));
        }
    }
    Ok(())
}

fn node(value: Value, line: Option<usize>) -> Node {
    Node { value, line }
}

fn row(vertex: &Vec3) -> Node {
    Node::list(vertex.iter().map(|&x| Value::Float(x)))
}

/// Endings of the names of files of grains.
fn endings() -> Vec<&'static str> {
    import::ENDINGS.into_iter().chain(["json"]).collect()
}

fn is_grain_file(name: &str) -> bool {
    import::ending(name).is_some_and(|ending| endings().contains(&ending.as_str()))
}

/// Reads grains: the vertices of a convex polyhedron each.
struct Reader<'a> {
    files: &'a mut dyn Files,
    /// Whether bodies that are not convex count as their hulls.
    takes_hull: bool,
}

impl Reader<'_> {
    /// Every grain in the file, or in the files of the folder in the order of their names.
    fn grains(&mut self, name: &str) -> Result<Vec<Vec<Vec3>>, String> {
        if is_grain_file(name) {
            return self.read(name);
        }
        let readable = import::list(&endings());
        let no_folder = |error| format!("{error}; it is no folder, and a file of grains ends in {readable}");
        let mut names: Vec<String> = self.files.list(name).map_err(no_folder)?;
        names.retain(|name| is_grain_file(name));
        names.sort();
        if names.is_empty() {
            return Err(format!("the folder holds no file that ends in {readable}"));
        }
        let mut all = Vec::new();
        for file in names {
            let path = format!("{}/{file}", name.trim_end_matches('/'));
            all.append(&mut self.read(&path).map_err(|reason| format!("{file}: {reason}"))?);
        }
        Ok(all)
    }

    fn read(&mut self, name: &str) -> Result<Vec<Vec<Vec3>>, String> {
        let bytes = self.files.read(name).map_err(|error| error.to_string())?;
        if import::ending(name).as_deref() == Some("json") {
            return self.json_grains(&bytes);
        }
        let (bodies, notes) = import::read_bodies(name, &bytes).map_err(|error| error.to_string())?;
        notes.iter().for_each(|note| self.files.remark(name, note));
        let count = bodies.len();
        let named = |(i, body): (usize, TriangleMesh)| {
            let within = if count == 1 { String::new() } else { format!("body {i} of {count}, counted from 0: ") };
            self.convex(&body).map_err(|reason| format!("{within}{reason}"))
        };
        bodies.into_iter().enumerate().map(named).collect()
    }

    fn json_grains(&self, bytes: &[u8]) -> Result<Vec<Vec<Vec3>>, String> {
        let named = |(i, grain): (usize, Grain)| {
            let (name, vertices, faces) = match grain {
                Grain::Vertices(vertices) => (None, vertices, None),
                Grain::Named { name, vertices, faces } => (name, vertices, faces),
            };
            let name = name.unwrap_or_else(|| format!("grain {i}"));
            self.json_grain(vertices, faces).map_err(|reason| format!("{name}: {reason}"))
        };
        listed(bytes)?.into_iter().enumerate().map(named).collect()
    }

    fn json_grain(&self, vertices: Vec<[f64; 3]>, faces: Option<Vec<Vec<u32>>>) -> Result<Vec<Vec3>, String> {
        let vertices: Vec<Vec3> = vertices.into_iter().map(Vec3::from).collect();
        let Some(faces) = faces else {
            return convex_hull(&vertices).map(|hull| hull.vertices().to_vec()).map_err(|error| error.to_string());
        };
        if let Some(corner) = faces.iter().flatten().find(|&&corner| corner as usize >= vertices.len()) {
            return Err(format!("a face names vertex {corner} of {}", vertices.len()));
        }
        let fans = faces.iter().flat_map(|face| face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]));
        self.convex(&TriangleMesh { triangles: fans.collect(), vertices })
    }

    /// The hull's vertices of a closed convex surface, or of any surface where hulls are taken.
    fn convex(&self, surface: &TriangleMesh) -> Result<Vec<Vec3>, String> {
        let hull = surface.hull().map_err(|error| error.to_string())?;
        if !self.takes_hull {
            surface.check_closed().map_err(|error| error.to_string())?;
            let share = surface.volume() / hull.volume();
            if share < CONVEX {
                let percent = 100.0 * share;
                return Err(format!(
                    "it is not convex: it fills {percent:.1} % of its hull; shape.hull = true takes its hull"
                ));
            }
        }
        Ok(hull.vertices().to_vec())
    }
}

/// A list of grains, bare or under `grains` or (a saved model) `aggregates`.
#[derive(Deserialize)]
#[serde(untagged)]
enum Listed {
    Bare(Vec<Grain>),
    Grains { grains: Vec<Grain> },
    Model { aggregates: Vec<Grain> },
}

/// A grain is the hull of its vertices where nothing is said of faces.
#[derive(Deserialize)]
#[serde(untagged)]
enum Grain {
    Vertices(Vec<[f64; 3]>),
    Named { name: Option<String>, vertices: Vec<[f64; 3]>, faces: Option<Vec<Vec<u32>>> },
}

fn listed(bytes: &[u8]) -> Result<Vec<Grain>, String> {
    // Some programs begin a text with its byte order.
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = serde_json::Deserializer::from_slice(bytes);
    let tree = distinct::value(&mut reader).and_then(|tree| reader.end().map(|()| tree));
    let tree = tree.map_err(|error| match error.is_data() {
        true => error.to_string(),
        false => format!("it is not JSON: {error}"),
    })?;
    let (Listed::Bare(grains) | Listed::Grains { grains } | Listed::Model { aggregates: grains }) =
        serde_json::from_value(tree).map_err(|_| NO_LIST)?;
    if grains.is_empty() { Err("it has no grains".to_owned()) } else { Ok(grains) }
}
