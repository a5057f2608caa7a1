//! The sides of a mesh towards its bounding planes: their nodes, and the cells' faces on them.
//!
//! A side is what lies on its bounding plane. Where no face does (a cylinder's mantle), it is the part of the mesh's
//! surface that looks along that axis more than along the others, and at less than 45 degrees to it.
//!
//! Nodes on the faces of a periodic box are images of each other: one and the same in the endless specimen. With cohesive elements a
//! position has a node for each material there, and which these are depends on the cells behind the face. So images are told
//! apart by their *owner*, the aggregate whose cells have them, and `complete` gives an image on an upper face a node for each owner that a
//! cohesive element across the face needs there. Every node has cells or cohesive elements.

use super::cells::{Cells, Mesh, NO_AGGREGATE, Phase};
use super::interface::{NO_NODE, by_nodes};
use crate::math::{Aabb, Vec3};
use crate::packing::Specimen;
use rayon::prelude::*;

/// The bounding planes: axis, whether it is the upper one, and the name of its node set.
pub const SIDES: [(usize, bool, &str); 6] = [
    (0, false, "XMIN"),
    (0, true, "XMAX"),
    (1, false, "YMIN"),
    (1, true, "YMAX"),
    (2, false, "ZMIN"),
    (2, true, "ZMAX"),
];

/// A face looks along an axis where its unit normal's component is above the root of this: 45 degrees are 0.5, and the
/// flat triangles of a mantle lean a little.
const LOOKS: f64 = 0.45;

/// The nodes and faces of all sides.
#[derive(Clone, Debug)]
pub struct Sides {
    /// For every node a bit per side, in the order of [`SIDES`].
    nodes: Vec<u8>,
    faces: [Vec<(u32, usize)>; 6],
}

impl Sides {
    /// Those of `mesh`.
    pub fn of(mesh: &Mesh) -> Self {
        let cells = mesh.by_aggregate();
        let mut sides = Self::in_planes(cells);
        if sides.faces.iter().any(Vec::is_empty) {
            sides.add_curved(cells, &mesh.cohesive);
        }
        sides
    }

    /// Those of cells that fill a box.
    pub(crate) fn in_planes(cells: Cells) -> Self {
        let sides = Self::of_points(cells.points);
        Self { faces: in_planes(cells, &sides.nodes), ..sides }
    }

    /// The bounding planes of `points` and which of these lie on them, without any faces.
    pub(super) fn of_points(points: &[Vec3]) -> Self {
        Self { nodes: on_planes(points), faces: Default::default() }
    }

    /// The sides that `node` lies on.
    pub fn on(&self, node: u32) -> u8 {
        self.nodes[node as usize]
    }

    /// The nodes on side `bit` of [`SIDES`], ascending.
    pub fn members(&self, bit: usize) -> impl Iterator<Item = u32> {
        (0..).zip(&self.nodes).filter(move |(_, on)| **on >> bit & 1 == 1).map(|(node, _)| node)
    }

    /// The faces (cell, number of the face in [`CellKind::faces`](super::CellKind::faces)) on every side, by cell.
    pub fn faces(&self) -> &[Vec<(u32, usize)>; 6] {
        &self.faces
    }

    /// Gives the sides without a face in their plane those that look their way.
    fn add_curved(&mut self, mesh: Cells, cohesive: &[u32]) {
        let curved = [0, 1, 2, 3, 4, 5].map(|bit: usize| self.faces[bit].is_empty());
        for (cell, face) in outer_faces(mesh, cohesive) {
            let start = cell as usize * mesh.kind.nodes();
            let p = |i: usize| mesh.points[mesh.nodes[start + mesh.kind.faces()[face][i]] as usize];
            let normal = (p(1) - p(0)).cross(&(p(2) - p(0)));
            let axis = normal.iamax();
            let bit = 2 * axis + usize::from(normal[axis] > 0.0);
            if curved[bit] && normal[axis] * normal[axis] > LOOKS * normal.norm_squared() {
                self.faces[bit].push((cell, face));
                for &i in mesh.kind.face_nodes()[face] {
                    self.nodes[mesh.nodes[start + i] as usize] |= 1 << bit;
                }
            }
        }
    }
}

/// A bit per side, in the order of [`SIDES`], from the answers for the lower and the upper one across each axis.
pub(super) fn bits(of_axis: impl Fn(usize) -> [bool; 2]) -> u8 {
    (0..3).fold(0, |bits, axis| {
        let [low, high] = of_axis(axis).map(u8::from);
        bits | low << (2 * axis) | high << (2 * axis + 1)
    })
}

/// The sides across which a box repeats itself, a bit for each.
pub(crate) fn repeating(periodic: [bool; 3]) -> u8 {
    bits(|axis| [periodic[axis]; 2])
}

/// For every node a bit per bounding plane it lies on.
fn on_planes(points: &[Vec3]) -> Vec<u8> {
    let aabb = Aabb::around(points);
    let slack = 1e-9 * aabb.size().max();
    let on = |p: &Vec3| bits(|axis| [aabb.min, aabb.max].map(|plane| (p[axis] - plane[axis]).abs() <= slack));
    points.iter().map(on).collect()
}

