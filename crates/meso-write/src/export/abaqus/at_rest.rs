//! The supports of a test in linear statics, for Abaqus/Standard and CalculiX.
//!
//! A plate without friction holds its nodes along its axis, one with friction in all directions. There is no contact: a strip
//! beside the middle holds its row nearest to the centre, so that the specimen turns on it.

use super::geometry::ExtraNodes;
use super::lines::real;
use super::supports::{along, grow, model, names, reference};
use super::{DeckOptions, elastic};
use crate::export::lines::Lines;
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::cells::Mesh;
use meso_trial::{Hold, Loads, RigidSupport};
use std::io::{self, Write};

/// Distance from the nearest row, over the specimen's size, within which nodes are on it.
const ROW: f64 = 1e-6;
/// Part of a rigid motion, of length 1, below which supports hold it already.
const HELD: f64 = 1e-3;

/// Statics of a test: loads in a first step, the end of the path in a second one.
pub(super) fn write(lines: &mut Lines<impl Write>, mesh: &Mesh, _: &DeckOptions, loads: &Loads) -> io::Result<()> {
    let loads = &narrowed(mesh, loads);
    model(lines, loads)?;
    let names = names(loads);
    let mut pressed = Vec::new();
    for (place, support) in loads.supports.iter().enumerate() {
        if support.is_pressed() {
            pressed.push((tie(lines, mesh, place, support)?, support));
        }
    }
    let pins = pins(mesh, loads);
    let sets: Vec<String> = names.iter().map(|name| format!("N_{name}")).collect();
    let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
    if loads.lead_s > 0.0 {
        begin(lines)?;
        hold(lines, loads, &names, 0.0)?;
        for ([_, follower], support) in &pressed {
            lines.line(format!("{follower}, {0}, {0}", along(support)))?;
        }
        pins.iter().try_for_each(|[node, dof]| lines.line(format!("{node}, {dof}, {dof}")))?;
        grow(lines, loads, "")?;
        for ([leader, _], support) in &pressed {
            lines.line("*CLOAD")?;
            lines.line(format!("{leader}, {}, {}", along(support), real(-support.force_n)))?;
        }
        elastic::end(lines, &sets, "U, RF", &[])?;
    }
    let Some(end) = loads.path_mm.last() else { return Ok(()) };
    begin(lines)?;
    hold(lines, loads, &names, *end)?;
    for ([_, follower], support) in &pressed {
        lines.line(format!("{follower}, {0}, {0}, {1:.12e}", along(support), support.moves * end))?;
    }
    pins.iter().try_for_each(|[node, dof]| lines.line(format!("{node}, {dof}, {dof}")))?;
    if !pressed.is_empty() {
        // Where the force has moved a plate to, the path begins.
        lines.line("*BOUNDARY, FIXED")?;
        for ([leader, _], support) in &pressed {
            lines.line(format!("{leader}, {0}, {0}", along(support)))?;
        }
    }
    elastic::end(lines, &sets, "U, RF", &[])
}

fn begin(lines: &mut Lines<impl Write>) -> io::Result<()> {
    lines.line("*STEP")?;
    lines.line("*STATIC")?;
    lines.line("*BOUNDARY")
}

/// The loads with the nodes that touch a plate, and one row of nodes on a strip beside the middle.
fn narrowed(mesh: &Mesh, loads: &Loads) -> Loads {
    let size = Aabb::around(&mesh.points).size();
    let mut loads = loads.clone();
    for support in &mut loads.supports {
        let patch = Aabb::around(support.nodes.iter().map(|&node| &mesh.points[node as usize]));
        let middle = 0.5 * (patch.min + patch.max);
        // The strip is narrow along the axis of its width.
        let across =
            (0..3).filter(|axis| *axis != support.axis).min_by(|&a, &b| patch.size()[a].total_cmp(&patch.size()[b]));
        let across = across.unwrap_or_default();
        let off = |node: &u32| mesh.points[*node as usize][across] - middle[across];
        if support.is_beside {
            let row = support.nodes.iter().map(off).min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or_default();
            support.nodes.retain(|node| (off(node) - row).abs() < ROW * size[across]);
        }
        if matches!(support.hold, Hold::Plate(_)) {
            let plane = if support.is_upper { patch.max } else { patch.min }[support.axis];
            let gap = |node: &u32| (mesh.points[*node as usize][support.axis] - plane).abs();
            support.nodes.retain(|node| gap(node) < ROW * size[support.axis]);
        }
    }
    loads
}

