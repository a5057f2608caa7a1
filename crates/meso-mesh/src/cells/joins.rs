//! Cohesive elements across the faces of a periodic box.
//!
//! [`complete`] gives an image on an upper face a node for each owner that a cohesive element across the face needs there. Every
//! node has cells or cohesive elements.

use super::images::{ImageClasses, NodeImage, images, positions};
use super::mesh::{Mesh, NO_BODY};
use super::sides::Sides;
use meso_concrete::Phase;

/// The owner of a node that no cell has, while it is not known.
const NOBODY: u32 = u32::MAX - 1;

/// The aggregate that each node belongs to where cohesive elements part the materials; elsewhere nodes need no owner, and
/// all have the same.
pub fn owners(mesh: &Mesh, sides: &Sides) -> Vec<u32> {
    if mesh.cohesive.is_empty() {
        return vec![NO_BODY; mesh.points.len()];
    }
    let mut owners = by_cells(mesh);
    let images = images(&mesh.points, mesh.periodic, sides, &owners);
    let needed = needed(mesh, &joins(mesh, sides, &images), &images);
    for position in positions(&images) {
        // `complete` numbers the nodes it adds at a position by their owners.
        let added = position.iter().filter(|image| image.owner == NOBODY);
        added.zip(missing(&needed, position)).for_each(|(image, owner)| owners[image.node as usize] = owner);
    }
    owners
}

/// Joins the materials that meet across a face by cohesive elements on the upper one, with nodes of their own where those of
/// the lower face's material are missing there.
pub(crate) fn complete(mesh: &mut Mesh) {
    let sides = Sides::of(mesh);
    let owners = by_cells(mesh);
    let mut images = images(&mesh.points, mesh.periodic, &sides, &owners);
    let joins = joins(mesh, &sides, &images);
    let needed = needed(mesh, &joins, &images);
    let mut added = Vec::new();
    for position in positions(&images) {
        for owner in missing(&needed, position) {
            let node = (mesh.points.len() + added.len()) as u32;
            added.push((mesh.points[position[0].node as usize], NodeImage { owner, node, ..position[0] }));
        }
    }
    mesh.points.extend(added.iter().map(|(point, _)| point));
    images.extend(added.iter().map(|(_, image)| image));
    images.sort_unstable();
    let classes = ImageClasses::new(mesh.points.len(), &images);
    for Join { own, inside, outside } in joins {
        if let Some((aggregate, nodes)) = classes.join(own, inside, outside) {
            mesh.cohesive.extend(nodes);
            mesh.cohesive_owner.push(aggregate);
        }
    }
}

/// A cell's face on an upper face of the box, by its nodes, and the two materials that meet there.
struct Join {
    own: Vec<u32>,
    inside: u32,
    outside: u32,
}

/// Where a cell on an upper face meets another material's on the lower one.
fn joins(mesh: &Mesh, sides: &Sides, images: &[NodeImage]) -> Vec<Join> {
    let classes = ImageClasses::new(mesh.points.len(), images);
    let corners = |&(cell, face): &(u32, usize)| -> Vec<u32> { mesh.by_owner().face(cell, face).collect() };
    let mut joins = Vec::new();
    for axis in (0..3).filter(|axis| mesh.periodic[*axis]) {
        let lower = |face: &(u32, usize)| Some((classes.key(&corners(face))?, material(mesh, face.0)));
        let mut low: Vec<(Vec<u32>, u32)> = sides.faces()[2 * axis].iter().filter_map(lower).collect();
        low.sort_unstable();
        let opposite = |own: &[u32]| {
            let key = classes.key(own)?;
            low.binary_search_by(|entry| entry.0.cmp(&key)).ok().map(|found| low[found].1)
        };
        for face in &sides.faces()[2 * axis + 1] {
            let (own, inside) = (corners(face), material(mesh, face.0));
            let outside = opposite(&own).filter(|outside| *outside != inside);
            joins.extend(outside.map(|outside| Join { own, inside, outside }));
        }
    }
    joins
}

/// The positions on upper faces (class and `along`) with the owners that cohesive elements across them need there, ascending.
fn needed(mesh: &Mesh, joins: &[Join], images: &[NodeImage]) -> Vec<(u32, u8, u32)> {
    let classes = ImageClasses::new(mesh.points.len(), images);
    let of_join = |join: &Join| -> Vec<(u32, u8, u32)> {
        let position = |&node: &u32| classes.of[node as usize].map(|(class, along)| (class, along, join.outside));
        join.own.iter().filter_map(position).collect()
    };
    let mut needed: Vec<(u32, u8, u32)> = joins.iter().flat_map(of_join).collect();
    needed.sort_unstable();
    needed.dedup();
    needed
}

/// The owners needed at a position, given by its nodes, that have no cells there, ascending.
fn missing<'a>(needed: &'a [(u32, u8, u32)], position: &'a [NodeImage]) -> impl Iterator<Item = u32> + 'a {
    let here = (position[0].class, position[0].along);
    let start = needed.partition_point(|entry| (entry.0, entry.1) < here);
    let needed = needed[start..].iter().take_while(move |entry| (entry.0, entry.1) == here);
    needed.map(|entry| entry.2).filter(|owner| position.iter().all(|image| image.owner != *owner))
}

/// The aggregate whose cells have a node, [`NOBODY`] where none does.
fn by_cells(mesh: &Mesh) -> Vec<u32> {
    let mut owners = vec![NOBODY; mesh.points.len()];
    for (number, cell) in (0..).zip(mesh.cells()) {
        cell.iter().for_each(|&node| owners[node as usize] = material(mesh, number));
    }
    owners
}

/// The aggregate of a cell. Fibres count as mortar, to which they are bonded: both have the same nodes.
fn material(mesh: &Mesh, cell: u32) -> u32 {
    match mesh.phase[cell as usize] {
        Phase::Fibre => NO_BODY,
        _ => mesh.owner[cell as usize],
    }
}
