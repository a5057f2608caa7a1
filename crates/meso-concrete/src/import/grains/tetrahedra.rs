//! The surface where values at the nodes of a lattice change their sign: marching tetrahedra.
//!
//! Every cell is cut into six tetrahedra about its diagonal (H. W. Kuhn, 1960). A tetrahedron has one piece of the surface, so
//! the surface is closed, each edge lies between two triangles, and it never crosses itself (A. Doi, A. Koide, 1991).

use meso_collision::geometry::TriangleMesh;
use meso_collision::math::Vec3;
use std::collections::BTreeMap;

/// Values at a box of nodes, x fastest; the outermost ones are negative.
pub(super) struct Nodes {
    pub(super) counts: [usize; 3],
    /// Where the second nodes from below, and from above, lie in a wall, half a cell before the next ones. A surface between
    /// them and the outermost ones lies in the wall.
    pub(super) walls: [[bool; 2]; 3],
    pub(super) values: Vec<f32>,
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

impl Nodes {
    /// The surface around the positive nodes, in units of cells; the first nodes within are at 1.
    pub(super) fn surface(&self) -> TriangleMesh {
        let [nx, ny, nz] = self.counts;
        let mut marching = Marching {
            nodes: self,
            steps: [1, nx, nx * ny],
            crossings: vec![[NONE; 7]; self.values.len()],
            ends: BTreeMap::new(),
            mesh: TriangleMesh { vertices: Vec::new(), triangles: Vec::new() },
        };
        for (y, z) in (0..nz - 1).flat_map(|z| (0..ny - 1).map(move |y| (y, z))) {
            let row = (z * ny + y) * nx;
            // Most cells have no surface: the four nodes between a cell and the next one are looked at once.
            let within = |node: usize| {
                let nodes = [node, node + nx, node + nx * ny, node + nx * ny + nx];
                nodes.into_iter().filter(|&k| self.values[k] > 0.0).count()
            };
            let mut before = within(row);
            for first in row..row + nx - 1 {
                let next = within(first + 1);
                if !matches!(before + next, 0 | 8) {
                    marching.cell(first);
                }
                before = next;
            }
        }
        marching.mesh
    }
}

struct Marching<'a> {
    nodes: &'a Nodes,
    /// Distance of neighbours along x, y, z.
    steps: [usize; 3],
    /// Vertices on the edges from each node, by the axes of the edge in three bits, less one.
    crossings: Vec<[u32; 7]>,
    /// Vertices at nodes in the wall.
    ends: BTreeMap<usize, u32>,
    mesh: TriangleMesh,
}

