//! Nodes that found no way back to their grain are merged with a neighbour on it.
//!
//! Where a grain comes to within a hair of the specimen's side, the nodes of its surface have no room between the two. One
//! that is merged with a neighbour leaves its edge's tetrahedra out, and the others fill their place: where they all keep a
//! positive volume the mesh stays one without gaps or overlaps, since the rim of both stars stays as it is.

use super::Tetrahedra;
use super::fit::Fit;
use super::roles::Role;
use super::star::{Star, Stars, sharpness_of};
use rayon::prelude::*;

/// A node that becomes one with another.
pub(super) struct Merge {
    node: u32,
    pub(super) into: u32,
    /// The tetrahedra that both have.
    between: Vec<u32>,
}

/// The neighbour on its grain that `node` is best merged with, if one leaves all angles above `least_deg`.
pub(super) fn merge(fit: &Fit, node: u32, least_deg: f64) -> Option<Merge> {
    let Role::Surface(grain) = fit.roles[node as usize] else { return None };
    let mut best = (sharpness_of(least_deg), None);
    for into in neighbours(fit, node).into_iter().filter(|&other| lies_on(fit, other, grain)) {
        let (between, rest) = parted(fit, node, into);
        let worst = star(fit, node, &rest).worst(&fit.places.get(into), best.0);
        if worst <= best.0 {
            best = (worst, Some(Merge { node, into, between }));
        }
    }
    best.1
}

/// The neighbours of `node` with which it may be merged, since they lie on its grain, the nearest first.
pub(super) fn partners(fit: &Fit, node: u32) -> Vec<u32> {
    let Role::Surface(grain) = fit.roles[node as usize] else { return Vec::new() };
    let away = |other: &u32| (fit.places.get(*other) - fit.places.get(node)).norm_squared();
    let mut near = neighbours(fit, node);
    near.retain(|&other| lies_on(fit, other, grain));
    near.sort_by(|a, b| away(a).total_cmp(&away(b)));
    near
}

/// Whether a node is one of the grain's surface, and lies on it.
fn lies_on(fit: &Fit, node: u32, grain: u32) -> bool {
    fit.roles[node as usize] == Role::Surface(grain) && fit.surfaces[grain as usize].has(&fit.places.get(node))
}

/// The cells of `node` that `other` has, too, and the rest.
fn parted(fit: &Fit, node: u32, other: u32) -> (Vec<u32>, Vec<u32>) {
    fit.stars.cells(node).iter().partition(|&&cell| fit.mesh.cells[cell as usize].contains(&other))
}

fn star(fit: &Fit, node: u32, cells: &[u32]) -> Star {
    Star::of_cells(node, cells.iter().map(|&cell| fit.cell(cell)), |node| fit.places.get(node))
}

/// The nodes that share a tetrahedron with `node`.
fn neighbours(fit: &Fit, node: u32) -> Vec<u32> {
    let mut near: Vec<u32> = fit.stars.cells(node).iter().flat_map(|&cell| fit.mesh.cells[cell as usize]).collect();
    near.sort_unstable();
    near.dedup();
    near.retain(|other| *other != node);
    near
}

/// What was merged.
#[derive(Default)]
pub(super) struct Merged {
    nodes: Vec<u32>,
    cells: Vec<u32>,
}

impl Merged {
    /// Carries a merge out; the node and the tetrahedra that are left over stay in the lists until [`leave_out`](Self::leave_out).
    pub(super) fn add(&mut self, merge: Merge, mesh: &mut Tetrahedra, stars: &mut Stars) {
        let Merge { node, into, between, .. } = merge;
        between.iter().for_each(|&cell| stars.leave_out(cell, &mesh.cells[cell as usize]));
        for &cell in stars.cells(node) {
            mesh.cells[cell as usize].iter_mut().filter(|of| **of == node).for_each(|of| *of = into);
        }
        stars.join(node, into);
        self.nodes.push(node);
        self.cells.extend(between);
    }

    /// These cells are no more, nor is the node.
    pub(super) fn take(&mut self, cells: &[u32], node: Option<u32>) {
        self.cells.extend(cells);
        self.nodes.extend(node);
    }

    /// Takes what is left over out of the mesh.
    pub(super) fn leave_out(mut self, mesh: &mut Tetrahedra) {
        self.nodes.sort_unstable();
        self.cells.sort_unstable();
        without(&mut mesh.cells, &self.cells);
        without(&mut mesh.grain, &self.cells);
        without(&mut mesh.points, &self.nodes);
        let lower = |node: u32| self.nodes.partition_point(|left_out| *left_out < node) as u32;
        mesh.cells.par_iter_mut().flatten().for_each(|node| *node -= lower(*node));
    }
}

/// Takes the entries with these numbers, ascending, out of the list.
fn without<T>(list: &mut Vec<T>, numbers: &[u32]) {
    let mut all = 0..;
    list.retain(|_| all.next().is_some_and(|number| numbers.binary_search(&number).is_err()));
}
