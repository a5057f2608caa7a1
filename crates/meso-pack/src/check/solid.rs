//! One body alone: closed, convex, seen from outside, by exact signs.

use meso_collision::dents::SelfCrossing;
use meso_collision::geometry::{BodyForm, Face, Polyhedron, Round, TriangleMesh, orient3d};
use meso_collision::math::Vec3;

/// Checks the faces of `body`; an error describes the fault.
pub(super) fn check(body: &Polyhedron) -> Result<(), String> {
    closed(body)?;
    let mut solid = false;
    for (f, face) in body.faces().enumerate() {
        solid |= supports(body.vertices(), face).map_err(|reason| format!("face {f} {reason}"))?;
    }
    if solid { Ok(()) } else { Err("it has no volume".to_owned()) }
}

/// Every edge is passed once in each direction.
fn closed(body: &Polyhedron) -> Result<(), String> {
    let mut edges: Vec<(u32, u32)> = Vec::new();
    for face in body.faces() {
        let count = face.len();
        edges.extend((0..count).map(|k| (face.vertex(k), face.vertex((k + 1) % count))));
    }
    edges.sort_unstable();
    if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("edge {}-{} is passed twice in one direction", pair[0].0, pair[0].1));
    }
    match edges.iter().find(|&&(from, to)| edges.binary_search(&(to, from)).is_err()) {
        Some((from, to)) => Err(format!("edge {from}-{to} has a face on one side only")),
        None => Ok(()),
    }
}

/// No vertex lies outside the plane of the face, and all corners lie in it; true when some vertex lies inside.
fn supports(vertices: &[Vec3], face: Face<'_>) -> Result<bool, String> {
    let corners = face.to_vec();
    let mut inside = false;
    for triangle in face.triangles() {
        let [a, b, c] = triangle.map(|i| &vertices[i as usize]);
        for (i, vertex) in vertices.iter().enumerate() {
            // The triangle's own corners lie in its plane; to find that out exactly costs the most.
            let side = if triangle.contains(&(i as u32)) { 0.0 } else { orient3d(a, b, c, vertex) };
            if side > 0.0 {
                return Err(format!("has vertex {i} outside"));
            }
            if side < 0.0 && corners.contains(&(i as u32)) {
                return Err("is not flat".to_owned());
            }
            inside |= side < 0.0;
        }
    }
    Ok(inside)
}

/// Checks a body with dents: its surface is closed, in one part, encloses a volume and nowhere crosses itself.
pub(super) fn check_surface(body: &Polyhedron) -> Result<(), String> {
    closed(body)?;
    let mesh = TriangleMesh { vertices: body.vertices().to_vec(), triangles: body.triangles().collect() };
    mesh.check_closed().map_err(|error| error.to_string())?;
    let parts = mesh.components().len();
    if parts != 1 {
        return Err(format!("its surface has {parts} parts"));
    }
    let facets = mesh.facets();
    match (SelfCrossing { mesh: &mesh, facets: &facets }).find() {
        Some([[corner, ..], _]) => Err(format!("its surface crosses itself near {:?}", <[f64; 3]>::from(corner))),
        None => Ok(()),
    }
}

/// The share of its size by which the axes of a ball or an ellipsoid may miss the right angle: single precision.
const TILT: f64 = 1e-6;

/// Checks a ball or an ellipsoid: its axes are orthogonal and cross in the middle.
pub(super) fn check_round(round: &Round, body: &Polyhedron) -> Result<(), String> {
    let is_sound = round.is_sound(body.vertices(), TILT * round.semi_axes()[0]);
    if is_sound { Ok(()) } else { Err("its ends are not those of an ellipsoid".to_owned()) }
}

/// The depth of a point in a body with a shell of `thickness` mm: that of the vertices' mean below the nearest face plane, or
/// of a point that is deep below the skin of a body with dents.
pub(super) fn depth_of_inner_point(body: &Polyhedron, thickness: f64) -> f64 {
    match body.form() {
        BodyForm::Hull => {
            let mean = body.vertices().iter().sum::<Vec3>() / body.vertices().len() as f64;
            body.planes().map(|plane| plane.offset - plane.normal.dot(&mean)).fold(f64::INFINITY, f64::min)
        }
        BodyForm::Round(round) => round.semi_axes()[2],
        BodyForm::Surface => body.skin(thickness).deepest().1,
    }
}

/// The smallest distance of the core's vertices to the planes of `body`, mm.
pub(super) fn thinnest_shell(body: &Polyhedron, core: &Polyhedron) -> f64 {
    let inwards = body.planes().map(|plane| {
        let highest = core.vertices().iter().map(|v| plane.normal.dot(v)).fold(f64::NEG_INFINITY, f64::max);
        plane.offset - highest
    });
    inwards.fold(f64::INFINITY, f64::min)
}