/// Numbers of the reference nodes of a pressed plate: the leader of the load, and the follower of the path.
fn pair(mesh: &Mesh, place: usize) -> [u64; 2] {
    [2 * place, 2 * place + 1].map(|place| reference(mesh, place))
}

/// The reference nodes of pressed plates.
pub(super) fn references(mesh: &Mesh, loads: &Loads) -> Vec<ExtraNodes> {
    let loads = narrowed(mesh, loads);
    let named = names(&loads).into_iter().zip(&loads.supports).enumerate();
    let of = |(place, (name, support)): (usize, (String, &RigidSupport))| {
        let patch = Aabb::around(support.nodes.iter().map(|&node| &mesh.points[node as usize]));
        let position: [f64; 3] = (0.5 * (patch.min + patch.max)).into();
        let set = |(number, what)| ExtraNodes { number, position, set: Some(format!("REF_{what}_{name}")) };
        pair(mesh, place).into_iter().zip(["LOAD", "PATH"]).map(set).collect::<Vec<_>>()
    };
    named.filter(|(_, (_, support))| support.is_pressed()).flat_map(of).collect()
}

/// Ties the nodes of a plate to its two reference nodes: its way is the sum of theirs. Returns both.
fn tie(lines: &mut Lines<impl Write>, mesh: &Mesh, place: usize, support: &RigidSupport) -> io::Result<[u64; 2]> {
    let numbers = pair(mesh, place);
    let (dof, [leader, follower]) = (along(support), numbers);
    lines.line("*EQUATION")?;
    for &node in &support.nodes {
        lines.line("3")?;
        lines.line(format!("{}, {dof}, 1.0, {leader}, {dof}, -1.0, {follower}, {dof}, -1.0", node + 1))?;
    }
    Ok(numbers)
}

/// Degrees of freedom that a support holds, from 0.
fn held(support: &RigidSupport) -> Vec<usize> {
    if support.hold == Hold::Plate(0.0) { vec![support.axis] } else { vec![0, 1, 2] }
}

/// Holds the supports at the place `at` of the path.
fn hold(lines: &mut Lines<impl Write>, loads: &Loads, names: &[String], at: f64) -> io::Result<()> {
    for (name, support) in names.iter().zip(&loads.supports) {
        for axis in held(support) {
            let dof = axis + 1;
            match axis == support.axis {
                true if support.is_pressed() => {}
                true => lines.line(format!("N_{name}, {dof}, {dof}, {:.12e}", support.moves * at))?,
                false => lines.line(format!("N_{name}, {dof}, {dof}"))?,
            }
        }
    }
    Ok(())
}

/// Nodes and degrees of freedom, as few as take the rigid motions that the supports leave. Loads in equilibrium leave them
/// without a reaction.
fn pins(mesh: &Mesh, loads: &Loads) -> Vec<[u64; 2]> {
    let aabb = Aabb::around(&mesh.points);
    let (middle, size) = (0.5 * (aabb.min + aabb.max), aabb.size().norm());
    let mut taken: Vec<[f64; 6]> = Vec::new();
    let mut take = |node: u32, axis: usize| {
        let off = (mesh.points[node as usize] - middle) / size;
        let mut row = motion(off, axis);
        for other in &taken {
            let part: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
            row.iter_mut().zip(other).for_each(|(a, b)| *a -= part * b);
        }
        let length = row.iter().map(|a| a * a).sum::<f64>().sqrt();
        let is_new = length > HELD;
        if is_new {
            taken.push(row.map(|a| a / length));
        }
        is_new
    };
    for support in &loads.supports {
        for axis in held(support) {
            support.nodes.iter().for_each(|&node| {
                take(node, axis);
            });
        }
    }
    let mut pins = Vec::new();
    for corner in [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]] {
        let at = Vec3::from([0, 1, 2].map(|k| if corner[k] == 0 { aabb.min[k] } else { aabb.max[k] }));
        let node = elastic::nearest_node(mesh, at);
        pins.extend((0..3).filter(|&axis| take(node, axis)).map(|axis| [u64::from(node) + 1, axis as u64 + 1]));
    }
    pins
}

/// Displacement along an axis, at a place off the middle, under the six rigid motions.
fn motion(off: Vec3, axis: usize) -> [f64; 6] {
    let mut row = [0.0; 6];
    row[axis] = 1.0;
    // A turn about k moves a place along k x off.
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    row[3 + next] = off[last];
    row[3 + last] = -off[next];
    row
}
