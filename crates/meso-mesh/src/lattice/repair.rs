//! The end of the fit: small angles are enlarged, and nodes that this let off their body come back to it.
//!
//! 1. Nodes of cells below the guard are smoothed; where that does not help they are let off their surfaces: angles come first.
//! 2. Nodes that are off are projected back where angles allow it ([`reprojection`](super::reprojection)).
//! 3. Cells around those that still are get another label, or the node is contracted onto a neighbour on its body.
//! 4. At last the cells around it are remeshed: other cells, or one node less.
//!
//! A body's face may run so close along the specimen's side that cells with good angles hardly fit between the two. So
//!
//! 1. the node moves onto the body. Swaps of the cells around it ([`swapped`]) and smoothing of its neighbours on their
//!    surfaces alternate until no angle is too small.
//! 2. Where that fails, the node is contracted onto a neighbour on the body and the same follows: one layer of cells fits
//!    between body and side where two do not.
//!
//! All of it happens in a copy of the cells around the node, which replaces them if no angle is too small.

use super::nodes::{Exact, Nodes, PeriodicPairs, Role};
use super::reprojection::{Relabelled, positions_apart, relabelled, reproject};
use super::smoothing::{GUARD_DEG, smooth};
use crate::tet::{Improver, Incidence, Star, TetMesh, Topology, ascending, cos2_of, improve, swapped};
use meso_collision::math::Vec3;
use meso_concrete::{parallel, stop};

/// The smallest dihedral angle that contractions may leave, degrees, pass by pass: first those that need nothing else, then those
/// after which smoothing makes room (of 329 nodes in the paper's specimen at 2 mm 17 are left then).
const CONTRACTIONS: [f64; 3] = [GUARD_DEG, 3.0, 1.0];
/// The smallest dihedral angle that remeshed cells may have, degrees: each where there are none with the one before.
const REMESHINGS: [f64; 3] = [GUARD_DEG, 9.0, LAST_DEG];
const LAST_DEG: f64 = 8.0;
/// Rounds of smoothing with the nodes on their surfaces, then off them.
const ROUNDS: usize = 12;

/// Repairs a mesh whose sweeps are done, and left all cells but the `suspects` above the guard; returns how many nodes without
/// images are still off.
pub(super) fn repair(
    exact: &Exact,
    mesh: &mut TetMesh,
    suspects: Vec<u32>,
    incidence: Incidence,
    roles: Vec<Role>,
    pairs: &PeriodicPairs,
) -> usize {
    // Smoothing after contractions would let nodes off the specimen's own surface where that is no box.
    let contractions = if exact.boundary.surface.is_some() { &[] } else { CONTRACTIONS.as_slice() };
    let nodes = (0..roles.len() as u32).collect();
    let mut work = Repair { exact, mesh, incidence, roles, pairs, off: nodes, lost: 0 };
    work.enlarge_angles(suspects);
    for &least_deg in contractions {
        let grown = work.relabel_or_contract(least_deg);
        work.enlarge_angles(grown.into_iter().flat_map(|node| work.incidence.cells(node)).copied().collect());
    }
    work.reproject_paired();
    REMESHINGS.into_iter().for_each(|least_deg| work.remesh(least_deg));
    let off = work.off.len() + work.lost;
    mesh.drop_removed();
    mesh.drop_lone_nodes();
    off
}

/// A mesh under repair.
struct Repair<'a> {
    exact: &'a Exact<'a>,
    mesh: &'a mut TetMesh,
    incidence: Incidence,
    roles: Vec<Role>,
    pairs: &'a PeriodicPairs,
    /// Nodes that lie off their body.
    off: Vec<u32>,
    /// How many lie off the specimen's own surface.
    lost: usize,
}

