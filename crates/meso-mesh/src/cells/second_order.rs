//! Second-order tetrahedra: they have a node in the middle of every edge, shared by all the cells around it. Edges stay straight,
//! so that volumes, angles and surfaces are those of the first-order mesh.

use super::mesh::{CellKind, Mesh};
use meso_concrete::parallel;
use rayon::prelude::*;

/// A tetrahedron's edges by the numbers of their ends, in the order of their middles, nodes 5 to 10, in Abaqus and VTK.
pub(crate) const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

impl Mesh {
    /// Makes first-order tetrahedra second-order ones; other meshes, and those with cohesive elements, stay as they are.
    ///
    /// The new nodes come after the old ones, by the lower end of their edge, then by the upper.
    pub fn raise_order(&mut self) {
        if self.kind != CellKind::Tetrahedron || !self.cohesive.is_empty() {
            return;
        }
        let corners = self.points.len() as u32;
        let edges = Edges::of(self);
        let middles: Vec<_> = edges.ends().map(|[a, b]| (self.points[a] + self.points[b]) / 2.0).collect();
        self.points.extend(middles);
        let nodes = |cell: usize| {
            let cell = self.by_owner().cell(cell);
            let mut nodes = [0; 10];
            nodes[..4].copy_from_slice(cell);
            for (node, [i, j]) in nodes[4..].iter_mut().zip(EDGES) {
                *node = corners + edges.number(cell[i], cell[j]);
            }
            nodes
        };
        self.cells = parallel::map_short(self.cell_count(), nodes).into_flattened();
        self.kind = CellKind::QuadraticTetrahedron;
    }
}

/// The edges of a mesh, numbered by their lower end, then by the upper.
struct Edges {
    /// Where the edges of every lower end begin, and the end of all.
    first: Vec<u32>,
    upper: Vec<u32>,
}

impl Edges {
    fn of(mesh: &Mesh) -> Self {
        let ends = |cell: &[u32], [i, j]: [usize; 2]| (cell[i].min(cell[j]), cell[i].max(cell[j]));
        let of_cell = |cell: usize| EDGES.map(|edge| ends(mesh.by_owner().cell(cell), edge));
        let mut edges: Vec<(u32, u32)> = parallel::flat_map(mesh.cell_count(), of_cell);
        edges.par_sort_unstable();
        edges.dedup();
        let mut first = vec![0; mesh.points.len() + 1];
        edges.iter().for_each(|edge| first[edge.0 as usize + 1] += 1);
        (1..first.len()).for_each(|node| first[node] += first[node - 1]);
        Self { first, upper: edges.into_iter().map(|edge| edge.1).collect() }
    }

    /// The edge between two nodes of a cell.
    fn number(&self, a: u32, b: u32) -> u32 {
        let (low, high) = (a.min(b) as usize, a.max(b));
        let (first, end) = (self.first[low], self.first[low + 1]);
        let of_low = &self.upper[first as usize..end as usize];
        first + of_low.partition_point(|upper| *upper < high) as u32
    }

    fn ends(&self) -> impl Iterator<Item = [usize; 2]> {
        let lower = self.first.windows(2).enumerate();
        let lower = lower.flat_map(|(node, range)| std::iter::repeat_n(node, (range[1] - range[0]) as usize));
        lower.zip(&self.upper).map(|(low, high)| [low, *high as usize])
    }
}
