//! A mesh whose cells are replaced: what is around the nodes that take part is kept up to date.

use super::incidence::Incidence;
use super::quality::{min_dihedral_cos2, shortest_altitude};
use super::tetrahedra::TetMesh;
use crate::math::Vec3;
use rayon::prelude::*;

/// Stands for a node that is not there yet.
pub(in crate::mesh) const NEW: u32 = u32::MAX;

/// A proposal: `new` cells with their owners in place of `old` ones.
pub(in crate::mesh) struct Replacement {
    pub(in crate::mesh) old: Vec<u32>,
    pub(in crate::mesh) new: Vec<([u32; 4], u32)>,
}

/// A mesh, with the cells around some of its nodes.
pub(in crate::mesh) struct Topology<'a> {
    pub(in crate::mesh) mesh: &'a mut TetMesh,
    incidence: Incidence,
}

impl<'a> Topology<'a> {
    /// With the cells around the corners of `cells`.
    pub(in crate::mesh) fn new(mesh: &'a mut TetMesh, cells: impl Iterator<Item = u32>) -> Self {
        let corners = cells.flat_map(|cell| mesh.cell(cell));
        let incidence = Incidence::around(&mesh.cells, mesh.points.len(), corners);
        Self { incidence, mesh }
    }

    /// The cells around a node; none where they are not kept.
    pub(in crate::mesh) fn star(&self, node: u32) -> &[u32] {
        self.incidence.cells(node)
    }

    /// The cells that have all of `nodes`.
    pub(in crate::mesh) fn around(&self, nodes: &[u32]) -> Vec<u32> {
        let Some(first) = nodes.iter().find(|node| self.incidence.tracks(**node)) else { return Vec::new() };
        let has_all = |cell: &u32| nodes.iter().all(|node| self.cell(*cell).contains(node));
        self.star(*first).iter().copied().filter(has_all).collect()
    }

    pub(in crate::mesh) fn cell(&self, cell: u32) -> [u32; 4] {
        self.mesh.cell(cell)
    }

    pub(in crate::mesh) fn is_removed(&self, cell: u32) -> bool {
        self.mesh.is_removed(cell)
    }

    pub(in crate::mesh) fn owner(&self, cell: u32) -> u32 {
        self.mesh.owner[cell as usize]
    }

    pub(in crate::mesh) fn point(&self, node: u32) -> Vec3 {
        self.mesh.position(node)
    }

    pub(in crate::mesh) fn move_to(&mut self, node: u32, position: Vec3) {
        self.mesh.points[node as usize] = position;
    }

    pub(in crate::mesh) fn cos2(&self, nodes: [u32; 4]) -> f64 {
        min_dihedral_cos2(self.mesh.corners(nodes))
    }

    /// Whether a cell is there, and worse than `limit`.
    pub(in crate::mesh) fn is_worse(&self, cell: u32, limit: f64) -> bool {
        !self.is_removed(cell) && self.mesh.cos2(cell) > limit
    }

    /// The cells that are worse than `limit`, ascending.
    pub(in crate::mesh) fn worse(&self, limit: f64) -> Vec<u32> {
        self.mesh.numbers().into_par_iter().filter(|&cell| self.is_worse(cell, limit)).collect()
    }

    /// The [`min_dihedral_cos2`] of the worst of `cells`.
    pub(in crate::mesh) fn worst(&self, cells: &[u32]) -> f64 {
        cells.iter().map(|&cell| self.mesh.cos2(cell)).fold(-1.0, f64::max)
    }

    /// The shortest altitude of `cells`, mm.
    pub(in crate::mesh) fn shortest_altitude(&self, cells: impl Iterator<Item = [u32; 4]>) -> f64 {
        cells.map(|nodes| shortest_altitude(self.mesh.corners(nodes))).fold(f64::INFINITY, f64::min)
    }

    /// Replaces cells where that makes no altitude, and so no stable time step, shorter; whether it did.
    pub(in crate::mesh) fn replace_thicker(&mut self, proposed: &Replacement) -> bool {
        let Replacement { old, new } = proposed;
        let before = self.shortest_altitude(old.iter().map(|&cell| self.cell(cell)));
        let is_thicker = self.shortest_altitude(new.iter().map(|(nodes, _)| *nodes)) >= before;
        if is_thicker {
            self.replace(proposed);
        }
        is_thicker
    }

    /// New cells take the numbers of old ones as far as these go.
    fn replace(&mut self, Replacement { old, new }: &Replacement) {
        old.iter().for_each(|&cell| self.incidence.unlink(cell, &self.mesh.cell(cell)));
        for (i, &(nodes, owner)) in new.iter().enumerate() {
            let cell = match old.get(i) {
                Some(&cell) => {
                    (self.mesh.cells[cell as usize], self.mesh.owner[cell as usize]) = (nodes, owner);
                    cell
                }
                None => self.mesh.push(nodes, owner),
            };
            self.incidence.link(cell, &nodes);
        }
        old.iter().skip(new.len()).for_each(|&cell| self.mesh.remove(cell));
    }

    /// The same with a new node at `position` in place of [`NEW`].
    pub(in crate::mesh) fn insert_thicker(&mut self, position: Vec3, mut proposed: Replacement) -> bool {
        let node = self.mesh.points.len() as u32;
        self.mesh.points.push(position);
        self.incidence.add_node();
        let corners = proposed.new.iter_mut().flat_map(|(nodes, _)| nodes);
        corners.filter(|of| **of == NEW).for_each(|of| *of = node);
        let is_thicker = self.replace_thicker(&proposed);
        if !is_thicker {
            self.mesh.points.pop();
            self.incidence.forget_last_node();
        }
        is_thicker
    }
}
