//! Periodic constraints: a node on an upper face moves as its image on the lower face, and by a jump that all share.
//!
//! u(x + L e) - u(x) = u(REF), with one reference node for every direction in which the box repeats itself: the
//! displacement of REF_X, REF_Y or REF_Z is the macroscopic displacement gradient's column times the box's length. A node
//! on several upper faces, on an edge or in a corner, is tied at once to the image that lies on none of them. So every
//! node is eliminated at most once, and no equation uses a node that another one eliminates. Where cohesive elements part
//! the materials, images are of one aggregate, or both of the mortar; a node whose material has none on the lower faces is
//! tied to the image on the fewest upper ones, or free where it has no other. So is a node opposite to a void, which has no
//! elements.

use super::geometry::ExtraNodes;
use super::limits::DECK;
use crate::export::lines::Lines;
use meso_collision::geometry::BoxTree;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::OutOfRange;
use meso_mesh::cells::Mesh;
use meso_mesh::cells::{SIDES, Sides, Spots, owners, upper};
use std::cell::LazyCell;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Names of the reference nodes' sets, one per direction.
pub(super) const REFERENCES: [&str; 3] = ["REF_X", "REF_Y", "REF_Z"];

/// A node on upper faces and the image that it moves with.
struct Pair {
    node: u32,
    image: u32,
    /// The upper faces that the node lies on, and those of the image.
    along: [[bool; 3]; 2],
}

/// The equations.
pub(super) fn write(lines: &mut Lines<impl Write>, mesh: &Mesh, sides: &Sides) -> io::Result<()> {
    let pairs = pairs(mesh, sides).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    lines.line("*EQUATION")?;
    pairs.iter().try_for_each(|pair| equations(lines, pair, mesh.points.len() as u64 + 1))
}

/// The reference node of every direction in which the box repeats itself, in the middle of its upper face.
pub(super) fn references(mesh: &Mesh) -> Vec<ExtraNodes> {
    let aabb = Aabb::around(&mesh.points);
    let directions = (0..3).zip(REFERENCES).filter(|(axis, _)| mesh.periodic[*axis]);
    directions
        .map(|(axis, name)| {
            let mut position = (aabb.min + aabb.max) / 2.0;
            position[axis] = aabb.max[axis];
            let number = mesh.points.len() as u64 + 1 + axis as u64;
            ExtraNodes { number, position: position.into(), set: Some(name.to_owned()) }
        })
        .collect()
}

/// One equation for each direction of displacement; four terms to a data line.
fn equations(lines: &mut Lines<impl Write>, pair: &Pair, first_reference: u64) -> io::Result<()> {
    let step = |axis: usize| f64::from(u8::from(pair.along[1][axis])) - f64::from(u8::from(pair.along[0][axis]));
    let references = (0..3).map(|axis| (first_reference + axis as u64, step(axis))).filter(|(_, step)| *step != 0.0);
    let nodes = [(pair.node, 1.0), (pair.image, -1.0)].map(|(node, factor)| (u64::from(node) + 1, factor));
    let nodes: Vec<(u64, f64)> = nodes.into_iter().chain(references).collect();
    for displacement in 1..=3 {
        let term = |(node, factor): &(u64, f64)| format!("{node}, {displacement}, {factor}");
        let terms: Vec<String> = nodes.iter().map(term).collect();
        lines.line(terms.len().to_string())?;
        terms.chunks(4).try_for_each(|line| lines.line(line.join(", ")))?;
    }
    Ok(())
}

/// Finds out whether opposite faces match node for node.
pub(super) fn check(mesh: &Mesh) -> Result<(), OutOfRange> {
    pairs(mesh, &Sides::of(mesh)).map(drop)
}

/// The nodes on upper faces of directions that repeat themselves, ascending, each with the image that it moves with.
fn pairs(mesh: &Mesh, sides: &Sides) -> Result<Vec<Pair>, OutOfRange> {
    matched(mesh, sides)?;
    let size = Aabb::around(&mesh.points).size();
    let owners = owners(mesh, sides);
    let along = |node: u32| upper(mesh.periodic, sides, node);
    // Where a node's image that is on no upper face lies, or would.
    let lowest = |node: u32| Vec3::from_fn(|axis, _| if along(node)[axis] { size[axis] } else { 0.0 });
    let lowest: Vec<Vec3> = (0..).zip(&mesh.points).map(|(node, point)| point - lowest(node)).collect();
    let images = Spots::new(&lowest, (0..lowest.len() as u32).filter(|&node| sides.on(node) != 0));
    let (mut pairs, mut others) = (Vec::new(), Others::new());
    for node in (0..lowest.len() as u32).filter(|&node| along(node) != [false; 3]) {
        let (owner, at) = (owners[node as usize], lowest[node as usize]);
        let own = |image: &u32| owners[*image as usize] == owner && along(*image) == [false; 3];
        match images.at(at).find(own) {
            Some(image) => pairs.push(Pair { node, image, along: [along(node), [false; 3]] }),
            None => {
                let class = images.at(at).min().unwrap_or(node);
                others.entry((class, owner)).or_default().push(node);
            }
        }
    }
    pairs.extend(others.into_values().flat_map(|nodes| tied(nodes, along)));
    pairs.sort_by_key(|pair| pair.node);
    Ok(pairs)
}

