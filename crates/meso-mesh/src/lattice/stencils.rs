//! The stencils: lattice tetrahedra that a surface crosses are cut at its crossings with their edges.
//!
//! A tetrahedron of several bodies is cut one body at a time, lowest first, so that two tetrahedra see their common
//! face cut the same way. A quadrilateral left on a face, with apex u and cuts towards v and w, is halved by the diagonal
//! from the cut on the longer lattice edge (of equal ones: towards the lower node). Along one apex that is a total
//! order, so the three diagonals around a prism never form a cycle, which would have no tetrahedra.

use super::warp::{Field, OUTSIDE, alpha};
use crate::cells::{DROPPED, NO_BODY};
use crate::location::Locator;
use crate::tet::{TetMesh, centroid, oriented};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::stop;
use std::cmp::Reverse;

/// A field with all its cut edges.
pub(super) struct Cutter<'a> {
    field: &'a Field<'a>,
    locator: &'a Locator<'a>,
    /// Cut edges, lower node first, ascending; the index of an edge is that of its cut node, after the lattice's.
    edges: Vec<(u32, u32)>,
    /// Positions of all nodes: the lattice's, then the cuts.
    points: Vec<Vec3>,
}

/// The side of the body being cut out that a node lies on.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    In,
    Out,
    /// On its surface.
    On,
}

/// Tetrahedra with the body each lies in.
type Cells = Vec<([u32; 4], u32)>;

impl<'a> Cutter<'a> {
    pub(super) fn new(field: &'a Field<'a>, locator: &'a Locator<'a>) -> Self {
        let edges = parallel::flat_map(field.points.len(), |node| cut_edges(field, node as u32));
        let cuts = parallel::map_short(edges.len(), |edge| {
            let (a, b) = edges[edge];
            field.at(a, b, crossing(field, a, b))
        });
        let points = [field.points.as_slice(), cuts.as_slice()].concat();
        Self { field, locator, edges, points }
    }

    /// All tetrahedra, layer by layer.
    pub(super) fn cells(self) -> TetMesh {
        let layers: Vec<Cells> = parallel::map(self.field.bcc.counts[2], |k| {
            let mut cells = Vec::new();
            self.field.bcc.tetrahedra(k, |cell| self.resolve(cell, &mut cells));
            cells
        });
        let (cells, owner) = layers.concat().into_iter().unzip();
        TetMesh { points: self.points, cells, owner }
    }

    /// Cuts the lowest body out of a tetrahedron, then goes on with the rest.
    fn resolve(&self, cell: [u32; 4], cells: &mut Cells) {
        stop::point();
        let Some(body) = cell.iter().filter_map(|&node| self.body_around(node)).min() else {
            return self.emit(cell, self.owner_by_centroid(&cell), cells);
        };
        let sides = cell.map(|node| self.side(node, body));
        if !sides.contains(&Side::Out) {
            return self.emit(cell, body, cells);
        }
        let pick = |side: Side| (0..4).filter(move |&i| sides[i] == side).map(|i| cell[i]).collect::<Vec<u32>>();
        let (inside, outside) = self.split(&pick(Side::In), &pick(Side::Out), &pick(Side::On));
        inside.into_iter().for_each(|part| self.emit(part, body, cells));
        outside.into_iter().for_each(|part| self.resolve(part, cells));
    }

    fn emit(&self, cell: [u32; 4], body: u32, cells: &mut Cells) {
        cells.push((oriented(cell, &self.points), body));
    }

    fn is_cut(&self, node: u32) -> bool {
        node as usize >= self.field.points.len()
    }

    fn body_around(&self, node: u32) -> Option<u32> {
        (!self.is_cut(node) && self.field.is_deep(node)).then(|| self.field.label[node as usize])
    }

    fn side(&self, node: u32, body: u32) -> Side {
        if self.is_cut(node) || self.field.on[node as usize].contains(&body) {
            Side::On
        } else if self.body_around(node) == Some(body) {
            Side::In
        } else {
            Side::Out
        }
    }

