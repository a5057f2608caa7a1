//! Periodic constraints: a node on an upper face moves as its image on the lower face, and by a jump that all share.
//!
//! u(x + L e) - u(x) = u(REF), with one reference node for every direction in which the box repeats itself: the
//! displacement of REF_X, REF_Y or REF_Z is the macroscopic displacement gradient's column times the box's length. A node
//! on several upper faces, on an edge or in a corner, is tied at once to the image that lies on none of them. So every
//! node is eliminated at most once, and no equation uses a node that another one eliminates. Where cohesive elements part
//! the materials, images are of one aggregate, or both of the mortar.

use super::DeckError;
use super::lines::Lines;
use crate::math::{Aabb, Vec3};
use crate::mesh::Mesh;
use crate::mesh::sides::{SIDES, Sides, Spots, owners, upper};
use std::io::{self, Write};

/// Names of the reference nodes' sets, one per direction.
pub(super) const REFERENCES: [&str; 3] = ["REF_X", "REF_Y", "REF_Z"];

/// A node on upper faces and its image on none.
struct Pair {
    node: u32,
    image: u32,
    /// The directions that lie between them.
    along: [bool; 3],
}

/// The reference nodes and the equations.
pub(super) fn write(lines: &mut Lines<impl Write>, mesh: &Mesh, sides: &Sides) -> io::Result<()> {
    let pairs = pairs(mesh, sides).map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
    let aabb = Aabb::around(&mesh.points);
    let first = mesh.points.len() as u64 + 1;
    for (axis, name) in (0..3).zip(REFERENCES).filter(|(axis, _)| mesh.periodic[*axis]) {
        let mut place = (aabb.min + aabb.max) / 2.0;
        place[axis] = aabb.max[axis];
        lines.line(format!("*NODE, NSET={name}"))?;
        lines.node(first + axis as u64, place.into())?;
    }
    lines.line("*EQUATION")?;
    pairs.iter().try_for_each(|pair| equations(lines, pair, first))
}

/// One equation for each direction of displacement; four terms to a data line.
fn equations(lines: &mut Lines<impl Write>, pair: &Pair, first_reference: u64) -> io::Result<()> {
    let references = (0..3).filter(|axis| pair.along[*axis]).map(|axis| first_reference + axis as u64);
    let nodes: Vec<u64> =
        [pair.node, pair.image].map(|node| u64::from(node) + 1).into_iter().chain(references).collect();
    for displacement in 1..=3 {
        let term =
            |(place, node): (usize, &u64)| format!("{node}, {displacement}, {}", if place == 0 { 1.0 } else { -1.0 });
        let terms: Vec<String> = nodes.iter().enumerate().map(term).collect();
        lines.line(terms.len().to_string())?;
        terms.chunks(4).try_for_each(|line| lines.line(line.join(", ")))?;
    }
    Ok(())
}

/// Finds out whether opposite faces match node for node.
pub(super) fn check(mesh: &Mesh) -> Result<(), DeckError> {
    pairs(mesh, &Sides::of(mesh)).map(drop)
}

/// Every node on an upper face of a direction that repeats itself, ascending, with its image.
fn pairs(mesh: &Mesh, sides: &Sides) -> Result<Vec<Pair>, DeckError> {
    let size = Aabb::around(&mesh.points).size();
    let owners = owners(mesh, sides);
    let nodes = 0..mesh.points.len() as u32;
    let low = nodes.clone().filter(|&node| sides.on(node) != 0 && upper(mesh.periodic, sides, node) == [false; 3]);
    let images = Spots::new(&mesh.points, low);
    let mut pairs = Vec::new();
    for node in nodes {
        let along = upper(mesh.periodic, sides, node);
        if along != [false; 3] {
            let place = mesh.points[node as usize];
            let target = Vec3::from_fn(|axis, _| place[axis] - if along[axis] { size[axis] } else { 0.0 });
            let mut own = images.at(target).filter(|image| owners[*image as usize] == owners[node as usize]);
            let image = own.next().ok_or_else(|| unmatched(&place, &along))?;
            pairs.push(Pair { node, image, along });
        }
    }
    // Images of different nodes differ: equal numbers on both sides leave none over.
    for axis in (0..3).filter(|axis| mesh.periodic[*axis]) {
        let [low, high] = [2 * axis, 2 * axis + 1].map(|side| sides.members(side).count());
        if low != high {
            let what = format!("{} nodes lie on {} and {high} on {}", low, SIDES[2 * axis].2, SIDES[2 * axis + 1].2);
            return Err(faces_differ(&what));
        }
    }
    Ok(pairs)
}

fn unmatched(place: &Vec3, along: &[bool; 3]) -> DeckError {
    let axis = along.iter().position(|along| *along).unwrap_or(0);
    let [x, y, z]: [f64; 3] = (*place).into();
    faces_differ(&format!("the node at {x:.4}, {y:.4}, {z:.4} mm has none opposite to it on {}", SIDES[2 * axis].2))
}

fn faces_differ(what: &str) -> DeckError {
    let remedy = "opposite faces must match node for node, as in voxels and lattices";
    DeckError::new("periodic_equations", "true", format!("{remedy}; here {what}"))
}
