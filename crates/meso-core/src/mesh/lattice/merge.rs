//! Nodes that found no way back to their grain are merged with a neighbour on it.
//!
//! Where a grain comes to within a hair of the specimen's side, the nodes of its surface have no room between the two. One
//! that is merged with a neighbour leaves its edge's tetrahedra out, and the others fill their place: where they all keep a
//! positive volume the mesh stays one without gaps or overlaps, since the rim of both stars stays as it is.
//!
//! Where no neighbour on the grain will do, the node is merged into one of the side, which closes the gap between the two
//! as those between grains are closed: at one node, and counted ([`joined`](crate::mesh::joined)).

use super::Tetrahedra;
use super::fit::Fit;
use super::roles::Role;
use super::skin::Hold;
use super::star::{Star, Stars, sharpness_of};
use crate::math::Vec3;
use rayon::prelude::*;

/// The widest gap between a grain's edge or corner and the specimen's side that merges close, in elements.
const HAIR: f64 = 0.1;

/// A node that becomes one with another.
pub(super) struct Merge {
    node: u32,
    pub(super) into: u32,
    /// The grain that the node belongs on.
    pub(super) grain: u32,
    /// Where both are then.
    pub(super) place: Vec3,
    /// The tetrahedra that both have.
    between: Vec<u32>,
}

/// The neighbour on its grain, or on the side where the grain is joined with that, that `node` is best merged with, if one
/// leaves all angles above `least_deg`.
pub(super) fn merge(fit: &Fit, node: u32, least_deg: f64) -> Option<Merge> {
    let Role::Surface(grain) = fit.roles[node as usize] else { return None };
    let surface = &fit.surfaces[grain as usize];
    let on_grain = |other: &u32| match fit.roles[*other as usize] {
        Role::Surface(same) => same == grain && surface.has(&fit.places.get(*other)),
        role => role == Role::Joined(grain),
    };
    let all = neighbours(fit, node).into_iter().filter(on_grain);
    best(fit, node, grain, all.map(|into| (into, fit.places.get(into))), least_deg)
}

/// The node of a flat side that `node` is best merged with, where its grain comes to within a hair of that side, if one
/// leaves all angles above `least_deg`: the gap between the two is closed there. Places where they nearly touch come first.
pub(super) fn merge_into_side(fit: &Fit, node: u32, least_deg: f64) -> Option<Merge> {
    let Role::Surface(grain) = fit.roles[node as usize] else { return None };
    let (mut near, mut own) = (Vec::new(), Vec::new());
    for into in neighbours(fit, node) {
        let Role::Skin(Hold { axes, outer: false }) = fit.roles[into as usize] else { continue };
        let places = touching(fit, into, grain, axes);
        if !places.is_empty() {
            own.push((into, fit.places.get(into)));
        }
        near.extend(places.into_iter().map(|place| (into, place)));
    }
    let best = |all: Vec<(u32, Vec3)>| best(fit, node, grain, all.into_iter(), least_deg);
    best(near).or_else(|| best(own))
}

/// The places around `node`, on the flat sides across `axes`, that the grain's corners and edges come to within a hair of;
/// the nearest of these to the grain first.
pub(super) fn touching(fit: &Fit, node: u32, grain: u32, axes: [bool; 3]) -> Vec<Vec3> {
    let x = fit.places.get(node);
    let mut places = Vec::new();
    fit.surfaces[grain as usize].features_near(&x, fit.size, |feature| {
        let place = Vec3::from_fn(|axis, _| if axes[axis] { x[axis] } else { feature[axis] });
        places.push(((place - feature).norm(), place));
    });
    places.retain(|(gap, _)| *gap < HAIR * fit.size);
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    places.into_iter().map(|(_, place)| place).collect()
}

/// The best of the merges of `node` with others at a place.
fn best(fit: &Fit, node: u32, grain: u32, all: impl Iterator<Item = (u32, Vec3)>, least_deg: f64) -> Option<Merge> {
    let mut best = (sharpness_of(least_deg), None);
    for (into, place) in all {
        let (between, rest) = parted(fit, node, into);
        let mut worst = star(fit, node, &rest).worst(&place, best.0);
        if place != fit.places.get(into) {
            worst = worst.max(star(fit, into, &parted(fit, into, node).1).worst(&place, best.0));
        }
        if worst <= best.0 {
            best = (worst, Some(Merge { node, into, grain, place, between }));
        }
    }
    best.1
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
