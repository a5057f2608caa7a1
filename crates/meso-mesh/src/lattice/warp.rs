//! The warp: lattice nodes that a surface passes closely move onto it.
//!
//! A node may be on the surfaces of several bodies; `on` holds them. Where two bodies come closer than a snapped node
//! can tell apart, the node is put on both: the gap is closed there.

use super::bcc::{Bcc, EdgeKind};
use super::boundary::BoundarySurface;
use crate::cells::NO_BODY;
use crate::location::{Facets, Label, PointGrid, Scan};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::stop;

/// "In no body", as a label, and an empty entry in a node's list of surfaces.
pub(super) const MORTAR: u32 = NO_BODY;

/// "Outside of the specimen", as a label and as a surface; higher than any body.
pub(super) const OUTSIDE: u32 = u32::MAX - 1;

/// A crossing nearer to a node than this share of the edge moves the node (Labelle and Shewchuk's values for a
/// body-centred lattice; the box-face diagonals take that of the long edges).
pub(super) fn alpha(kind: EdgeKind) -> f64 {
    match kind {
        EdgeKind::Short => 0.41189,
        EdgeKind::Long | EdgeKind::Diagonal => 0.24999,
    }
}

/// Rounds of the second look at moved nodes; each one only follows the changes of the one before.
const ROUNDS: usize = 6;

/// Lattice nodes with the bodies they lie in and on.
pub(super) struct Field<'a> {
    pub(super) bcc: &'a Bcc,
    pub(super) bodies: &'a [Facets],
    /// The specimen's surface where it is not the lattice's box.
    pub(super) boundary: Option<&'a BoundarySurface<'a>>,
    pub(super) points: Vec<Vec3>,
    /// Index of the body a node lies in, [`MORTAR`] or [`OUTSIDE`].
    pub(super) label: Vec<u32>,
    /// The bodies on whose surface a moved node lies, then [`MORTAR`]; all [`MORTAR`] for a node that was not moved.
    pub(super) on: Vec<[u32; 3]>,
}

/// A change of a node that a surface passes closely.
enum Change {
    /// The node goes onto the surface of the body.
    Move(u32, u32, Vec3),
    /// The node, already on a surface, counts as on this body's too.
    Close(u32, u32),
}

impl<'a> Field<'a> {
    pub(super) fn new(bcc: &'a Bcc, bodies: &'a [Facets], boundary: Option<&'a BoundarySurface>) -> Self {
        let points = parallel::map_short(bcc.nodes(), |node| bcc.position(node as u32));
        let mut label =
            labels(bodies, PointGrid { origin: points[0], spacing: bcc.spacing, counts: bcc.counts.map(|c| c + 1) });
        label.extend(labels(
            bodies,
            PointGrid { origin: points[bcc.corners()], spacing: bcc.spacing, counts: bcc.counts },
        ));
        if let Some(boundary) = boundary {
            parallel::each_mut(&mut label, |node, label| {
                if *label == MORTAR && !boundary.contains(&points[node]) {
                    *label = OUTSIDE;
                }
            });
        }
        let on = vec![[MORTAR; 3]; points.len()];
        Self { bcc, bodies, boundary, points, label, on }
    }

    /// Moves every node that a surface passes closely, then looks again at the edges of moved nodes.
    ///
    /// The specimen's surface comes first: a node on it is on no other. A node in a body beside one outside becomes one on
    /// the body's surface, so that mortar lies between the body and the outside.
    pub(super) fn warp(&mut self) {
        let mut touched = Vec::new();
        if self.boundary.is_some() {
            let moves = self.each_node(|node| self.first_move(node, |a, b| (a == OUTSIDE) != (b == OUTSIDE)));
            self.apply(moves);
            let moves = self.each_node(|node| self.retreat(node));
            touched = self.apply(moves);
        }
        let moves = self.each_node(|node| self.first_move(node, |a, b| a != OUTSIDE && b != OUTSIDE));
        touched.extend(self.apply(moves));
        for _ in 0..ROUNDS {
            let changes = parallel::flat_map(touched.len(), |i| self.second_look(touched[i]));
            touched = self.apply(changes);
            if touched.is_empty() {
                break;
            }
        }
    }

    pub(super) fn snapped(&self, node: u32) -> bool {
        self.on[node as usize][0] != MORTAR
    }

    /// True when no surface has to pass between two neighbours: they share a material.
    pub(super) fn compatible(&self, a: u32, b: u32) -> bool {
        match (self.snapped(a), self.snapped(b)) {
            (true, true) => true,
            (true, false) => self.may_be(a, self.label[b as usize]),
            (false, true) => self.may_be(b, self.label[a as usize]),
            (false, false) => self.label[a as usize] == self.label[b as usize],
        }
    }

    /// Can a tetrahedron at the moved node be of this label?
    fn may_be(&self, moved: u32, label: u32) -> bool {
        label == MORTAR || self.on[moved as usize].contains(&label)
    }

