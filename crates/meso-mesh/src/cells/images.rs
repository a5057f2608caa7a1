//! The periodic images of nodes.
//!
//! Nodes on the faces of a periodic box are images of each other: one and the same in the endless specimen. With cohesive elements a
//! position has a node for each material there, and which these are depends on the cells behind the face. So images are told
//! apart by their *owner*, the aggregate whose cells have them.

use super::mesh::NO_BODY;
use super::sides::{Sides, repeating};
use meso_collision::math::{Aabb, Vec3};

/// Images are this close to where they should be, in sizes of the mesh.
const SLACK: f64 = 1e-9;
/// Edge of the cells that nodes are looked up by, in sizes of the mesh.
const CELL: f64 = 1e-6;

/// Nodes by where they are.
pub struct Spots<'a> {
    points: &'a [Vec3],
    size: f64,
    /// By the cell that a node lies in.
    cells: Vec<([i64; 3], u32)>,
}

impl<'a> Spots<'a> {
    /// Sorts some `nodes` of `points` into a grid.
    pub fn new(points: &'a [Vec3], nodes: impl Iterator<Item = u32>) -> Self {
        let size = Aabb::around(points).size().max();
        let cell = |node: u32| [0, 1, 2].map(|axis| (points[node as usize][axis] / (CELL * size)).floor() as i64);
        let mut cells: Vec<_> = nodes.map(|node| (cell(node), node)).collect();
        cells.sort_unstable();
        Self { points, size, cells }
    }

    /// The nodes at `position`, in the cell there or, hard by its border, in the next.
    pub fn at(&self, position: Vec3) -> impl Iterator<Item = u32> {
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
pub(super) struct NodeImage {
    /// The lowest node at the image that lies on no upper face, or, where a void left none there, of all images: one number
    /// for all images of a position.
    pub(super) class: u32,
    /// The upper faces that the node lies on, a bit per axis.
    pub(super) along: u8,
    pub(super) owner: u32,
    pub(super) node: u32,
}

/// The upper faces that `node` lies on, by axis, as far as the box repeats itself there.
pub fn upper(periodic: [bool; 3], sides: &Sides, node: u32) -> [bool; 3] {
    [0, 1, 2].map(|axis| periodic[axis] && sides.on(node) >> (2 * axis + 1) & 1 == 1)
}

/// The nodes at each position.
pub(super) fn positions(images: &[NodeImage]) -> impl Iterator<Item = &[NodeImage]> {
    images.chunk_by(|a, b| (a.class, a.along) == (b.class, b.along))
}

/// Nodes on the faces by their image classes, and these by nodes.
pub(super) struct ImageClasses<'a> {
    images: &'a [NodeImage],
    /// Class and upper faces of every node that has them.
    pub(super) of: Vec<Option<(u32, u8)>>,
}

impl<'a> ImageClasses<'a> {
    pub(super) fn new(nodes: usize, images: &'a [NodeImage]) -> Self {
        let mut of = vec![None; nodes];
        images.iter().for_each(|image| of[image.node as usize] = Some((image.class, image.along)));
        Self { images, of }
    }

    /// The classes of a face's corners: those of the face opposite to it, too.
    pub(super) fn key(&self, nodes: &[u32]) -> Option<Vec<u32>> {
        let class = |&node: &u32| self.of[node as usize].map(|(class, _)| class);
        let mut classes = nodes.iter().map(class).collect::<Option<Vec<u32>>>()?;
        classes.sort_unstable();
        Some(classes)
    }

    /// The node that `owner` has at the position of `node`.
    fn owned(&self, node: u32, owner: u32) -> Option<u32> {
        let (class, along) = self.of[node as usize]?;
        let wanted = (class, along, owner);
        let start = self.images.partition_point(|image| (image.class, image.along, image.owner) < wanted);
        self.images.get(start).filter(|image| (image.class, image.along, image.owner) == wanted).map(|image| image.node)
    }

    /// A cohesive element, with its aggregate, between the face `own` of a cell of `inside` and `outside` beyond it. The
    /// lower aggregate's face comes first, its normal out of it.
    pub(super) fn join(&self, own: Vec<u32>, inside: u32, outside: u32) -> Option<(u32, Vec<u32>)> {
        let other = own.iter().map(|&node| self.owned(node, outside)).collect::<Option<Vec<u32>>>()?;
        Some(match inside < outside {
            true => (inside, [own, other].concat()),
            false => (outside, other.into_iter().rev().chain(own.into_iter().rev()).collect()),
        })
    }
}

/// The periodic images of nodes, whatever their owners.
#[derive(Default)]
pub struct NodeImages {
    /// The image class of every node, and the upper faces that the node lies on, a bit per axis; empty where nothing
    /// repeats itself.
    classes: Vec<Option<(u32, u8)>>,
    /// Image classes with their nodes, ascending.
    members: Vec<(u32, u32)>,
}

impl NodeImages {
    /// Finds the images of `points` on `sides` of a box across which it is `periodic`.
    pub fn of(points: &[Vec3], periodic: [bool; 3], sides: &Sides) -> Self {
        let images = images(points, periodic, sides, &vec![NO_BODY; points.len()]);
        let mut members: Vec<(u32, u32)> = images.iter().map(|image| (image.class, image.node)).collect();
        members.sort_unstable();
        Self { classes: ImageClasses::new(points.len(), &images).of, members }
    }

    /// The image class of a node, and the upper faces that it lies on, a bit per axis; `None` for nodes without an image.
    pub fn class(&self, node: u32) -> Option<(u32, u8)> {
        self.classes.get(node as usize).copied().flatten()
    }

    /// The nodes of an image class, ascending.
    pub(crate) fn at(&self, class: u32) -> impl ExactSizeIterator<Item = u32> {
        let start = self.members.partition_point(|member| member.0 < class);
        let count = self.members[start..].partition_point(|member| member.0 == class);
        self.members[start..start + count].iter().map(|member| member.1)
    }

    /// The nodes that have a class.
    pub(crate) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.members.iter().map(|member| member.1)
    }
}

/// The nodes on faces across which the box repeats itself, by class, upper faces, owner and number; without those that
/// have no image.
pub(super) fn images(points: &[Vec3], periodic: [bool; 3], sides: &Sides, owners: &[u32]) -> Vec<NodeImage> {
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
    let spots = Spots::new(&lowest, nodes.iter().copied());
    let image = |&node: &u32| {
        let here = || spots.at(lowest[node as usize]);
        let class = here().min_by_key(|&image| (is_upper(image), image))?;
        let along = (0..3).fold(0, |bits, axis| bits | u8::from(upper(node)[axis]) << axis);
        let has_image = !is_upper(node) || here().nth(1).is_some();
        has_image.then_some(NodeImage { class, along, owner: owners[node as usize], node })
    };
    let mut images: Vec<NodeImage> = nodes.iter().filter_map(image).collect();
    images.sort_unstable();
    images
}