impl Marching<'_> {
    fn is_inside(&self, node: usize) -> bool {
        self.nodes.values[node] > 0.0
    }

    fn cell(&mut self, first: usize) {
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
            // Beyond the wall a tetrahedron has its corners in the wall, and often on one line.
            if p != q && q != r && r != p {
                self.mesh.triangles.push(if is_odd == is_reversed { [p, q, r] } else { [p, r, q] });
            }
        }
    }

    /// The vertex between two nodes, the first of which comes first.
    fn crossing(&mut self, from: usize, to: usize, axes: usize) -> u32 {
        let known = self.crossings[from][axes - 1];
        if known != NONE {
            return known;
        }
        let ends = [from, to].map(|node| self.place(node));
        if let Some(outer) = ends.iter().position(|end| end.is_none()) {
            return self.end([to, from][outer]);
        }
        let [p, q] = [from, to].map(|node| self.nodes.values[node]);
        let share = f64::from((p / (p - q)).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE));
        let [start, end] = ends.map(Option::unwrap_or_default);
        self.crossings[from][axes - 1] = self.add(start + (end - start) * share);
        self.crossings[from][axes - 1]
    }

    /// The vertex at a node in the wall.
    fn end(&mut self, node: usize) -> u32 {
        let place = self.place(node).unwrap_or_default();
        let next = self.mesh.vertices.len() as u32;
        let vertex = *self.ends.entry(node).or_insert(next);
        if vertex == next { self.add(place) } else { vertex }
    }

    fn add(&mut self, position: Vec3) -> u32 {
        self.mesh.vertices.push(position);
        self.mesh.vertices.len() as u32 - 1
    }

    /// Position of a node; `None` beyond the wall.
    fn place(&self, node: usize) -> Option<Vec3> {
        let [nx, ny, nz] = self.nodes.counts;
        let at = [node % nx, node / nx % ny, node / (nx * ny)];
        let last = [nx - 1, ny - 1, nz - 1];
        let is_inner = (0..3).all(|axis| at[axis] > 0 && at[axis] < last[axis]);
        let within = |axis: usize| {
            let [low, high] = self.nodes.walls[axis].map(|is_there| if is_there { 1.0 } else { 0.0 });
            (at[axis] as f64 - low).clamp(0.5, last[axis] as f64 - low - high - 0.5)
        };
        is_inner.then(|| Vec3::from_fn(|axis, _| within(axis)))
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

    const COUNTS: [usize; 3] = [9, 8, 7];

    fn at(node: usize) -> [usize; 3] {
        [node % COUNTS[0], node / COUNTS[0] % COUNTS[1], node / (COUNTS[0] * COUNTS[1])]
    }

    fn is_outer(node: usize) -> bool {
        (0..3).any(|axis| at(node)[axis] == 0 || at(node)[axis] + 1 == COUNTS[axis])
    }

    #[test]
    fn any_values_give_a_closed_surface_that_never_crosses_itself() {
        for seed in 0..20 {
            let mut stream = Stream::new(seed, Draw::Take, 0, 0);
            let mut value = |i: usize| if is_outer(i) { -1.0 } else { stream.uniform(-1.0, 1.0) as f32 };
            let values: Vec<f32> = (0..COUNTS.iter().product()).map(&mut value).collect();
            let mesh = Nodes { counts: COUNTS, walls: [[true; 2]; 3], values: values.clone() }.surface();
            mesh.check_closed().unwrap();
            let facets = mesh.facets();
            assert_eq!((SelfCrossing { mesh: &mesh, facets: &facets }).find(), None);
            // Cells are half as long at a wall.
            let share = |axis: usize, node: usize| match node.min(COUNTS[axis] - 1 - node) {
                1 => 0.25,
                2 => 0.75,
                _ => 1.0,
            };
            let volume = |node: usize| (0..3).map(|axis| share(axis, at(node)[axis])).product::<f64>();
            let inside: f64 = (0..values.len()).filter(|node| values[*node] > 0.0).map(volume).sum();
            assert!(mesh.volume() > 0.2 * inside && mesh.volume() < 2.0 * inside, "{} of {inside}", mesh.volume());
        }
    }

    #[test]
    fn a_surface_meets_the_wall_at_right_angles_and_ends_in_it() {
        // A quarter of a cylinder about an edge of the box, 3.3 cells from the edge and 3 along it.
        let value = |node: usize| {
            let [x, y, _] = at(node).map(|x| x.max(2) as f32);
            let depth = 2.8 - (x - 2.0).hypot(y - 2.0);
            if is_outer(node) { -depth.abs() } else { depth }
        };
        let values: Vec<f32> = (0..COUNTS.iter().product()).map(value).collect();
        let mesh = Nodes { counts: COUNTS, walls: [[true; 2]; 3], values: values.clone() }.surface();
        mesh.check_closed().unwrap();
        let (mut caps, mut beside) = (0.0, 0);
        for [a, b, c] in mesh.facets().corners() {
            let normal = (b - a).cross(&(c - a)) / 2.0;
            for axis in 0..2 {
                let in_wall = [a, b, c].iter().filter(|corner| corner[axis] == 0.5).count();
                caps += if in_wall == 3 { -normal[axis] } else { 0.0 };
                beside += usize::from(in_wall == 2 && normal[axis] == 0.0);
                assert!(in_wall == 0 || in_wall == 3 || normal[axis].abs() < 1e-9, "{a} {b} {c}");
            }
        }
        assert!(beside > 10 && (caps - 2.0 * 3.3 * 3.0).abs() < 1e-5, "{beside} {caps}");
    }
}
