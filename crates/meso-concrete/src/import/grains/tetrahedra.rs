//! The surface where values at the nodes of a lattice change their sign: marching tetrahedra.
//!
//! Every cell is cut into six tetrahedra about its diagonal (H. W. Kuhn, 1960). A tetrahedron has one piece of the surface, so
//! the surface is closed, each edge lies between two triangles, and it never crosses itself (A. Doi, A. Koide, 1991).

use meso_collision::geometry::TriangleMesh;
use meso_collision::math::Vec3;

/// Values at a box of nodes, x fastest; the outermost ones are negative. A surface between the outermost two ends at a wall
/// midway.
pub(super) struct Nodes<'a> {
    pub(super) counts: [usize; 3],
    pub(super) values: &'a [f32],
}

/// Orders of the axes on the ways from a cell's first corner to its last; odd ones turn a tetrahedron inside out.
const WAYS: [([usize; 3], bool); 6] = [
    ([0, 1, 2], false),
    ([1, 2, 0], false),
    ([2, 0, 1], false),
    ([0, 2, 1], true),
    ([2, 1, 0], true),
    ([1, 0, 2], true),
];
/// Least share of an edge between a node and the surface: nearer ones give slivers.
const LEAST_SHARE: f32 = 0.02;
const NONE: u32 = u32::MAX;

impl Nodes<'_> {
    /// The surface around the positive nodes, in units of cells from the first node.
    pub(super) fn surface(&self) -> TriangleMesh {
        let [nx, ny, nz] = self.counts;
        let mut marching = Marching {
            nodes: self,
            steps: [1, nx, nx * ny],
            crossings: vec![[NONE; 7]; self.values.len()],
            mesh: TriangleMesh { vertices: Vec::new(), triangles: Vec::new() },
        };
        for (y, z) in (0..nz - 1).flat_map(|z| (0..ny - 1).map(move |y| (y, z))) {
            let row = (z * ny + y) * nx;
            for x in 0..nx - 1 {
                marching.cell(row + x);
            }
        }
        marching.mesh
    }
}

struct Marching<'a> {
    nodes: &'a Nodes<'a>,
    /// Distance of neighbours along x, y, z.
    steps: [usize; 3],
    /// Vertices on the edges from each node, by the axes of the edge in three bits, less one.
    crossings: Vec<[u32; 7]>,
    mesh: TriangleMesh,
}

impl Marching<'_> {
    fn is_inside(&self, node: usize) -> bool {
        self.nodes.values[node] > 0.0
    }

    fn cell(&mut self, first: usize) {
        let [x, y, z] = self.steps;
        let own = self.is_inside(first);
        let others = [x, y, z, x + y, y + z, x + z, x + y + z];
        if others.iter().all(|step| self.is_inside(first + step) == own) {
            return;
        }
        for (way, is_odd) in WAYS {
            self.tetrahedron(first, way, is_odd);
        }
    }

    fn tetrahedron(&mut self, first: usize, [a, b, c]: [usize; 3], is_odd: bool) {
        let bits = [0, 1 << a, 1 << a | 1 << b, 7_usize];
        let steps = &self.steps;
        let nodes = [first, first + steps[a], first + steps[a] + steps[b], first + steps[a] + steps[b] + steps[c]];
        let inside = (0..4).filter(|&k| self.is_inside(nodes[k])).fold(0, |set, k| set | 1 << k);
        let Some((edges, is_reversed)) = pieces(inside) else { return };
        let corners = edges.map(|[p, q]| self.crossing(nodes[p.min(q)], nodes[p.max(q)], bits[p] ^ bits[q]));
        let is_quad = corners[3] != corners[0];
        for triangle in [[0, 1, 2], [0, 2, 3]].into_iter().take(1 + usize::from(is_quad)) {
            let [p, q, r] = triangle.map(|k| corners[k]);
            self.mesh.triangles.push(if is_odd == is_reversed { [p, q, r] } else { [p, r, q] });
        }
    }

    /// The vertex between two nodes, the first of which comes first.
    fn crossing(&mut self, from: usize, to: usize, axes: usize) -> u32 {
        let known = self.crossings[from][axes - 1];
        if known != NONE {
            return known;
        }
        let [p, q] = [from, to].map(|node| self.nodes.values[node]);
        let share = f64::from((p / (p - q)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE));
        let [nx, ny, nz] = self.nodes.counts;
        let at = [from % nx, from / nx % ny, from / (nx * ny)];
        let position = |axis: usize| match (axes >> axis & 1 == 1, at[axis]) {
            (false, node) => node as f64,
            // Walls are in the middle of the outermost cells.
            (true, 0) => 0.5,
            (true, node) if node + 2 == [nx, ny, nz][axis] => node as f64 + 0.5,
            (true, node) => node as f64 + share,
        };
        self.mesh.vertices.push(Vec3::from_fn(|axis, _| position(axis)));
        let vertex = self.mesh.vertices.len() as u32 - 1;
        self.crossings[from][axes - 1] = vertex;
        vertex
    }
}

/// The edges of a tetrahedron that a set of its corners crosses, in the order of a polygon seen from outside, and whether the
/// polygon is to be reversed. A triangle's first edge is repeated.
fn pieces(inside: usize) -> Option<([[usize; 2]; 4], bool)> {
    let edges = match inside {
        1 | 14 => [[0, 1], [0, 2], [0, 3], [0, 1]],
        2 | 13 => [[1, 0], [1, 3], [1, 2], [1, 0]],
        4 | 11 => [[2, 3], [2, 0], [2, 1], [2, 3]],
        8 | 7 => [[3, 2], [3, 1], [3, 0], [3, 2]],
        3 | 12 => [[0, 2], [0, 3], [1, 3], [1, 2]],
        5 | 10 => [[0, 3], [0, 1], [2, 1], [2, 3]],
        9 | 6 => [[0, 1], [0, 2], [3, 2], [3, 1]],
        _ => return None,
    };
    Some((edges, [14, 13, 11, 7, 12, 10, 6].contains(&inside)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aggregate::random::{Draw, Stream};
    use meso_collision::dents::SelfCrossing;

    #[test]
    fn any_values_give_a_closed_surface_that_never_crosses_itself() {
        for seed in 0..20 {
            let counts = [7, 6, 5];
            let mut stream = Stream::new(seed, Draw::Take, 0, 0);
            let is_outer = |i: usize| {
                let at = [i % 7, i / 7 % 6, i / 42];
                (0..3).any(|axis| at[axis] == 0 || at[axis] + 1 == counts[axis])
            };
            let mut value = |i: usize| if is_outer(i) { -1.0 } else { stream.uniform(-1.0, 1.0) as f32 };
            let values: Vec<f32> = (0..210).map(&mut value).collect();
            let mesh = Nodes { counts, values: &values }.surface();
            mesh.check_closed().unwrap();
            let facets = mesh.facets();
            assert_eq!((SelfCrossing { mesh: &mesh, facets: &facets }).find(), None);
            let inside = values.iter().filter(|value| **value > 0.0).count() as f64;
            assert!(mesh.volume() > 0.2 * inside && mesh.volume() < 2.0 * inside);
        }
    }
}