impl Repair<'_> {
    fn nodes(&mut self) -> Nodes<'_> {
        let Self { exact, mesh, incidence, roles, pairs, .. } = self;
        Nodes { exact, mesh, incidence, roles, pairs }
    }

    /// Enlarges the angles of `suspects` and of the cells around, and brings nodes back onto their body as far as these allow.
    fn enlarge_angles(&mut self, suspects: Vec<u32>) {
        let released = enlarge_angles(self.nodes(), suspects);
        // No way leads back to the specimen's own surface.
        let was_outer = |node: &&u32| matches!(self.roles[**node as usize], Role::Boundary(hold) if hold.outer);
        self.lost += released.iter().filter(was_outer).count();
        self.off.extend(released);
        let off = std::mem::take(&mut self.off);
        self.off = reproject(&mut self.nodes(), off, GUARD_DEG);
    }

    /// Brings back nodes with images where it can, whose cells stay: others would have to match on both faces.
    fn reproject_paired(&mut self) {
        let is_paired = |node: &u32| matches!(self.roles[*node as usize], Role::Paired(_));
        let (paired, others): (Vec<u32>, Vec<u32>) = self.off.iter().partition(|node| is_paired(node));
        self.off = others;
        REMESHINGS.into_iter().fold(paired, |off, least_deg| reproject(&mut self.nodes(), off, least_deg));
    }

    /// Gives the cells of nodes that are off other labels, or contracts the nodes; returns the nodes that got others' cells.
    fn relabel_or_contract(&mut self, least_deg: f64) -> Vec<u32> {
        let mut grown = Vec::new();
        for node in std::mem::take(&mut self.off) {
            stop::point();
            let nodes = self.nodes();
            if let Some(change) = relabelled(&nodes, node) {
                self.relabel(&change);
            } else if let Some(into) = contraction(&nodes, node, least_deg) {
                self.contract(node, into);
                grown.push(into);
            } else {
                self.off.push(node);
            }
        }
        grown
    }

    fn relabel(&mut self, change: &Relabelled) {
        change.cells.iter().for_each(|&cell| self.mesh.owner[cell as usize] = change.owner);
        change.roles.iter().for_each(|&(node, role)| self.roles[node as usize] = role);
    }

    fn contract(&mut self, node: u32, into: u32) {
        let around = self.incidence.cells(node).to_vec();
        for &cell in &around {
            let nodes = self.mesh.cell(cell);
            if nodes.contains(&into) {
                self.incidence.unlink(cell, &nodes);
            }
        }
        self.mesh.contract(node, into, &around);
        self.incidence.join(node, into);
    }

    /// Gives nodes that are off other cells.
    fn remesh(&mut self, least_deg: f64) {
        for node in std::mem::take(&mut self.off) {
            stop::point();
            match remeshed(&self.nodes(), node, least_deg) {
                Some(remeshed) => self.replace(&remeshed),
                None => self.off.push(node),
            }
        }
    }

    fn replace(&mut self, Remeshed { positions, old, new }: &Remeshed) {
        positions.iter().for_each(|(node, position)| self.mesh.points[*node as usize] = *position);
        for &cell in old {
            self.incidence.unlink(cell, &self.mesh.cell(cell));
            self.mesh.remove(cell);
        }
        for &(nodes, owner) in new {
            let cell = self.mesh.push(nodes, owner);
            self.incidence.link(cell, &nodes);
        }
    }
}

/// Smooths the nodes of those `suspects`, and of the cells around, that are below the guard; returns the nodes that were let off
/// their surfaces for it.
fn enlarge_angles(nodes: Nodes, suspects: Vec<u32>) -> Vec<u32> {
    let mut smoothing = Smoothing { nodes, limit: cos2_of(GUARD_DEG), round: 0, released: Vec::new() };
    improve(&mut smoothing, suspects, 2 * ROUNDS);
    ascending(smoothing.released)
}

struct Smoothing<'a> {
    nodes: Nodes<'a>,
    limit: f64,
    round: usize,
    released: Vec<u32>,
}

impl Improver for Smoothing<'_> {
    fn is_poor(&self, cell: u32) -> bool {
        stop::point();
        self.nodes.mesh.cos2(cell) > self.limit
    }

    fn round(&mut self, poor: &[u32]) -> Vec<u32> {
        let off = self.round >= ROUNDS;
        self.round += 1;
        let nodes = self.nodes.of_cells(poor);
        for &node in &nodes {
            if smooth(&mut self.nodes, node, off) && off && self.nodes.role(node) != Role::Free {
                self.released.push(node);
            }
        }
        nodes.iter().flat_map(|&node| self.nodes.cells_around(node)).collect()
    }
}

