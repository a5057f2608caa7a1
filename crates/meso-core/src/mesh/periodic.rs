//! Nodes on the faces of a periodic box that are one and the same in the endless specimen: images of each other.
//!
//! With cohesive elements a place has a node for each material there, and which materials that are hangs on the cells
//! behind the face. So images are told apart by their *owner*, the aggregate whose cells have them, and [`complete`] gives
//! every image of a place a node for each owner that any of them has.

use super::cells::{Cells, Mesh, NO_AGGREGATE};
use super::sides::Sides;
use crate::math::{Aabb, Vec3};
use std::collections::BTreeSet;

/// Images are this close to where they should be, in sizes of the mesh.
const SLACK: f64 = 1e-9;
/// Edge of the cells that nodes are looked up by, in sizes of the mesh.
const CELL: f64 = 1e-6;
/// The owner of a node that no cell has, while it is not known.
const NOBODY: u32 = u32::MAX - 1;

/// Nodes by where they are.
pub(crate) struct Spots<'a> {
    points: &'a [Vec3],
    size: f64,
    /// By the cell that a node lies in.
    cells: Vec<([i64; 3], u32)>,
}

impl<'a> Spots<'a> {
    pub(crate) fn new(points: &'a [Vec3], nodes: impl Iterator<Item = u32>) -> Self {
        let size = Aabb::around(points).size().max();
        let cell = |node: u32| [0, 1, 2].map(|axis| (points[node as usize][axis] / (CELL * size)).floor() as i64);
        let mut cells: Vec<_> = nodes.map(|node| (cell(node), node)).collect();
        cells.sort_unstable();
        Self { points, size, cells }
    }

    /// The nodes at `place`, in the cell there or, hard by its border, in the next.
    pub(crate) fn at(&self, place: Vec3) -> impl Iterator<Item = u32> {
        let near = move |node: &u32| (self.points[*node as usize] - place).amax() <= SLACK * self.size;
        let cells = [-SLACK, SLACK].map(|slack| place.map(|x| ((x / self.size + slack) / CELL).floor() as i64));
        let [x, y, z] = [0, 1, 2].map(|axis| cells[0][axis]..=cells[1][axis]);
        let around = x
            .flat_map(move |i| y.clone().flat_map(move |j| [(i, j)]))
            .flat_map(move |(i, j)| z.clone().map(move |k| [i, j, k]));
        around.flat_map(|cell| self.in_cell(cell)).filter(near)
    }

    fn in_cell(&self, cell: [i64; 3]) -> impl Iterator<Item = u32> {
        let start = self.cells.partition_point(|entry| entry.0 < cell);
        self.cells[start..].iter().take_while(move |entry| entry.0 == cell).map(|entry| entry.1)
    }
}

/// A node on a face across which the box repeats itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Twin {
    /// The lowest node at the image that lies on no upper face: one number for all images of a place.
    class: u32,
    /// The upper faces that the node lies on, a bit per axis.
    along: u8,
    owner: u32,
    node: u32,
}

/// The upper faces that `node` lies on, by axis, as far as the box repeats itself there.
pub(crate) fn upper(periodic: [bool; 3], sides: &Sides, node: u32) -> [bool; 3] {
    [0, 1, 2].map(|axis| periodic[axis] && sides.on(node) >> (2 * axis + 1) & 1 == 1)
}

/// The aggregate that each node belongs to where cohesive elements part the materials; elsewhere nodes need no owner, and
/// all have the same.
pub(crate) fn owners(mesh: &Mesh, sides: &Sides) -> Vec<u32> {
    if mesh.cohesive.is_empty() {
        return vec![NO_AGGREGATE; mesh.points.len()];
    }
    let mut owners = by_cells(mesh);
    let twins = twins(&mesh.points, mesh.periodic, sides, &owners);
    for class in twins.chunk_by(|a, b| a.class == b.class) {
        let all = owners_of(class);
        for place in class.chunk_by(|a, b| a.along == b.along) {
            // `complete` numbers the nodes it adds at a place by their owners.
            let here = owners_of(place);
            let added = place.iter().filter(|twin| twin.owner == NOBODY);
            added.zip(all.difference(&here)).for_each(|(twin, owner)| owners[twin.node as usize] = *owner);
        }
    }
    owners
}

/// Gives every image of a place on the faces a node for each owner, and joins the materials that meet across a face by
/// cohesive elements on the upper one.
pub(super) fn complete(mesh: &mut Mesh) {
    let sides = Sides::of(mesh);
    let owners = by_cells(mesh);
    let mut twins = twins(&mesh.points, mesh.periodic, &sides, &owners);
    let mut added = Vec::new();
    for class in twins.chunk_by(|a, b| a.class == b.class) {
        let all = owners_of(class);
        for place in class.chunk_by(|a, b| a.along == b.along) {
            for &owner in all.difference(&owners_of(place)) {
                let node = (mesh.points.len() + added.len()) as u32;
                added.push((mesh.points[place[0].node as usize], Twin { owner, node, ..place[0] }));
            }
        }
    }
    mesh.points.extend(added.iter().map(|(point, _)| point));
    twins.extend(added.iter().map(|(_, twin)| twin));
    twins.sort_unstable();
    join_across(mesh, &sides, &twins);
}

