//! Periodic constraints: a node on an upper face moves as its image on the lower face, and by a jump that all share.
//!
//! u(x + L e) - u(x) = u(REF), with one reference node for every direction in which the box repeats itself: the
//! displacement of REF_X, REF_Y or REF_Z is the macroscopic displacement gradient's column times the box's length. A node
//! on several upper faces, on an edge or in a corner, is tied at once to the image that lies on none of them. So every
//! node is eliminated at most once, and no equation uses a node that another one eliminates. Where cohesive elements part
//! the materials, images are of one aggregate, or both of the mortar; a node whose material has none on the lower faces is
//! tied to the image on the fewest upper ones, or free where it has no other.

use super::DeckError;
use super::lines::Lines;
use crate::math::{Aabb, Vec3};
use crate::mesh::Mesh;
use crate::mesh::sides::{SIDES, Sides, Spots, owners, upper};
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

/// The reference nodes and the equations.
pub(super) fn write(lines: &mut Lines<impl Write>, mesh: &Mesh, sides: &Sides) -> io::Result<()> {
    let pairs = pairs(mesh, sides).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    let aabb = Aabb::around(&mesh.points);
    let first = mesh.points.len() as u64 + 1;
    for (axis, name) in (0..3).zip(REFERENCES).filter(|(axis, _)| mesh.periodic[*axis]) {
        let mut position = (aabb.min + aabb.max) / 2.0;
        position[axis] = aabb.max[axis];
        lines.line(format!("*NODE, NSET={name}"))?;
        lines.node(first + axis as u64, position.into())?;
    }
    lines.line("*EQUATION")?;
    pairs.iter().try_for_each(|pair| equations(lines, pair, first))
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
pub(super) fn check(mesh: &Mesh) -> Result<(), DeckError> {
    pairs(mesh, &Sides::of(mesh)).map(drop)
}

/// The nodes on upper faces of directions that repeat themselves, ascending, each with the image that it moves with.
fn pairs(mesh: &Mesh, sides: &Sides) -> Result<Vec<Pair>, DeckError> {
    let size = Aabb::around(&mesh.points).size();
    let owners = owners(mesh, sides);
    let along = |node: u32| upper(mesh.periodic, sides, node);
    let nodes = 0..mesh.points.len() as u32;
    let low = nodes.clone().filter(|&node| sides.on(node) != 0 && along(node) == [false; 3]);
    let images = Spots::new(&mesh.points, low);
    let (mut pairs, mut others) = (Vec::new(), Others::new());
    for node in nodes.filter(|&node| along(node) != [false; 3]) {
        let (position, owner, along) = (mesh.points[node as usize], owners[node as usize], along(node));
        let target = Vec3::from_fn(|axis, _| position[axis] - if along[axis] { size[axis] } else { 0.0 });
        let lowest = images.at(target).min().ok_or_else(|| unmatched(&position, &along))?;
        match images.at(target).find(|image| owners[*image as usize] == owner) {
            Some(image) => pairs.push(Pair { node, image, along: [along, [false; 3]] }),
            None if mesh.cohesive.is_empty() => return Err(unmatched(&position, &along)),
            None => others.entry((lowest, owner)).or_default().push(node),
        }
    }
    pairs.extend(others.into_values().flat_map(|nodes| tied(nodes, along)));
    pairs.sort_by_key(|pair| pair.node);
    match mesh.cohesive.is_empty() {
        true => as_many(mesh.periodic, sides).map(|()| pairs),
        // A material may end at the face.
        false => Ok(pairs),
    }
}

/// Nodes on upper faces whose material has none at the lower image of their position, by the lowest node there and by owner.
type Others = BTreeMap<(u32, u32), Vec<u32>>;

/// Ties images of one material to the one of them on the fewest upper faces.
fn tied(mut nodes: Vec<u32>, along: impl Fn(u32) -> [bool; 3]) -> Vec<Pair> {
    let upper = |node: u32| along(node).iter().filter(|along| **along).count();
    nodes.sort_by_key(|&node| (upper(node), along(node), node));
    nodes[1..].iter().map(|&node| Pair { node, image: nodes[0], along: [along(node), along(nodes[0])] }).collect()
}

/// Images of different nodes differ: equal numbers on both sides leave none over.
fn as_many(periodic: [bool; 3], sides: &Sides) -> Result<(), DeckError> {
    for axis in (0..3).filter(|axis| periodic[*axis]) {
        let [low, high] = [2 * axis, 2 * axis + 1].map(|side| sides.members(side).count());
        if low != high {
            let what = format!("{} nodes lie on {} and {high} on {}", low, SIDES[2 * axis].2, SIDES[2 * axis + 1].2);
            return Err(faces_differ(&what));
        }
    }
    Ok(())
}

fn unmatched(position: &Vec3, along: &[bool; 3]) -> DeckError {
    let axis = along.iter().position(|along| *along).unwrap_or(0);
    let [x, y, z]: [f64; 3] = (*position).into();
    faces_differ(&format!("the node at {x:.4}, {y:.4}, {z:.4} mm has none opposite to it on {}", SIDES[2 * axis].2))
}

fn faces_differ(what: &str) -> DeckError {
    let remedy = "opposite faces must match node for node, as in voxels and lattices";
    DeckError::new("periodic_equations", "true", format!("{remedy}; here {what}"))
}