/// Nodes on upper faces whose material has none on the lower ones, by the lowest of all images and by owner.
type Others = BTreeMap<(u32, u32), Vec<u32>>;

/// Ties images of one material to the one of them on the fewest upper faces.
fn tied(mut nodes: Vec<u32>, along: impl Fn(u32) -> [bool; 3]) -> Vec<Pair> {
    let upper = |node: u32| along(node).iter().filter(|along| **along).count();
    nodes.sort_by_key(|&node| (upper(node), along(node), node));
    nodes[1..].iter().map(|&node| Pair { node, image: nodes[0], along: [along(node), along(nodes[0])] }).collect()
}

/// Whether every node on such a face has one opposite to it, or no element there: a void may end at the face.
fn matched(mesh: &Mesh, sides: &Sides) -> Result<(), OutOfRange> {
    let size = Aabb::around(&mesh.points).size();
    let spots = Spots::new(&mesh.points, (0..mesh.points.len() as u32).filter(|&node| sides.on(node) != 0));
    for side in [1, 3, 5, 0, 2, 4].into_iter().filter(|side| mesh.periodic[side / 2]) {
        let (axis, is_upper, _) = SIDES[side];
        let step = Vec3::ith(axis, if is_upper { -size[axis] } else { size[axis] });
        let faces = &sides.faces()[side ^ 1];
        // Few sides have a node without one opposite.
        let tree = LazyCell::new(|| BoxTree::new(&boxes(mesh, faces)));
        let is_covered = |at: Vec3| {
            let near = Aabb { min: at, max: at }.grown(EDGE * size.max());
            tree.near(near).any(|face| covers(mesh, &faces[face as usize], axis, &at))
        };
        for point in sides.members(side).map(|node| mesh.points[node as usize]) {
            let opposite = point + step;
            if spots.at(opposite).next().is_none() && is_covered(opposite) {
                return Err(unmatched(&point, side ^ 1));
            }
        }
    }
    Ok(())
}

/// The box around each of the faces of cells.
fn boxes(mesh: &Mesh, faces: &[(u32, usize)]) -> Vec<Aabb> {
    let corners =
        |&(cell, face): &(u32, usize)| mesh.by_owner().face(cell, face).map(|node| &mesh.points[node as usize]);
    faces.iter().map(|face| Aabb::around(corners(face))).collect()
}

/// Whether a cell's face in a plane across `axis` has the point `at` of that plane, its edges included.
fn covers(mesh: &Mesh, &(cell, face): &(u32, usize), axis: usize, at: &Vec3) -> bool {
    let corners: Vec<Vec3> = mesh.by_owner().face(cell, face).map(|node| mesh.points[node as usize] - at).collect();
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    let turn = |a: &Vec3, b: &Vec3| a[u] * b[v] - a[v] * b[u];
    let turns: Vec<f64> = (0..corners.len()).map(|i| turn(&corners[i], &corners[(i + 1) % corners.len()])).collect();
    // Areas, as a share of the face's.
    let slack = EDGE * turns.iter().sum::<f64>().abs();
    turns.iter().all(|turn| *turn >= -slack) || turns.iter().all(|turn| *turn <= slack)
}

/// Points this near to an edge are on the face, in shares of its area, and to its plane, in shares of the box's size.
const EDGE: f64 = 1e-9;

fn unmatched(position: &Vec3, side: usize) -> OutOfRange {
    let [x, y, z]: [f64; 3] = (*position).into();
    faces_differ(&format!("the node at {x:.4}, {y:.4}, {z:.4} mm has none opposite to it on {}", SIDES[side].2))
}

fn faces_differ(what: &str) -> OutOfRange {
    let remedy = "opposite faces must match node for node, as in voxels and lattices";
    DECK.error("periodic_equations", "true", format!("{remedy}; here {what}"))
}