/// The nodes that move lie in so many rings less one around the node.
const RINGS: usize = 4;
/// Positions on the body that are tried, at most, and how far apart they lie, in elements. (With 3 rings and 24 positions 3 of 17
/// nodes of the paper's specimen at 2 mm, and 1 of 17 of a cylinder, find no cells with angles above 10 degrees; with these
/// all do.)
const POSITIONS: usize = 48;
const APART: f64 = 0.05;
/// Rounds of moves and swaps at each position. More moves before each round's swaps find less.
const PATCH_ROUNDS: usize = 30;
/// Rounds after which more poor cells than rounds left end an attempt, but at [`LAST_DEG`] (spheres at 0.7 mm: 27 to 15 s).
const HOPEFUL: usize = 5;

/// Other cells in the place of some.
struct Remeshed {
    /// The nodes that move, with their new positions.
    positions: Vec<(u32, Vec3)>,
    /// Cells that are removed.
    old: Vec<u32>,
    /// Cells in their place, with their owners.
    new: Vec<([u32; 4], u32)>,
}

/// Cells with which `node` lies on its body, or is one with a node on it, and that leave all angles above `least_deg`, or as
/// they were where one is smaller, if such are found.
fn remeshed(nodes: &Nodes, node: u32, least_deg: f64) -> Option<Remeshed> {
    let patch = NodePatch::around(nodes, node);
    let limit = patch.mesh.worst(patch.mesh.numbers()).max(cos2_of(least_deg));
    let positions = positions_apart(nodes, node, APART * nodes.exact.size, POSITIONS);
    let others = nearest_on_body(nodes, node);
    let start = |number: usize| match positions.get(number) {
        Some(position) => patch.with(node, position),
        None => patch.contracted(node, others[number - positions.len()]),
    };
    let attempt = |number: usize| {
        let mut tried = start(number);
        tried.comes_out(nodes, limit).then(|| tried.in_place_of(&patch))
    };
    let (mut tried, all) = (0, positions.len() + others.len());
    while tried < all {
        // Few at first: most nodes come out soon, and work beyond the first that does is lost.
        let more = (3 * tried).clamp(1, all - tried);
        if let found @ Some(_) = parallel::find(more, |number| attempt(tried + number)) {
            return found;
        }
        tried += more;
    }
    None
}

/// The neighbour on its body that `node` is best contracted onto, if one leaves all angles above `least_deg`.
///
/// The others of its cells fill the place of those that both have: where they all keep a positive volume the mesh stays one
/// without gaps or overlaps, since the rim of both stars stays as it is.
fn contraction(nodes: &Nodes, node: u32, least_deg: f64) -> Option<u32> {
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

/// The candidate nodes, the nearest first.
fn nearest_on_body(nodes: &Nodes, node: u32) -> Vec<u32> {
    let away = |other: &u32| (nodes.position(*other) - nodes.position(node)).norm_squared();
    let mut near = neighbours_on_body(nodes, node);
    near.sort_by(|a, b| away(a).total_cmp(&away(b)));
    near
}

/// A copy of the cells around a node, with numbers of its own.
#[derive(Clone)]
struct NodePatch {
    /// The nodes by their numbers in the whole mesh, ascending.
    nodes: Vec<u32>,
    /// The cells' numbers in the whole mesh.
    cells: Vec<u32>,
    mesh: TetMesh,
    /// Nodes that have cells elsewhere are fixed.
    roles: Vec<Role>,
}

impl NodePatch {
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

    /// Whether smoothing and swaps leave no cell worse than `limit`.
    fn comes_out(&mut self, whole: &Nodes, limit: f64) -> bool {
        for round in 0..PATCH_ROUNDS {
            let poor = self.poor(limit);
            if poor.is_empty() {
                return true;
            }
            let is_hopeless = round >= HOPEFUL && poor.len() > PATCH_ROUNDS - round;
            if is_hopeless && limit < cos2_of(LAST_DEG) {
                return false;
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

    /// The changes that lead from `before` to this patch.
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
