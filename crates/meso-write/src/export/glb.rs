//! Aggregate surfaces as binary glTF 2.0 (`.glb`), for slides, browsers and Blender: a node per body, a material per class.
//!
//! glTF counts in metres with y upwards, so that one root node turns and scales the millimetres below it. A node's `extras`
//! are `aggregate`, `class`, `phase` and `itz_thickness_mm`. Coordinates are rounded to f32, as in an STL.

use super::appearance::{colour, material, name};
use meso_collision::math::Aabb;
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::Aggregate;
use serde_json::{Value, json};
use std::io::{self, BufWriter, Write};

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Writes every body to `out`: the JSON header, all corners, all triangles.
///
/// # Errors
/// Fails with the errors of `out`; more than the 4 GB that the format counts.
pub(crate) fn write(bodies: &[Aggregate], phases: &PhaseNames, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    let corners: usize = bodies.iter().map(|body| 12 * body.body.vertices().len()).sum();
    let triangles: usize = bodies.iter().map(|body| 12 * body.body.triangles().count()).sum();
    let mut described = serde_json::to_vec(&describe(bodies, phases, corners, triangles))?;
    described.resize(described.len().next_multiple_of(4), b' ');
    let size = |bytes: usize| u32::try_from(bytes).map_err(|_| io::Error::other("a .glb holds at most 4 GB"));
    let total = size(12 + 8 + described.len() + 8 + corners + triangles)?;
    out.write_all(b"glTF\x02\0\0\0")?;
    out.write_all(&total.to_le_bytes())?;
    out.write_all(&size(described.len())?.to_le_bytes())?;
    out.write_all(b"JSON")?;
    out.write_all(&described)?;
    out.write_all(&size(corners + triangles)?.to_le_bytes())?;
    out.write_all(b"BIN\0")?;
    for x in bodies.iter().flat_map(|body| body.body.vertices()).flat_map(|v| [v.x, v.y, v.z]) {
        out.write_all(&(x as f32).to_le_bytes())?;
    }
    for corner in bodies.iter().flat_map(|body| body.body.triangles()).flatten() {
        out.write_all(&corner.to_le_bytes())?;
    }
    out.flush()
}

fn describe(bodies: &[Aggregate], phases: &PhaseNames, corners: usize, triangles: usize) -> Value {
    let mut materials: Vec<(String, [u8; 3])> =
        bodies.iter().map(|body| (material(body, phases), colour(body))).collect();
    materials.sort_unstable();
    materials.dedup();
    let of = |body: &Aggregate| materials.binary_search(&(material(body, phases), colour(body))).unwrap_or_default();
    let primitive = |(i, body): (usize, &Aggregate)| {
        let primitive = json!({"attributes": {"POSITION": 2 * i}, "indices": 2 * i + 1, "material": of(body)});
        json!({"name": name(body, phases), "primitives": [primitive]})
    };
    let root = json!({
        "name": "specimen", "children": (1..=bodies.len()).collect::<Vec<_>>(),
        "rotation": [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2], "scale": [1e-3, 1e-3, 1e-3],
    });
    let nodes: Vec<Value> =
        std::iter::once(root).chain(bodies.iter().enumerate().map(|placed| node(placed, phases))).collect();
    json!({
        "asset": {"version": "2.0", "generator": "mesocrete"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": bodies.iter().enumerate().map(primitive).collect::<Vec<_>>(),
        "materials": materials.iter().map(matte).collect::<Vec<_>>(),
        "accessors": accessors(bodies),
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": corners, "target": ARRAY_BUFFER},
            {"buffer": 0, "byteOffset": corners, "byteLength": triangles, "target": ELEMENT_ARRAY_BUFFER},
        ],
        "buffers": [{"byteLength": corners + triangles}],
    })
}

fn node((i, body): (usize, &Aggregate), phases: &PhaseNames) -> Value {
    let Aggregate { id, class, itz_thickness_mm, .. } = body;
    let extras =
        json!({"aggregate": id, "class": class, "phase": body.phase().number(), "itz_thickness_mm": itz_thickness_mm});
    json!({"name": name(body, phases), "mesh": i, "extras": extras})
}

/// The corners of every body and its triangles, one after the other in the two views.
fn accessors(bodies: &[Aggregate]) -> Vec<Value> {
    let (mut corners, mut triangles) = (0, 0);
    let of = |body: &Aggregate| {
        let Aabb { min, max } = body.body.aabb();
        let bounds = [min, max].map(|corner| [corner.x as f32, corner.y as f32, corner.z as f32]);
        let (points, indices) = (body.body.vertices().len(), 3 * body.body.triangles().count());
        let both = [
            json!({"bufferView": 0, "byteOffset": corners, "componentType": FLOAT, "count": points, "type": "VEC3",
                "min": bounds[0], "max": bounds[1]}),
            json!({"bufferView": 1, "byteOffset": triangles, "componentType": UNSIGNED_INT, "count": indices, "type": "SCALAR"}),
        ];
        corners += 12 * points;
        triangles += 4 * indices;
        both
    };
    bodies.iter().flat_map(of).collect()
}

/// A dull material; glTF's colours are linear, ours sRGB (IEC 61966-2-1).
fn matte((name, colour): &(String, [u8; 3])) -> Value {
    let linear = |level: u8| {
        let level = f64::from(level) / 255.0;
        if level <= 0.04045 { level / 12.92 } else { libm::pow((level + 0.055) / 1.055, 2.4) }
    };
    let [r, g, b] = colour.map(linear);
    let looks = json!({"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.9});
    json!({"name": name, "pbrMetallicRoughness": looks})
}