/// Cohesive elements where a cell on an upper face meets another material's on the lower one.
fn join_across(mesh: &mut Mesh, sides: &Sides, twins: &[Twin]) {
    let places = Places::new(mesh.points.len(), twins);
    let mut joined = Vec::new();
    for axis in (0..3).filter(|axis| mesh.periodic[*axis]) {
        let lower = |face: &(u32, usize)| {
            Some((places.key(&corners(mesh.by_aggregate(), face))?, mesh.aggregate[face.0 as usize]))
        };
        let mut low: Vec<(Vec<u32>, u32)> = sides.faces()[2 * axis].iter().filter_map(lower).collect();
        low.sort_unstable();
        let opposite = |own: &[u32]| {
            let key = places.key(own)?;
            low.binary_search_by(|entry| entry.0.cmp(&key)).ok().map(|found| low[found].1)
        };
        for face in &sides.faces()[2 * axis + 1] {
            let (own, inside) = (corners(mesh.by_aggregate(), face), mesh.aggregate[face.0 as usize]);
            let outside = opposite(&own).filter(|outside| *outside != inside);
            joined.extend(outside.and_then(|outside| places.join(own, inside, outside)));
        }
    }
    for (aggregate, nodes) in joined {
        mesh.cohesive.extend(nodes);
        mesh.cohesive_aggregate.push(aggregate);
    }
}

/// The corners of a cell's face, counter-clockwise from outside.
fn corners(cells: Cells, &(cell, face): &(u32, usize)) -> Vec<u32> {
    cells.face(cell, face).collect()
}

/// Nodes on the faces by their places, and places by nodes.
struct Places<'a> {
    twins: &'a [Twin],
    /// Class and upper faces of every node that has them.
    of: Vec<Option<(u32, u8)>>,
}

impl<'a> Places<'a> {
    fn new(nodes: usize, twins: &'a [Twin]) -> Self {
        let mut of = vec![None; nodes];
        twins.iter().for_each(|twin| of[twin.node as usize] = Some((twin.class, twin.along)));
        Self { twins, of }
    }

    /// The classes of a face's corners: those of the face opposite to it, too.
    fn key(&self, nodes: &[u32]) -> Option<Vec<u32>> {
        let class = |&node: &u32| self.of[node as usize].map(|(class, _)| class);
        let mut classes = nodes.iter().map(class).collect::<Option<Vec<u32>>>()?;
        classes.sort_unstable();
        Some(classes)
    }

    /// The node that `owner` has at the place of `node`.
    fn owned(&self, node: u32, owner: u32) -> Option<u32> {
        let (class, along) = self.of[node as usize]?;
        let wanted = (class, along, owner);
        let start = self.twins.partition_point(|twin| (twin.class, twin.along, twin.owner) < wanted);
        self.twins.get(start).filter(|twin| (twin.class, twin.along, twin.owner) == wanted).map(|twin| twin.node)
    }

    /// A cohesive element, with its aggregate, between the face `own` of a cell of `inside` and `outside` beyond it. The
    /// lower aggregate's face comes first, its normal out of it.
    fn join(&self, own: Vec<u32>, inside: u32, outside: u32) -> Option<(u32, Vec<u32>)> {
        let other = own.iter().map(|&node| self.owned(node, outside)).collect::<Option<Vec<u32>>>()?;
        Some(match inside < outside {
            true => (inside, [own, other].concat()),
            false => (outside, other.into_iter().rev().chain(own.into_iter().rev()).collect()),
        })
    }
}

/// For every node on a face across which the box repeats itself one number for all images of its place, the lowest node at
/// the image that lies on no upper face, and the upper faces that it lies on, a bit per axis. `None` for other nodes, and
/// for those without an image.
pub(super) fn places(points: &[Vec3], periodic: [bool; 3], sides: &Sides) -> Vec<Option<(u32, u8)>> {
    Places::new(points.len(), &twins(points, periodic, sides, &vec![NO_AGGREGATE; points.len()])).of
}

/// The aggregate whose cells have a node, [`NOBODY`] where none does.
fn by_cells(mesh: &Mesh) -> Vec<u32> {
    let mut owners = vec![NOBODY; mesh.points.len()];
    for (cell, &aggregate) in mesh.cells().zip(&mesh.aggregate) {
        cell.iter().for_each(|&node| owners[node as usize] = aggregate);
    }
    owners
}

fn owners_of(twins: &[Twin]) -> BTreeSet<u32> {
    twins.iter().map(|twin| twin.owner).filter(|owner| *owner != NOBODY).collect()
}

/// The nodes on faces across which the box repeats itself, by class, upper faces, owner and number; without those that
/// have no image.
fn twins(points: &[Vec3], periodic: [bool; 3], sides: &Sides, owners: &[u32]) -> Vec<Twin> {
    let size = Aabb::around(points).size();
    let repeats = |node: &u32| (0..3).any(|axis| periodic[axis] && sides.on(*node) >> (2 * axis) & 3 != 0);
    let nodes: Vec<u32> = (0..points.len() as u32).filter(repeats).collect();
    let low = Spots::new(points, nodes.iter().copied().filter(|&node| upper(periodic, sides, node) == [false; 3]));
    let twin = |&node: &u32| {
        let upper = upper(periodic, sides, node);
        let place = points[node as usize];
        let image = Vec3::from_fn(|axis, _| place[axis] - if upper[axis] { size[axis] } else { 0.0 });
        let along = (0..3).fold(0, |bits, axis| bits | u8::from(upper[axis]) << axis);
        low.at(image).min().map(|class| Twin { class, along, owner: owners[node as usize], node })
    };
    let mut twins: Vec<Twin> = nodes.iter().filter_map(twin).collect();
    twins.sort_unstable();
    twins
}