    /// Whether a node lies in a body, or outside of the specimen, and has not moved.
    pub(super) fn is_deep(&self, node: u32) -> bool {
        self.label[node as usize] != MORTAR && !self.snapped(node)
    }

    /// Whether a node lies on the specimen's own surface.
    pub(super) fn is_outer(&self, node: u32) -> bool {
        self.on[node as usize][0] == OUTSIDE
    }

    /// Where the surface of the body around `inside`, or of the specimen where that is outside of it, crosses the edge to
    /// `outside`, as a share of the edge.
    pub(super) fn exit(&self, inside: u32, outside: u32) -> f64 {
        let [from, to] = [inside, outside].map(|node| &self.points[node as usize]);
        match (self.label[inside as usize], self.boundary) {
            (OUTSIDE, Some(boundary)) => boundary.exit(from, to),
            (body, _) => self.bodies[body as usize].exit(from, to),
        }
    }

    /// The changes of all nodes, in their order.
    fn each_node(&self, change: impl Fn(u32) -> Option<Change> + Sync) -> Vec<Change> {
        parallel::flat_map(self.points.len(), |node| change(node as u32))
    }

    /// The nearest crossing of the node's edges between labels that count, measured against each edge's alpha.
    fn first_move(&self, node: u32, counts: impl Fn(u32, u32) -> bool) -> Option<Change> {
        stop::point();
        let label = self.label[node as usize];
        let mut best = (1.0, None);
        self.bcc.neighbours(node, |other| {
            let there = self.label[other as usize];
            if there == label || !counts(label, there) || !self.may_follow(node, other) {
                return;
            }
            let (t, body) = if label == MORTAR || there == OUTSIDE {
                (1.0 - self.exit(other, node), there)
            } else {
                (self.exit(node, other), label)
            };
            let ratio = t / alpha(self.bcc.kind(node, other));
            if ratio < best.0 {
                best = (ratio, Some(Change::Move(node, body, self.at(node, other, t))));
            }
        });
        best.1
    }

    /// A node in a body beside one outside counts as on the body's surface.
    fn retreat(&self, node: u32) -> Option<Change> {
        let label = self.label[node as usize];
        let mut beside = false;
        if self.is_deep(node) && label != OUTSIDE {
            let outside = |other: u32| self.label[other as usize] == OUTSIDE && !self.snapped(other);
            self.bcc.neighbours(node, |other| beside |= outside(other));
        }
        beside.then(|| Change::Move(node, label, self.points[node as usize]))
    }

    /// Nodes on the box's faces stay on them.
    fn may_follow(&self, node: u32, other: u32) -> bool {
        let walls = self.bcc.walls(node);
        walls & self.bcc.walls(other) == walls
    }

    pub(super) fn at(&self, node: u32, other: u32, t: f64) -> Vec3 {
        let [from, to] = [node, other].map(|node| self.points[node as usize]);
        // Not `lerp`, whose two products may leave a face of the box that both ends lie on.
        from + (to - from) * t
    }

    /// The edges from a moved node into other bodies: close the gap, move the other node, or leave the edge to be cut.
    fn second_look(&self, node: u32) -> Vec<Change> {
        stop::point();
        let mut changes = Vec::new();
        self.bcc.neighbours(node, |other| {
            if self.compatible(node, other) {
                return;
            }
            let (limit, body) = (alpha(self.bcc.kind(node, other)), self.label[other as usize]);
            let t = self.exit(other, node);
            if t < limit && self.may_follow(other, node) {
                changes.push(Change::Move(other, body, self.at(other, node, t)));
            } else if 1.0 - t < limit && self.may_follow(node, other) && !self.is_outer(node) && body != OUTSIDE {
                // On the box's faces only edges within them count: opposite faces of a periodic box must match.
                changes.push(Change::Close(node, body));
            }
        });
        changes
    }

    /// Carries the changes out in their order; returns the nodes that need a second look.
    fn apply(&mut self, changes: Vec<Change>) -> Vec<u32> {
        let mut touched = Vec::new();
        for change in changes {
            match change {
                Change::Move(node, body, point) if !self.snapped(node) => {
                    self.points[node as usize] = point;
                    self.on[node as usize][0] = body;
                    if body == OUTSIDE {
                        self.label[node as usize] = MORTAR;
                    }
                    touched.push(node);
                }
                Change::Close(node, body) => {
                    let on = &mut self.on[node as usize];
                    if let Some(free) = on.iter().position(|g| *g == MORTAR).filter(|_| !on.contains(&body)) {
                        on[free] = body;
                    }
                }
                Change::Move(..) => {}
            }
        }
        touched
    }
}

/// The body of every point of a grid.
fn labels(bodies: &[Facets], grid: PointGrid) -> Vec<u32> {
    let scan = Scan::new(grid, bodies);
    let mut labels = vec![Label::MORTAR; grid.counts.iter().product()];
    parallel::chunks_mut(&mut labels, grid.layer_len(), |k, layer| scan.label_layer(k, layer));
    parallel::map_short(labels.len(), |node| labels[node].body().unwrap_or(MORTAR))
}
