//! The nodes of a mesh under a support.

use crate::error::{TEST, TrialError};
use crate::sample::Sample;
use crate::trial::{Rule, Side, SupportSpec};
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::Mesh;
use meso_mesh::cells::Sides;

/// Least width of a strip, in elements: some nodes of any mesh lie under it.
const LEAST_WIDTH: f64 = 1.5;

/// Nodes under a support in the mesh's order, each with its distance from the support before the test, mm.
///
/// # Errors
/// No face of the specimen looks to it, or no node lies under its strip.
pub fn under(sample: &Sample, sides: &Sides, support: &SupportSpec) -> Result<Vec<(u32, f64)>, TrialError> {
    let mesh = sample.mesh;
    let bit = side(support)?;
    let (axis, is_upper) = (bit / 2, bit % 2 == 1);
    if sides.faces()[bit].is_empty() {
        return Err(TrialError::mesh(no_face(support, axis, is_upper)));
    }
    let aabb = Aabb::around(&mesh.points);
    let plane = if is_upper { aabb.max } else { aabb.min }[axis];
    let centre = 0.5 * (aabb.min + aabb.max);
    let is_under = |point: &Vec3| {
        support.strip.is_none_or(|strip| {
            (0..3).filter(|&across| across != axis || strip.axis as usize == axis).all(|across| {
                let [from, to] = strip.ends_mm(across, LEAST_WIDTH * sample.element_size_mm);
                let (at, slack) = (point[across] - centre[across], 0.5e-9 * (to - from));
                from - slack <= at && at <= to + slack
            })
        })
    };
    let met = |node: u32| {
        let point = &mesh.points[node as usize];
        // A strip takes the shape of a round side.
        let gap = if support.strip.is_some() { 0.0 } else { (point[axis] - plane).abs() };
        is_under(point).then_some((node, gap))
    };
    let nodes: Vec<(u32, f64)> = sides.members(bit).filter_map(met).collect();
    if nodes.is_empty() {
        let why = format!("no node of the specimen lies under {:?}; widen its strip or move it", support.name);
        return Err(TrialError::mesh(why));
    }
    Ok(nodes)
}

/// Number of the side under a plate.
fn side(support: &SupportSpec) -> Result<usize, TrialError> {
    let why = "it must be one of the six sides: only a pressure acts on the mantle";
    support.on.bit().ok_or_else(|| TEST.error(format!("supports.{}.on", support.name), "mantle", why).into())
}

fn no_face(support: &SupportSpec, axis: usize, is_upper: bool) -> String {
    let (name, side) = (["x", "y", "z"][axis], ["lower", "upper"][usize::from(is_upper)]);
    let which = if axis == 2 { String::new() } else { format!(" ({})", support.name) };
    format!("no face points to its {side} plate{which}; take a specimen with plane faces across {name}")
}

/// Forces of a pressure of 1 MPa on the mesh's nodes, N, without those that it does not touch.
///
/// # Errors
/// No face of the specimen lies on its side.
pub fn forces(mesh: &Mesh, sides: &Sides, support: &SupportSpec) -> Result<Vec<(u32, [f64; 3])>, TrialError> {
    let mut force = vec![[0.0; 3]; mesh.points.len()];
    for (cell, face) in pressed_faces(mesh, sides, support)? {
        let nodes: Vec<u32> = mesh.by_owner().face(cell, face).collect();
        let share = -area(mesh, &nodes) / nodes.len() as f64;
        nodes.iter().for_each(|&node| (0..3).for_each(|k| force[node as usize][k] += share[k]));
    }
    Ok((0..).zip(force).filter(|(_, force)| *force != [0.0; 3]).collect())
}

/// Area of a face along its outward normal, mm2: half the cross product of two edges, or of the diagonals.
pub fn area(mesh: &Mesh, nodes: &[u32]) -> Vec3 {
    let p = |i: usize| mesh.points[nodes[i] as usize];
    let twice =
        if nodes.len() == 4 { (p(2) - p(0)).cross(&(p(3) - p(1))) } else { (p(1) - p(0)).cross(&(p(2) - p(0))) };
    0.5 * twice
}

/// Faces that a pressure acts on.
///
/// # Errors
/// No face of the specimen lies on its side.
pub fn pressed_faces(mesh: &Mesh, sides: &Sides, support: &SupportSpec) -> Result<Vec<(u32, usize)>, TrialError> {
    let faces = faces(mesh, sides, support.on);
    if faces.is_empty() {
        let why = format!("no face lies on the side of {:?}; take a specimen with one", support.name);
        return Err(TrialError::mesh(why));
    }
    Ok(faces)
}

/// Area of the faces that a pressure acts on, mm2.
///
/// # Errors
/// See [`pressed_faces`].
pub fn pressed_mm2(mesh: &Mesh, sides: &Sides, support: &SupportSpec) -> Result<f64, TrialError> {
    let of = |(cell, face)| area(mesh, &mesh.by_owner().face(cell, face).collect::<Vec<_>>()).norm();
    Ok(pressed_faces(mesh, sides, support)?.into_iter().map(of).sum())
}

/// Area of the faces under a plate across its axis, mm2; a strip has none.
pub fn area_mm2(mesh: &Mesh, sides: &Sides, support: &SupportSpec) -> f64 {
    let Some(bit) = support.on.bit().filter(|_| support.strip.is_none() && support.rule != Rule::Pressure) else {
        return 0.0;
    };
    let across = |&(cell, face): &(u32, usize)| {
        let nodes: Vec<u32> = mesh.by_owner().face(cell, face).collect();
        area(mesh, &nodes)[bit / 2].abs()
    };
    sides.faces()[bit].iter().map(across).sum()
}

/// The outer faces of a side.
fn faces(mesh: &Mesh, sides: &Sides, side: Side) -> Vec<(u32, usize)> {
    if let Some(bit) = side.bit() {
        return sides.faces()[bit].clone();
    }
    let is_end = |&(cell, face): &(u32, usize)| {
        let on = mesh.by_owner().face(cell, face).fold(u8::MAX, |on, node| on & sides.on(node));
        on >> 4 != 0
    };
    mesh.outer_faces().into_iter().filter(|face| !is_end(face)).collect()
}
