//! Remeshing around interface nodes that could not be reprojected: other cells, or one node less.
//!
//! A body's face may run so close along the specimen's side that cells with good angles hardly fit between the two.
//!
//! 1. The node moves onto the body. Swaps of the cells around it ([`swapped`]) and smoothing of its neighbours on their
//!    surfaces alternate until no angle is too small.
//! 2. Where that fails, the node is contracted onto a neighbour on the body and the same follows: one layer of cells fits
//!    between body and side where two do not.
//!
//! All of it happens in a copy of the cells around the node, which replaces them if no angle is too small.

use super::nodes::{Nodes, PeriodicPairs, Role};
use super::reprojection::positions_apart;
use super::smoothing::smooth;
use crate::math::Vec3;
use crate::mesh::tet::{Incidence, Star, TetMesh, Topology, ascending, cos2_of, swapped};

/// The nodes that move lie in so many rings less one around the node.
const RINGS: usize = 4;
/// Positions on the body that are tried, at most, and how far apart they lie, in elements. (With 3 rings and 24 positions 3 of 17
/// nodes of the paper's specimen at 2 mm, and 1 of 17 of a cylinder, find no cells with angles above 10 degrees; with these
/// all do.)
const POSITIONS: usize = 48;
const APART: f64 = 0.05;
/// Rounds of moves and swaps at each place. More moves before each round's swaps find less.
const ROUNDS: usize = 30;

/// Other cells in the place of some.
pub(super) struct Remeshed {
    /// The nodes that move, with their new positions.
    pub(super) positions: Vec<(u32, Vec3)>,
    /// Cells that are removed.
    pub(super) old: Vec<u32>,
    /// Cells in their place, with their owners.
    pub(super) new: Vec<([u32; 4], u32)>,
}

/// Cells with which `node` lies on its body, or is one with a node on it, and that leave all angles above `least_deg`, or as
/// they were where one is smaller, if such are found.
pub(super) fn remeshed(nodes: &Nodes, node: u32, least_deg: f64) -> Option<Remeshed> {
    let patch = Patch::around(nodes, node);
    let limit = patch.worst().max(cos2_of(least_deg));
    let positions = positions_apart(nodes, node, APART * nodes.exact.size, POSITIONS);
    let moved = positions.iter().map(|position| patch.with(node, position));
    let contracted = nearest_on_body(nodes, node).into_iter().map(|into| patch.contracted(node, into));
    let mut tried = moved.chain(contracted);
    tried.find_map(|mut tried| tried.comes_out(nodes, limit).then(|| tried.in_place_of(&patch)))
}

/// The neighbour on its body that `node` is best contracted onto, if one leaves all angles above `least_deg`.
///
/// The others of its cells fill the place of those that both have: where they all keep a positive volume the mesh stays one
/// without gaps or overlaps, since the rim of both stars stays as it is.
pub(super) fn contraction(nodes: &Nodes, node: u32, least_deg: f64) -> Option<u32> {
    let mut best = (cos2_of(least_deg), None);
    for into in neighbours_on_body(nodes, node) {
        let rest: Vec<u32> =
            nodes.cells(node).iter().copied().filter(|&cell| !nodes.mesh.cell(cell).contains(&into)).collect();
        let worst = Star::of(nodes.mesh, node, &rest).worst(&nodes.position(into), best.0);
        if worst <= best.0 {
            best = (worst, Some(into));
        }
    }
    best.1
}

/// The neighbours of `node` that lie on its body, ascending.
fn neighbours_on_body(nodes: &Nodes, node: u32) -> Vec<u32> {
    let role @ Role::Surface(body) = nodes.role(node) else { return Vec::new() };
    let mut near = nodes.of_cells(nodes.cells(node));
    let lies_on = |other: u32| nodes.role(other) == role && nodes.surface(body).has(&nodes.position(other));
    near.retain(|&other| other != node && lies_on(other));
    near
}

/// The same, the nearest first.
fn nearest_on_body(nodes: &Nodes, node: u32) -> Vec<u32> {
    let away = |other: &u32| (nodes.position(*other) - nodes.position(node)).norm_squared();
    let mut near = neighbours_on_body(nodes, node);
    near.sort_by(|a, b| away(a).total_cmp(&away(b)));
    near
}

/// A copy of what is around a node, with numbers of its own.
#[derive(Clone)]
struct Patch {
    /// The nodes by their numbers in the whole mesh, ascending.
    nodes: Vec<u32>,
    /// The cells' numbers in the whole mesh.
    cells: Vec<u32>,
    mesh: TetMesh,
    /// Nodes that have cells elsewhere are fixed.
    roles: Vec<Role>,
}

