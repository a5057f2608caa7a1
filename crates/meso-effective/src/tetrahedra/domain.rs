//! Nodes and cells of a mesh, and the unknowns at its nodes.

use crate::field::FieldCells;
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_mesh::Mesh;
use meso_mesh::cells::{CellKind, NodeImages, Sides};
use std::sync::Arc;

/// A mesh of tetrahedra with the cells around its nodes.
pub(super) struct Domain {
    pub(super) mesh: Arc<Mesh>,
    /// Volume with the voids, mm3.
    pub(super) volume: f64,
    pub(super) sides: Sides,
    /// The image of every node that stands for all its periodic images.
    image: Vec<u32>,
    /// Corners at every such image, by node: four times the cell and the place in it.
    corners: Vec<u32>,
    starts: Vec<usize>,
}

/// A linear tetrahedron.
pub(super) struct Tetrahedron {
    pub(super) volume: f64,
    /// Gradients of the shape functions.
    pub(super) gradients: [Vec3; 4],
}

/// Nodes whose values are searched for.
pub(super) struct Unknowns {
    /// Unknown of every node of the mesh, or [`GIVEN`].
    pub(super) of: Vec<u32>,
    /// The node of every unknown.
    pub(super) nodes: Vec<u32>,
}

/// A node without unknown: its deviation is zero.
pub(super) const GIVEN: u32 = u32::MAX;
/// Cells that are added up in one sum.
const RUN: usize = 1 << 14;

impl Domain {
    pub(super) fn new(mesh: Mesh) -> Self {
        let sides = Sides::of(&mesh);
        let images = NodeImages::of(&mesh.points, mesh.periodic, &sides);
        let class = |node: usize| images.class(node as u32).map_or(node as u32, |(class, _)| class);
        let image: Vec<u32> = parallel::map_short(mesh.points.len(), class);
        let mut starts = vec![0; mesh.points.len() + 1];
        mesh.cells.iter().for_each(|node| starts[image[*node as usize] as usize + 1] += 1);
        (0..mesh.points.len()).for_each(|node| starts[node + 1] += starts[node]);
        let mut next = starts.clone();
        let mut corners = vec![0; mesh.cells.len()];
        for (corner, node) in (0..).zip(&mesh.cells) {
            let place = &mut next[image[*node as usize] as usize];
            corners[*place] = corner;
            *place += 1;
        }
        let mut domain = Self { mesh: Arc::new(mesh), volume: 0.0, sides, image, corners, starts };
        let [cells] = domain.sums(|cell| [domain.cell(cell).volume]);
        domain.volume = cells + domain.mesh.notes.voids_mm3;
        domain
    }

    /// The cells of a field.
    pub(super) fn field_cells(&self) -> FieldCells {
        FieldCells::Tetrahedra(Arc::clone(&self.mesh))
    }

    /// The unknowns of the nodes of cells for which `counts`, but for nodes on the sides whose bits `given` has.
    pub(super) fn unknowns(&self, given: u8, counts: impl Fn(usize) -> bool) -> Unknowns {
        let mut of = vec![GIVEN; self.mesh.points.len()];
        for (_, nodes) in self.mesh.cells().enumerate().filter(|(cell, _)| counts(*cell)) {
            nodes.iter().for_each(|node| of[self.image[*node as usize] as usize] = 0);
        }
        for node in (0..self.image.len()).filter(|node| self.sides.on(*node as u32) & given != 0) {
            of[self.image[node] as usize] = GIVEN;
        }
        let nodes: Vec<u32> = (0..of.len() as u32).filter(|node| of[*node as usize] != GIVEN).collect();
        (0..).zip(&nodes).for_each(|(unknown, node)| of[*node as usize] = unknown);
        let of = parallel::map_short(of.len(), |node| of[self.image[node] as usize]);
        Unknowns { of, nodes }
    }

    /// Corners at a node that stands for its images: the cell, and the place in it.
    pub(super) fn corners(&self, node: u32) -> impl Iterator<Item = (usize, usize)> {
        let range = self.starts[node as usize]..self.starts[node as usize + 1];
        self.corners[range].iter().map(|corner| (*corner as usize / 4, *corner as usize % 4))
    }

    /// The links from a node, cell by cell: the unknown at the other end, or [`GIVEN`], and `of` the cell and its two corners.
    pub(super) fn links<T>(
        &self,
        unknowns: &Unknowns,
        unknown: usize,
        of: impl Fn(usize, usize, usize) -> Option<T>,
    ) -> Vec<(u32, T)> {
        let mut links = Vec::with_capacity(72);
        for (cell, at) in self.corners(unknowns.nodes[unknown]) {
            for (other, node) in self.nodes(cell).into_iter().enumerate() {
                let to = unknowns.of[node];
                if to != unknown as u32 {
                    links.extend(of(cell, at, other).map(|link| (to, link)));
                }
            }
        }
        links
    }

    pub(super) fn nodes(&self, cell: usize) -> [usize; 4] {
        let nodes = &self.mesh.cells[4 * cell..][..4];
        [0, 1, 2, 3].map(|corner| nodes[corner] as usize)
    }

    /// Nodes of a face of a cell.
    pub(super) fn face(&self, cell: usize, face: usize) -> [usize; 3] {
        let (nodes, corners) = (self.nodes(cell), CellKind::Tetrahedron.faces()[face]);
        [0, 1, 2].map(|corner| nodes[corners[corner]])
    }

    /// The cell beyond the face opposite a corner.
    pub(super) fn beyond(&self, cell: usize, corner: usize) -> Option<usize> {
        let mut face = self.nodes(cell).into_iter().enumerate().filter(|(at, _)| *at != corner).map(|(_, node)| node);
        let [a, b, c] = [face.next()?, face.next()?, face.next()?];
        let has_face = |other: &usize| {
            let nodes = self.nodes(*other);
            *other != cell && nodes.contains(&b) && nodes.contains(&c)
        };
        self.corners(a as u32).map(|(other, _)| other).find(has_face)
    }

    pub(super) fn cell(&self, cell: usize) -> Tetrahedron {
        let [a, b, c, d] = self.nodes(cell).map(|node| self.mesh.points[node]);
        let (b, c, d) = (b - a, c - a, d - a);
        let six = b.cross(&c).dot(&d);
        let [b, c, d] = [c.cross(&d), d.cross(&b), b.cross(&c)].map(|normal| normal / six);
        Tetrahedron { volume: six / 6.0, gradients: [-(b + c + d), b, c, d] }
    }

    /// Sums over all cells.
    pub(super) fn sums<const N: usize>(&self, of: impl Fn(usize) -> [f64; N] + Sync) -> [f64; N] {
        let count = self.mesh.cell_count();
        let add = |sums: [f64; N], more: [f64; N]| std::array::from_fn(|i| sums[i] + more[i]);
        let run = |run: usize| (run * RUN..count.min((run + 1) * RUN)).map(&of).fold([0.0; N], add);
        parallel::map(count.div_ceil(RUN), run).into_iter().fold([0.0; N], add)
    }
}
