//! The nodes of a lattice whose surfaces are exact: what they are measured against, and what moves with them.

use super::boundary::Boundary;
use super::roles::Role;
use super::surface::Surface;
use crate::math::{Aabb, Vec3};
use crate::mesh::tet::{Incidence, Star, TetMesh, ascending};

/// What the nodes are fitted to.
pub(super) struct Exact<'a> {
    /// Of the bodies.
    pub(super) surfaces: &'a [Surface],
    /// Of the specimen.
    pub(super) boundary: &'a Boundary<'a>,
    /// Of the elements, mm.
    pub(super) size: f64,
}

/// The nodes of a mesh under repair, with all that a move of one is judged by.
pub(super) struct Nodes<'a> {
    pub(super) exact: &'a Exact<'a>,
    pub(super) mesh: &'a mut TetMesh,
    pub(super) incidence: &'a Incidence,
    pub(super) roles: &'a [Role],
    pub(super) pairs: &'a PeriodicPairs,
}

impl Nodes<'_> {
    pub(super) fn role(&self, node: u32) -> Role {
        self.roles[node as usize]
    }

    pub(super) fn position(&self, node: u32) -> Vec3 {
        self.mesh.position(node)
    }

    /// The cells of a node itself.
    pub(super) fn cells(&self, node: u32) -> &[u32] {
        self.incidence.cells(node)
    }

    pub(super) fn surface(&self, body: u32) -> &Surface {
        &self.exact.surfaces[body as usize]
    }

    /// The star of a node, with those of its images.
    pub(super) fn star(&self, node: u32) -> Star {
        let star = |node: u32| Star::of(self.mesh, node, self.cells(node));
        self.pairs.images(node).fold(star(node), |all, (image, shift)| all.with_image(star(image), &shift))
    }

    /// The cells around a node and its images.
    pub(super) fn cells_around(&self, node: u32) -> impl Iterator<Item = u32> {
        self.pairs.class(node).flat_map(|(node, _)| self.cells(node)).copied()
    }

    /// The nodes of `cells`, ascending.
    pub(super) fn of_cells(&self, cells: &[u32]) -> Vec<u32> {
        ascending(cells.iter().flat_map(|&cell| self.mesh.cell(cell)))
    }

    /// Moves the node and its images.
    pub(super) fn move_to(&mut self, node: u32, to: &Vec3) {
        self.mesh.points[node as usize] = *to;
        for (image, shift) in self.pairs.images(node) {
            let own = self.mesh.position(image);
            let image_position = Vec3::from_fn(|axis, _| if shift[axis] == 0.0 { to[axis] } else { own[axis] });
            self.mesh.points[image as usize] = image_position;
        }
    }
}

/// Images are this close to where they should be, in sizes of the box.
const SLACK: f64 = 1e-9;
/// Along this direction, to which no face or lattice line is square, few nodes are as far as another.
const ALONG: Vec3 = Vec3::new(1.0, 1.414, 1.731);

/// The periodic images of all nodes.
#[derive(Default)]
pub(super) struct PeriodicPairs {
    /// A node, an image of it, and the shift from the one to the other; by node.
    pairs: Vec<(u32, u32, Vec3)>,
}

impl PeriodicPairs {
    /// Those of the nodes that lie on faces of `domain` across which it `repeats` itself.
    pub(super) fn of(points: &[Vec3], domain: &Aabb, repeats: [bool; 3]) -> Self {
        let slack = SLACK * domain.size().max();
        let upper = |p: &Vec3| [0, 1, 2].map(|axis| repeats[axis] && p[axis] >= domain.max[axis]);
        let lower = |p: &Vec3| [0, 1, 2].map(|axis| repeats[axis] && p[axis] <= domain.min[axis]);
        // Where a node's image on no upper face is.
        let home = |p: &Vec3| {
            let upper = upper(p);
            Vec3::from_fn(|axis, _| if upper[axis] { domain.min[axis] } else { p[axis] })
        };
        let on_face = (0..).zip(points).filter(|(_, p)| lower(p).contains(&true) || upper(p).contains(&true));
        let mut nodes: Vec<(f64, Vec3, u32)> = on_face.map(|(node, p)| (home(p).dot(&ALONG), home(p), node)).collect();
        nodes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let shift = |from: u32, to: u32| {
            let (from, to) = (upper(&points[from as usize]), upper(&points[to as usize]));
            let steps = |axis: usize| f64::from(u8::from(to[axis])) - f64::from(u8::from(from[axis]));
            Vec3::from_fn(|axis, _| steps(axis) * domain.size()[axis])
        };
        let mut pairs = Vec::new();
        for (at, (along, position, node)) in nodes.iter().enumerate() {
            let near = nodes[at + 1..].iter().take_while(|(other, ..)| *other <= along + slack * ALONG.sum());
            for (.., other) in near.filter(|(_, other, _)| (other - position).amax() <= slack) {
                pairs.push((*node, *other, shift(*node, *other)));
                pairs.push((*other, *node, shift(*other, *node)));
            }
        }
        pairs.sort_by_key(|pair| (pair.0, pair.1));
        Self { pairs }
    }

    /// The nodes that have images, each as often as it has.
    pub(super) fn nodes(&self) -> impl Iterator<Item = u32> {
        self.pairs.iter().map(|pair| pair.0)
    }

    /// The images of a node, with the shifts to them, mm.
    pub(super) fn images(&self, node: u32) -> impl Iterator<Item = (u32, Vec3)> {
        let start = self.pairs.partition_point(|pair| pair.0 < node);
        self.pairs[start..].iter().take_while(move |pair| pair.0 == node).map(|pair| (pair.1, pair.2))
    }

    /// The node itself, then its images.
    pub(super) fn class(&self, node: u32) -> impl Iterator<Item = (u32, Vec3)> {
        std::iter::once((node, Vec3::zeros())).chain(self.images(node))
    }
}
