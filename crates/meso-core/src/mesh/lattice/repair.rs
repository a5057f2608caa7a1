//! The end of the fit: small angles are enlarged, and nodes that this let off their body come back to it.
//!
//! 1. Nodes of cells below the guard are smoothed; where that does not help they are let off their surfaces: angles come first.
//! 2. Nodes that are off are projected back where angles allow it ([`reprojection`](super::reprojection)).
//! 3. Cells around those that still are get another label, or the node is contracted onto a neighbour on its body.
//! 4. At last the cells around it are remeshed ([`remeshing`](super::remeshing)).

use super::nodes::{Exact, Nodes, PeriodicPairs, Role};
use super::remeshing::{Remeshed, contraction, remeshed};
use super::reprojection::{Relabelled, relabelled, reproject};
use super::smoothing::{GUARD_DEG, smooth};
use crate::mesh::tet::{Improver, Incidence, TetMesh, ascending, cos2_of, improve};
use crate::stop;

/// The smallest dihedral angle that contractions may leave, degrees, pass by pass: first those that need nothing else, then those
/// after which smoothing makes room (of 329 nodes in the paper's specimen at 2 mm 17 are left then).
const CONTRACTIONS: [f64; 3] = [GUARD_DEG, 3.0, 1.0];
/// The smallest dihedral angle that remeshed cells may have, degrees: each where there are none with the one before.
const REMESHINGS: [f64; 3] = [GUARD_DEG, 9.0, 8.0];
/// Rounds of smoothing with the nodes on their surfaces, then off them.
const ROUNDS: usize = 12;

/// Repairs a mesh whose sweeps are done; returns how many nodes without images are still off.
pub(super) fn repair(
    exact: &Exact,
    mesh: &mut TetMesh,
    incidence: Incidence,
    roles: Vec<Role>,
    pairs: &PeriodicPairs,
) -> usize {
    // Smoothing after contractions would let nodes off the specimen's own surface where that is no box.
    let contractions = if exact.boundary.surface.is_some() { &[] } else { CONTRACTIONS.as_slice() };
    let (nodes, cells) = ((0..roles.len() as u32).collect(), mesh.numbers().collect());
    let mut work = Repair { exact, mesh, incidence, roles, pairs, off: nodes, lost: 0 };
    work.enlarge_angles(cells);
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

    /// Brings back what it can of nodes with images, whose cells stay: others would have to match on both faces.
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