/// The cells' faces on every bounding plane, by cell.
fn in_planes(mesh: Cells, nodes: &[u8]) -> [Vec<(u32, usize)>; 6] {
    let mut faces: [Vec<(u32, usize)>; 6] = Default::default();
    for (number, cell) in (0..).zip(mesh.iter()) {
        if cell.iter().all(|&node| nodes[node as usize] == 0) {
            continue;
        }
        for (face, corners) in mesh.kind.faces().iter().enumerate() {
            let on = corners.iter().fold(u8::MAX, |on, &i| on & nodes[cell[i] as usize]);
            (0..6).filter(|bit| on >> bit & 1 == 1).for_each(|bit| faces[bit].push((number, face)));
        }
    }
    faces
}

/// The faces that only one cell has, by cell; cohesive elements join the faces at their two sides.
fn outer_faces(mesh: Cells, cohesive: &[u32]) -> Vec<(u32, usize)> {
    let mut faces = by_nodes(mesh, |_| true);
    let joined = |face: &[u32]| {
        let mut nodes = [NO_NODE; 4];
        nodes[..face.len()].copy_from_slice(face);
        nodes.sort_unstable();
        (nodes, u32::MAX, 0)
    };
    faces.extend(cohesive.chunks_exact(mesh.kind.faces()[0].len()).map(joined));
    faces.par_sort_unstable();
    let lone = faces.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| &same[0]);
    let mut lone: Vec<(u32, usize)> = lone.map(|&(_, cell, face)| (cell, face as usize)).collect();
    lone.sort_unstable();
    lone
}

/// Points this near to a side, in sizes of the box, are on it.
const ROUNDING: f64 = 1e-9;

/// The flat sides of a specimen's box across which it does not repeat itself, where aggregates end before the mesh does; in the order of [`SIDES`].
pub(super) struct FlatSides {
    aabb: Aabb,
    /// A bit for each.
    sides: u8,
    slack: f64,
}

impl FlatSides {
    pub(super) fn of(specimen: &Specimen) -> Self {
        let aabb = specimen.aabb();
        Self { aabb, sides: !repeating(specimen.periodic().0), slack: ROUNDING * aabb.size().max() }
    }

    /// Whether `x` lies on one of the sides.
    pub(super) fn have(&self, x: &Vec3) -> bool {
        self.across(x) != 0
    }

    /// The sides that `x` lies on, a bit for each.
    pub(super) fn across(&self, x: &Vec3) -> u8 {
        let on = |axis| [x[axis] <= self.aabb.min[axis] + self.slack, x[axis] >= self.aabb.max[axis] - self.slack];
        bits(on) & self.sides
    }

    /// From `body` to the farthest of the sides `across`, mm.
    pub(super) fn gap(&self, body: &Aabb, across: u8) -> f64 {
        let gaps = |axis: usize| [body.min[axis] - self.aabb.min[axis], self.aabb.max[axis] - body.max[axis]];
        let all = [0, 1, 2].map(gaps);
        (0..6).filter(|side| across >> side & 1 == 1).map(|side| all.as_flattened()[side]).fold(0.0, f64::max)
    }
}

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

    /// The nodes at `position`, in the cell there or, hard by its border, in the next.
    pub(crate) fn at(&self, position: Vec3) -> impl Iterator<Item = u32> {
        let near = move |node: &u32| (self.points[*node as usize] - position).amax() <= SLACK * self.size;
        let cells = [-SLACK, SLACK].map(|slack| position.map(|x| ((x / self.size + slack) / CELL).floor() as i64));
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
    /// The lowest node at the image that lies on no upper face, or, where a void left none there, of all images: one number
    /// for all images of a position.
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
    let needed = needed(mesh, &joins(mesh, sides, &twins), &twins);
    for position in positions(&twins) {
        // `complete` numbers the nodes it adds at a position by their owners.
        let added = position.iter().filter(|twin| twin.owner == NOBODY);
        added.zip(missing(&needed, position)).for_each(|(twin, owner)| owners[twin.node as usize] = owner);
    }
    owners
}

/// The nodes at each position.
fn positions(twins: &[Twin]) -> impl Iterator<Item = &[Twin]> {
    twins.chunk_by(|a, b| (a.class, a.along) == (b.class, b.along))
}

