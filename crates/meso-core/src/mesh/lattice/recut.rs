//! Nodes that found no place on their grain between the cells that they have get one between others.
//!
//! Where a grain's face runs along the specimen's side, so near that cells with good angles hardly fit between the two, the
//! node goes onto the grain, and the cells around it are swapped for others in the same room ([`swaps`](crate::mesh::swaps))
//! and its neighbours moved on their surfaces, in turns, until none is too sharp. Where no place comes out so, the node is made
//! one with a neighbour on the grain, to the same end: one layer of cells fits between grain and side where two do not.
//! All this is tried in a copy of what is around the node; that takes the place of the cells there if it comes out well.

use super::Tetrahedra;
use super::back;
use super::fit::Fit;
use super::mend;
use super::merge;
use super::places::Places;
use super::roles::Role;
use super::star::{Stars, sharpness, sharpness_of};
use super::twins::Twins;
use crate::math::Vec3;
use crate::mesh::swaps::swapped;
use crate::mesh::web::Web;
use crate::stop;

/// The nodes that move lie in so many rings less one around the node.
const RINGS: usize = 4;
/// Places on the grain that are tried, at most, and how far apart they lie, in elements. (With 3 rings and 24 places 3 of 17
/// nodes of the paper's specimen at 2 mm, and 1 of 17 of a cylinder, find no cells with angles above 10 degrees; with these
/// all do.)
const PLACES: usize = 48;
const APART: f64 = 0.05;
/// Rounds of moves and swaps at each place. More moves before each round's swaps find less.
const ROUNDS: usize = 30;

/// Other cells in the place of some.
pub(super) struct Recut {
    /// The nodes that move, with their places.
    pub(super) places: Vec<(u32, Vec3)>,
    /// Cells that are no more.
    pub(super) gone: Vec<u32>,
    /// Cells in their place, with the grain each lies in.
    pub(super) new: Vec<([u32; 4], u32)>,
    /// A node that is no more: it was made one with another.
    pub(super) merged: Option<u32>,
}

/// Cells with which `node` lies on its grain, or is one with a node on it, and that leave all angles above `least_deg`, or as
/// they were where one is smaller, if such are found.
pub(super) fn recut(fit: &Fit, node: u32, least_deg: f64) -> Option<Recut> {
    let patch = Patch::around(fit, node);
    let limit = patch.sharpest().max(sharpness_of(least_deg));
    let places = back::places_apart(fit, node, APART * fit.size, PLACES);
    let at_places = places.iter().map(|place| patch.with(node, place));
    let joined = merge::partners(fit, node).into_iter().map(|into| (patch.joined(node, into), Some(node)));
    at_places.map(|tried| (tried, None)).chain(joined).find_map(|(mut tried, merged)| {
        tried.comes_out(fit, limit).then(|| Recut { merged, ..tried.in_place_of(&patch) })
    })
}

/// A copy of what is around a node, with numbers of its own.
#[derive(Clone)]
struct Patch {
    /// The nodes by their numbers in the whole mesh, ascending.
    nodes: Vec<u32>,
    /// The cells' numbers in the whole mesh.
    cells: Vec<u32>,
    mesh: Tetrahedra,
    /// Nodes that have cells elsewhere are fixed.
    roles: Vec<Role>,
}

impl Patch {
    fn around(fit: &Fit, node: u32) -> Self {
        let (mut within, mut nodes, mut cells) = (Vec::new(), vec![node], Vec::new());
        for _ in 0..RINGS {
            within = nodes;
            cells = ascending(within.iter().flat_map(|&node| fit.stars.cells(node)).copied());
            nodes = ascending(cells.iter().flat_map(|&cell| fit.mesh.cells[cell as usize]));
        }
        let number = |node: u32| nodes.partition_point(|other| *other < node) as u32;
        let role = |node: &u32| {
            let moves = within.binary_search(node).is_ok() && !fit.stars.cells(*node).is_empty();
            match fit.roles[*node as usize] {
                // Their images are elsewhere.
                Role::Twin(_) => Role::Fixed,
                role if moves => role,
                _ => Role::Fixed,
            }
        };
        let mesh = Tetrahedra {
            points: nodes.iter().map(|&node| fit.places.get(node)).collect(),
            cells: cells.iter().map(|&cell| fit.mesh.cells[cell as usize].map(number)).collect(),
            grain: cells.iter().map(|&cell| fit.mesh.grain[cell as usize]).collect(),
        };
        Self { roles: nodes.iter().map(role).collect(), nodes, cells, mesh }
    }