    /// The label of a tetrahedron without a node inside a body: mortar when a node says so, else by its centroid.
    ///
    /// At the specimen's own surface it is mortar, too, but where all nodes lie on that and the centroid outside.
    fn owner_by_centroid(&self, cell: &[u32; 4]) -> u32 {
        if cell.iter().any(|&node| !self.is_cut(node) && !self.field.snapped(node)) {
            return NO_BODY;
        }
        if let Some(boundary) = self.field.boundary.filter(|_| cell.iter().any(|&node| self.is_outer(node))) {
            let kept =
                cell.iter().any(|&node| !self.is_outer(node)) || boundary.contains(&centroid(*cell, &self.points));
            return if kept { NO_BODY } else { OUTSIDE };
        }
        self.locator.find(&centroid(*cell, &self.points)).map_or(NO_BODY, |(body, _)| body as u32)
    }

    /// Whether a node lies on the specimen's own surface.
    fn is_outer(&self, node: u32) -> bool {
        match (node as usize).checked_sub(self.field.points.len()) {
            None => self.field.is_outer(node),
            Some(cut) => {
                [self.edges[cut].0, self.edges[cut].1].iter().any(|&end| self.body_around(end) == Some(OUTSIDE))
            }
        }
    }

    /// The cut node between two lattice nodes.
    fn cut(&self, a: u32, b: u32) -> u32 {
        let index =
            self.edges.binary_search(&(a.min(b), a.max(b))).expect("nodes on two sides have a cut between them");
        (self.field.points.len() + index) as u32
    }

    /// Whether the diagonal of the face (apex, v, w) starts at the cut towards v.
    fn first(&self, apex: u32, v: u32, w: u32) -> bool {
        let key = |end: u32| (Reverse(self.field.bcc.kind(apex, end)), end);
        key(v) < key(w)
    }

    /// The parts on both sides of the surface.
    fn split(&self, inner: &[u32], outer: &[u32], on: &[u32]) -> (Vec<[u32; 4]>, Vec<[u32; 4]>) {
        match (inner, outer, on) {
            (&[i], &[o], &[v, w]) => {
                let c = self.cut(i, o);
                (vec![[i, c, v, w]], vec![[o, c, v, w]])
            }
            (&[i], &[o, p], &[w]) => self.tip_and_pyramid(i, [o, p], w),
            (&[i, j], &[o], &[w]) => swap(self.tip_and_pyramid(o, [i, j], w)),
            (&[i], &[o, p, q], &[]) => self.tip_and_prism(i, [o, p, q]),
            (&[i, j, k], &[o], &[]) => swap(self.tip_and_prism(o, [i, j, k])),
            (&[i, j], &[o, p], &[]) => self.two_wedges([i, j], [o, p]),
            _ => (vec![], vec![[inner, outer, on].concat().try_into().expect("four nodes")]),
        }
    }

    fn tip_and_pyramid(&self, tip: u32, base: [u32; 2], w: u32) -> (Vec<[u32; 4]>, Vec<[u32; 4]>) {
        let [f, s] = if self.first(tip, base[0], base[1]) { base } else { [base[1], base[0]] };
        let (cf, cs) = (self.cut(tip, f), self.cut(tip, s));
        (vec![[tip, cf, cs, w]], vec![[cf, f, s, w], [cf, s, cs, w]])
    }

    fn tip_and_prism(&self, tip: u32, mut base: [u32; 3]) -> (Vec<[u32; 4]>, Vec<[u32; 4]>) {
        base.sort_by(
            |&v, &w| if self.first(tip, v, w) { std::cmp::Ordering::Less } else { std::cmp::Ordering::Greater },
        );
        let cuts = base.map(|v| self.cut(tip, v));
        let rails = [0, 1, 2].map(|r| [cuts[r], base[r]]);
        (vec![[tip, cuts[0], cuts[1], cuts[2]]], prism(rails).to_vec())
    }

    /// Two nodes in, two out: a wedge on either side of a quadrilateral.
    fn two_wedges(&self, p: [u32; 2], q: [u32; 2]) -> (Vec<[u32; 4]>, Vec<[u32; 4]>) {
        let c = p.map(|p| q.map(|q| self.cut(p, q)));
        // Rail 0 is the lattice edge, rails 1 and 2 run on the interface; `ahead[r]`: rail r starts its diagonal with rail 0.
        let ahead_p = q.map(|q| self.first(q, p[0], p[1]));
        let ahead_q = p.map(|p| self.first(p, q[0], q[1]));
        let straight = self.interface_diagonal(c, ahead_p, ahead_q);
        let rails_p = [p, [c[0][0], c[1][0]], [c[0][1], c[1][1]]];
        let rails_q = [q, c[0], c[1]];
        (wedge(rails_p, ahead_p, straight), wedge(rails_q, ahead_q, straight))
    }

