//! The end of the fit: angles are mended, and nodes that this let off their grain come back to it.
//!
//! In turns: nodes go back where angles allow ([`back`]); where that does not do, cells get another label ([`relabel`]),
//! nodes are merged with neighbours ([`merge`]), or at last other cells take the place of those around ([`recut`]).

use super::fit::{Fit, GUARD_DEG};
use super::merge::Merged;
use super::places::Places;
use super::recut::Recut;
use super::roles::Role;
use super::skin::Skin;
use super::star::Stars;
use super::surface::Surface;
use super::twins::Twins;
use super::{Tetrahedra, back, mend, merge, recut, relabel};

/// The smallest dihedral angle that merges may leave, degrees, turn by turn: first those that need nothing else, then those
/// after which the nodes around are to make room (of 329 nodes in the paper's specimen at 2 mm 17 are left then).
const MERGES: [f64; 3] = [GUARD_DEG, 3.0, 1.0];
/// The smallest dihedral angle that other cells may have, degrees: each where there are none with the one before.
const RECUTS: [f64; 3] = [GUARD_DEG, 9.0, 8.0];

/// A mesh whose rounds are done.
pub(super) struct Finish<'a> {
    pub(super) mesh: &'a mut Tetrahedra,
    pub(super) surfaces: &'a [Surface],
    pub(super) stars: &'a mut Stars,
    pub(super) places: &'a Places,
    pub(super) roles: &'a mut [Role],
    pub(super) twins: &'a Twins,
    /// Of the elements, mm.
    pub(super) size: f64,
    pub(super) skin: &'a Skin<'a>,
}

/// Finishes the mesh; returns how many nodes without images are still off, and what is to be left out.
pub(super) fn finish(of: Finish) -> (usize, Merged) {
    // Mending after merges would let nodes off the specimen's own surface where that is no box.
    let merges = if of.skin.outline.is_some() { &[] } else { MERGES.as_slice() };
    let (nodes, cells) = (0..of.roles.len() as u32, 0..of.mesh.cells.len() as u32);
    let mut work = Work { merged: Merged::default(), off: nodes.collect(), lost: 0, of };
    work.mend(cells.collect());
    for &least_deg in merges {
        let grown = work.merge(least_deg);
        work.mend(grown.into_iter().flat_map(|node| work.of.stars.cells(node)).copied().collect());
    }
    work.twins_back();
    RECUTS.into_iter().for_each(|least_deg| work.recut(least_deg));
    (work.off.len() + work.lost, work.merged)
}

struct Work<'a> {
    of: Finish<'a>,
    /// What is to be left out.
    merged: Merged,
    /// Nodes that lie off their grain.
    off: Vec<u32>,
    /// How many lie off the specimen's own surface.
    lost: usize,
}

impl Work<'_> {
    fn fit(&self) -> Fit<'_> {
        let Finish { mesh, surfaces, stars, places, roles, twins, size, skin } = &self.of;
        Fit { mesh, surfaces, stars, places, roles, twins, lacks: &[], size: *size, skin }
    }

    /// Mends angles, and brings nodes back onto their grain as far as these allow.
    fn mend(&mut self, suspects: Vec<u32>) {
        let released = mend::mend(&self.fit(), suspects);
        // No way leads back to the specimen's own surface.
        let was_outer = |node: &&u32| matches!(self.of.roles[**node as usize], Role::Skin(hold) if hold.outer);
        self.lost += released.iter().filter(was_outer).count();
        self.off.extend(released);
        let off = std::mem::take(&mut self.off);
        self.off = back::back(&self.fit(), off, GUARD_DEG);
    }

    /// Brings back what it can of nodes with images, which get no other cells: they would have to match on both faces.
    fn twins_back(&mut self) {
        let is_twin = |node: &u32| matches!(self.of.roles[*node as usize], Role::Twin(_));
        let (twins, others): (Vec<u32>, Vec<u32>) = self.off.iter().partition(|node| is_twin(node));
        self.off = others;
        RECUTS.into_iter().fold(twins, |off, least_deg| back::back(&self.fit(), off, least_deg));
    }

    /// Gives nodes that are off cells of other labels, or merges them with neighbours; returns those that got others' cells.
    fn merge(&mut self, least_deg: f64) -> Vec<u32> {
        let mut grown = Vec::new();
        for node in std::mem::take(&mut self.off) {
            if let Some(change) = relabel::relabelled(&self.fit(), node) {
                change.cells.iter().for_each(|&cell| self.of.mesh.grain[cell as usize] = change.label);
                change.roles.iter().for_each(|&(node, role)| self.of.roles[node as usize] = role);
            } else if let Some(merge) = merge::merge(&self.fit(), node, least_deg) {
                grown.push(merge.into);
                self.merged.add(merge, self.of.mesh, self.of.stars);
            } else {
                self.off.push(node);
            }
        }
        grown
    }

    /// Gives nodes that are off other cells.
    fn recut(&mut self, least_deg: f64) {
        for node in std::mem::take(&mut self.off) {
            match recut::recut(&self.fit(), node, least_deg) {
                Some(recut) => self.put(&recut),
                None => self.off.push(node),
            }
        }
    }

    fn put(&mut self, recut: &Recut) {
        let Finish { mesh, stars, places, .. } = &mut self.of;
        recut.places.iter().for_each(|(node, place)| places.set(*node, place));
        let gone: Vec<(u32, [u32; 4])> = recut.gone.iter().map(|&cell| (cell, mesh.cells[cell as usize])).collect();
        let numbers = mesh.cells.len() as u32..;
        let new: Vec<(u32, [u32; 4])> = numbers.zip(recut.new.iter().map(|(nodes, _)| *nodes)).collect();
        stars.exchange(&gone, &new);
        mesh.cells.extend(recut.new.iter().map(|(nodes, _)| nodes));
        mesh.grain.extend(recut.new.iter().map(|(_, grain)| grain));
        self.merged.take(&recut.gone, recut.merged);
    }
}