/// Joins the materials that meet across a face by cohesive elements on the upper one, with nodes of their own where those of
/// the lower face's material are missing there.
pub(super) fn complete(mesh: &mut Mesh) {
    let sides = Sides::of(mesh);
    let owners = by_cells(mesh);
    let mut twins = twins(&mesh.points, mesh.periodic, &sides, &owners);
    let joins = joins(mesh, &sides, &twins);
    let needed = needed(mesh, &joins, &twins);
    let mut added = Vec::new();
    for position in positions(&twins) {
        for owner in missing(&needed, position) {
            let node = (mesh.points.len() + added.len()) as u32;
            added.push((mesh.points[position[0].node as usize], Twin { owner, node, ..position[0] }));
        }
    }
    mesh.points.extend(added.iter().map(|(point, _)| point));
    twins.extend(added.iter().map(|(_, twin)| twin));
    twins.sort_unstable();
    let classes = ImageClasses::new(mesh.points.len(), &twins);
    for Join { own, inside, outside } in joins {
        if let Some((aggregate, nodes)) = classes.join(own, inside, outside) {
            mesh.cohesive.extend(nodes);
            mesh.cohesive_aggregate.push(aggregate);
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
fn joins(mesh: &Mesh, sides: &Sides, twins: &[Twin]) -> Vec<Join> {
    let classes = ImageClasses::new(mesh.points.len(), twins);
    let corners = |&(cell, face): &(u32, usize)| -> Vec<u32> { mesh.by_aggregate().face(cell, face).collect() };
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
fn needed(mesh: &Mesh, joins: &[Join], twins: &[Twin]) -> Vec<(u32, u8, u32)> {
    let classes = ImageClasses::new(mesh.points.len(), twins);
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
fn missing<'a>(needed: &'a [(u32, u8, u32)], position: &'a [Twin]) -> impl Iterator<Item = u32> + 'a {
    let here = (position[0].class, position[0].along);
    let start = needed.partition_point(|entry| (entry.0, entry.1) < here);
    let needed = needed[start..].iter().take_while(move |entry| (entry.0, entry.1) == here);
    needed.map(|entry| entry.2).filter(|owner| position.iter().all(|twin| twin.owner != *owner))
}

/// Nodes on the faces by their image classes, and these by nodes.
struct ImageClasses<'a> {
    twins: &'a [Twin],
    /// Class and upper faces of every node that has them.
    of: Vec<Option<(u32, u8)>>,
}

impl<'a> ImageClasses<'a> {
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

    /// The node that `owner` has at the position of `node`.
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

/// The periodic images of nodes, whatever their owners.
#[derive(Default)]
pub(super) struct NodeImages {
    /// The image class of every node, and the upper faces that the node lies on, a bit per axis; empty where nothing
    /// repeats itself.
    classes: Vec<Option<(u32, u8)>>,
    /// Image classes with their nodes, ascending.
    members: Vec<(u32, u32)>,
}

impl NodeImages {
    /// Those of `points` on `sides` of a box across which it is `periodic`.
    pub(super) fn of(points: &[Vec3], periodic: [bool; 3], sides: &Sides) -> Self {
        let twins = twins(points, periodic, sides, &vec![NO_AGGREGATE; points.len()]);
        let mut members: Vec<(u32, u32)> = twins.iter().map(|twin| (twin.class, twin.node)).collect();
        members.sort_unstable();
        Self { classes: ImageClasses::new(points.len(), &twins).of, members }
    }

    /// The image class of a node, and the upper faces that it lies on, a bit per axis; `None` for nodes without an image.
    pub(super) fn class(&self, node: u32) -> Option<(u32, u8)> {
        self.classes.get(node as usize).copied().flatten()
    }

    /// The nodes of an image class, ascending.
    pub(super) fn at(&self, class: u32) -> impl ExactSizeIterator<Item = u32> {
        let start = self.members.partition_point(|member| member.0 < class);
        let count = self.members[start..].partition_point(|member| member.0 == class);
        self.members[start..start + count].iter().map(|member| member.1)
    }

    /// The nodes that have a class.
    pub(super) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.members.iter().map(|member| member.1)
    }
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
        Phase::Fibre => NO_AGGREGATE,
        _ => mesh.aggregate[cell as usize],
    }
}

/// The nodes on faces across which the box repeats itself, by class, upper faces, owner and number; without those that
/// have no image.
fn twins(points: &[Vec3], periodic: [bool; 3], sides: &Sides, owners: &[u32]) -> Vec<Twin> {
    let size = Aabb::around(points).size();
    let repeats = |node: &u32| sides.on(*node) & repeating(periodic) != 0;
    let nodes: Vec<u32> = (0..points.len() as u32).filter(repeats).collect();
    let upper = |node: u32| upper(periodic, sides, node);
    let is_upper = |node: u32| upper(node) != [false; 3];
    // Where a node's image that is on no upper face lies, or would.
    let mut lowest = points.to_vec();
    for &node in &nodes {
        let along = upper(node);
        lowest[node as usize] -= Vec3::from_fn(|axis, _| if along[axis] { size[axis] } else { 0.0 });
    }
    let images = Spots::new(&lowest, nodes.iter().copied());
    let twin = |&node: &u32| {
        let here = || images.at(lowest[node as usize]);
        let class = here().min_by_key(|&image| (is_upper(image), image))?;
        let along = (0..3).fold(0, |bits, axis| bits | u8::from(upper(node)[axis]) << axis);
        let has_image = !is_upper(node) || here().nth(1).is_some();
        has_image.then_some(Twin { class, along, owner: owners[node as usize], node })
    };
    let mut twins: Vec<Twin> = nodes.iter().filter_map(twin).collect();
    twins.sort_unstable();
    twins
}