    fn number(&self, node: u32) -> u32 {
        self.nodes.partition_point(|other| *other < node) as u32
    }

    /// With `node` at `place`.
    fn with(&self, node: u32, place: &Vec3) -> Self {
        let mut patch = self.clone();
        patch.mesh.points[self.number(node) as usize] = *place;
        patch
    }

    /// With `node` made one with `into`, which gets its cells but for those that both have. Others turn over as they may.
    fn joined(&self, node: u32, into: u32) -> Self {
        let mut patch = self.clone();
        let (node, into) = (self.number(node), self.number(into));
        let all = self.mesh.cells.iter().zip(&self.mesh.grain);
        let stay = all.filter(|(cell, _)| !(cell.contains(&node) && cell.contains(&into)));
        let renamed = |cell: &[u32; 4]| cell.map(|of| if of == node { into } else { of });
        (patch.mesh.cells, patch.mesh.grain) = stay.map(|(cell, grain)| (renamed(cell), *grain)).unzip();
        patch
    }

    fn sharpness(&self, cell: u32) -> f64 {
        stop::point();
        sharpness(self.mesh.cells[cell as usize].map(|node| self.mesh.points[node as usize]))
    }

    fn sharper(&self, limit: f64) -> Vec<u32> {
        (0..self.mesh.cells.len() as u32).filter(|&cell| self.sharpness(cell) > limit).collect()
    }

    fn sharpest(&self) -> f64 {
        (0..self.mesh.cells.len() as u32).map(|cell| self.sharpness(cell)).fold(-1.0, f64::max)
    }

    /// Whether moves and swaps leave no cell sharper than `limit`.
    fn comes_out(&mut self, whole: &Fit, limit: f64) -> bool {
        for _ in 0..ROUNDS {
            let sharp = self.sharper(limit);
            if sharp.is_empty() {
                return true;
            }
            let moved = self.move_nodes(whole, &sharp);
            if !self.swap(limit) && !moved {
                break;
            }
        }
        self.sharper(limit).is_empty()
    }

    /// Moves the nodes of `sharp` cells to better places, as their roles in the `whole` mesh allow; whether any moved.
    fn move_nodes(&mut self, whole: &Fit, sharp: &[u32]) -> bool {
        let places = Places::new(&self.mesh.points);
        let stars = Stars::new(&self.mesh.cells, &vec![true; self.nodes.len()]);
        let (roles, twins) = (&self.roles, &Twins::default());
        let fit = Fit { mesh: &self.mesh, stars: &stars, places: &places, roles, twins, ..*whole };
        let nodes = ascending(sharp.iter().flat_map(|&cell| self.mesh.cells[cell as usize]));
        let moved = nodes.into_iter().filter(|&node| mend::better(&fit, node, false)).count();
        self.mesh.points = places.into_points();
        moved > 0
    }

    /// Swaps cells sharper than `limit` for blunter ones; whether there were any.
    fn swap(&mut self, limit: f64) -> bool {
        let sharp = self.sharper(limit);
        let all: Vec<u32> = (0..self.mesh.cells.len() as u32).collect();
        let mut web = Web::new(&mut self.mesh, &all);
        let mut any = false;
        for cell in sharp {
            let is_sharp = !web.is_gone(cell) && web.sharpest(&[cell]) > limit;
            any |= is_sharp && swapped(&mut web, cell);
        }
        web.finish();
        any
    }

    /// What makes the mesh like this one where it was like `before`.
    fn in_place_of(&self, before: &Self) -> Recut {
        let sorted = |of: &Self| {
            let mut cells = of.mesh.cells.clone();
            cells.sort_unstable();
            cells
        };
        let (then, now) = (sorted(before), sorted(self));
        let gone = before.cells.iter().zip(&before.mesh.cells).filter(|(_, nodes)| now.binary_search(nodes).is_err());
        let all = self.mesh.cells.iter().zip(&self.mesh.grain);
        let new = all.filter(|(nodes, _)| then.binary_search(nodes).is_err());
        let moved = (0..self.nodes.len()).filter(|&node| self.mesh.points[node] != before.mesh.points[node]);
        Recut {
            places: moved.map(|node| (self.nodes[node], self.mesh.points[node])).collect(),
            gone: gone.map(|(&cell, _)| cell).collect(),
            new: new.map(|(nodes, &grain)| (nodes.map(|node| self.nodes[node as usize]), grain)).collect(),
            merged: None,
        }
    }
}

fn ascending(numbers: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut numbers: Vec<u32> = numbers.collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
}