    /// Whether the interface's diagonal is c00 to c11 rather than c01 to c10: as a wedge needs it, else the shorter one.
    fn interface_diagonal(&self, c: [[u32; 2]; 2], ahead_p: [bool; 2], ahead_q: [bool; 2]) -> bool {
        // Rails 1 and 2 on different sides of rail 0: the one ahead of rail 0 must be ahead of the other.
        let needed = |ahead: [bool; 2]| (ahead[0] != ahead[1]).then_some(ahead[0]);
        debug_assert!(needed(ahead_p).is_none_or(|p| needed(ahead_q).is_none_or(|q| p == q)));
        let length = |a: u32, b: u32| (self.points[a as usize] - self.points[b as usize]).norm_squared();
        let shorter = length(c[0][0], c[1][1]) <= length(c[0][1], c[1][0]);
        needed(ahead_p).or(needed(ahead_q)).unwrap_or(shorter)
    }
}

fn swap<T>((a, b): (T, T)) -> (T, T) {
    (b, a)
}

/// The edges to higher neighbours that a surface crosses, ascending.
fn cut_edges(field: &Field, node: u32) -> Vec<(u32, u32)> {
    stop::point();
    let mut edges = Vec::new();
    field.bcc.neighbours(node, |other| {
        if other > node && !field.compatible(node, other) {
            edges.push((node, other));
        }
    });
    edges.sort_unstable();
    edges
}

/// Where an edge is cut: at the surface; between two bodies at the surface nearer to the middle.
fn crossing(field: &Field, a: u32, b: u32) -> f64 {
    let leaves_a = field.is_deep(a).then(|| field.exit(a, b));
    let enters_b = field.is_deep(b).then(|| 1.0 - field.exit(b, a));
    let t = match (leaves_a, enters_b) {
        (Some(s), Some(t)) if (s - 0.5).abs() <= (t - 0.5).abs() => s,
        (_, Some(t)) => t,
        (s, None) => s.unwrap_or(0.5),
    };
    // A node on the box's faces or on the specimen's surface could not move: there the surface keeps a layer's distance.
    let limit = alpha(field.bcc.kind(a, b));
    let held = |node: u32| field.bcc.walls(node) != 0 || field.is_outer(node);
    let low = if held(a) { limit } else { 0.0 };
    let high = if held(b) { 1.0 - limit } else { 1.0 };
    t.clamp(low, high)
}

/// A prism from its rails in the order of their diagonals: rail 0's start meets the ends of 1 and 2, 1's that of 2.
fn prism([[a, d], [b, e], [c, f]]: [[u32; 2]; 3]) -> [[u32; 4]; 3] {
    [[a, b, c, f], [a, b, e, f], [a, d, e, f]]
}

/// A wedge's rails sorted by their diagonals, and cut.
fn wedge(rails: [[u32; 2]; 3], ahead: [bool; 2], straight: bool) -> Vec<[u32; 4]> {
    let later = usize::from(straight) + 1;
    let sooner = 3 - later;
    let order = match (ahead[sooner - 1], ahead[later - 1]) {
        (true, true) => [sooner, later, 0],
        (true, false) => [sooner, 0, later],
        (false, _) => [0, sooner, later],
    };
    prism(order.map(|r| rails[r])).to_vec()
}

/// Leaves out the cells outside of the specimen, and the nodes that only they have; for every node that is left whether it had
/// such cells: it lies on the specimen's own surface.
pub(super) fn trim(mesh: &mut TetMesh) -> Vec<bool> {
    let mut outer = vec![false; mesh.points.len()];
    for cell in mesh.numbers().filter(|&cell| mesh.owner[cell as usize] == OUTSIDE).collect::<Vec<_>>() {
        mesh.cell(cell).into_iter().for_each(|node| outer[node as usize] = true);
        mesh.remove(cell);
    }
    mesh.drop_removed();
    let number = mesh.drop_lone_nodes();
    let kept = outer.into_iter().zip(number).filter(|(_, number)| *number != DROPPED);
    kept.map(|(outer, _)| outer).collect()
}