impl Patch {
    fn around(whole: &Nodes, node: u32) -> Self {
        let (mut within, mut nodes, mut cells) = (Vec::new(), vec![node], Vec::new());
        for _ in 0..RINGS {
            within = nodes;
            cells = ascending(within.iter().flat_map(|&node| whole.cells(node)).copied());
            nodes = whole.of_cells(&cells);
        }
        let number = |node: u32| nodes.partition_point(|other| *other < node) as u32;
        let role = |node: &u32| {
            let moves = within.binary_search(node).is_ok() && !whole.cells(*node).is_empty();
            match whole.role(*node) {
                // Their images are elsewhere.
                Role::Paired(_) => Role::Fixed,
                role if moves => role,
                _ => Role::Fixed,
            }
        };
        let mesh = TetMesh {
            points: nodes.iter().map(|&node| whole.position(node)).collect(),
            cells: cells.iter().map(|&cell| whole.mesh.cell(cell).map(number)).collect(),
            owner: cells.iter().map(|&cell| whole.mesh.owner[cell as usize]).collect(),
        };
        Self { roles: nodes.iter().map(role).collect(), nodes, cells, mesh }
    }

    fn number(&self, node: u32) -> u32 {
        self.nodes.partition_point(|other| *other < node) as u32
    }

    /// With `node` at `position`.
    fn with(&self, node: u32, position: &Vec3) -> Self {
        let mut patch = self.clone();
        patch.mesh.points[self.number(node) as usize] = *position;
        patch
    }

    /// With `node` contracted onto `into`. Other cells turn over as they may.
    fn contracted(&self, node: u32, into: u32) -> Self {
        let mut patch = self.clone();
        let (node, into) = (self.number(node), self.number(into));
        let around: Vec<u32> = self.mesh.numbers().filter(|&cell| self.mesh.cell(cell).contains(&node)).collect();
        patch.mesh.contract(node, into, &around);
        patch.mesh.drop_removed();
        patch
    }

    fn poor(&self, limit: f64) -> Vec<u32> {
        self.mesh.numbers().filter(|&cell| self.mesh.cos2(cell) > limit).collect()
    }

    fn worst(&self) -> f64 {
        self.mesh.numbers().map(|cell| self.mesh.cos2(cell)).fold(-1.0, f64::max)
    }

    /// Whether smoothing and swaps leave no cell worse than `limit`.
    fn comes_out(&mut self, whole: &Nodes, limit: f64) -> bool {
        for _ in 0..ROUNDS {
            let poor = self.poor(limit);
            if poor.is_empty() {
                return true;
            }
            let moved = self.smooth(whole, &poor);
            if !self.swap(limit) && !moved {
                break;
            }
        }
        self.poor(limit).is_empty()
    }

    /// Smooths the nodes of `poor` cells, as their roles in the `whole` mesh allow; whether any moved.
    fn smooth(&mut self, whole: &Nodes, poor: &[u32]) -> bool {
        let incidence = Incidence::of(&self.mesh.cells, &vec![true; self.nodes.len()]);
        let (mesh, roles, pairs) = (&mut self.mesh, &self.roles, &PeriodicPairs::default());
        let mut nodes = Nodes { exact: whole.exact, mesh, incidence: &incidence, roles, pairs };
        nodes.of_cells(poor).into_iter().filter(|&node| smooth(&mut nodes, node, false)).count() > 0
    }

    /// Swaps cells worse than `limit` for better ones; whether there were any.
    fn swap(&mut self, limit: f64) -> bool {
        let (poor, all) = (self.poor(limit), self.mesh.numbers());
        let mut topology = Topology::new(&mut self.mesh, all);
        let swaps = poor.into_iter().filter(|&cell| topology.is_worse(cell, limit) && swapped(&mut topology, cell));
        let any = swaps.count() > 0;
        self.mesh.drop_removed();
        any
    }

    /// What makes the mesh like this one where it was like `before`.
    fn in_place_of(&self, before: &Self) -> Remeshed {
        let sorted = |of: &Self| {
            let mut cells = of.mesh.cells.clone();
            cells.sort_unstable();
            cells
        };
        let (then, now) = (sorted(before), sorted(self));
        let old = before.cells.iter().zip(&before.mesh.cells).filter(|(_, nodes)| now.binary_search(nodes).is_err());
        let all = self.mesh.cells.iter().zip(&self.mesh.owner);
        let new = all.filter(|(nodes, _)| then.binary_search(nodes).is_err());
        let moved = (0..self.nodes.len()).filter(|&node| self.mesh.points[node] != before.mesh.points[node]);
        Remeshed {
            positions: moved.map(|node| (self.nodes[node], self.mesh.points[node])).collect(),
            old: old.map(|(&cell, _)| cell).collect(),
            new: new.map(|(nodes, &owner)| (nodes.map(|node| self.nodes[node as usize]), owner)).collect(),
        }
    }
}
