//! Tetrahedra whose connections change: what is around the nodes that take part is kept up to date.

use crate::math::Vec3;
use crate::mesh::lattice::{Tetrahedra, sharpness};
use crate::mesh::quality::shortest_altitude;
use crate::stop;
use rayon::prelude::*;

/// A cell that is no more.
const GONE: [u32; 4] = [u32::MAX; 4];
/// A node without a list of its cells.
const NONE: u32 = u32::MAX;

/// A mesh, with the cells around some of its nodes.
pub(super) struct Web<'a> {
    mesh: &'a mut Tetrahedra,
    /// The place of a node's list, by node.
    list: Vec<u32>,
    stars: Vec<Vec<u32>>,
}

impl<'a> Web<'a> {
    /// With the cells around the corners of `cells`.
    pub(super) fn new(mesh: &'a mut Tetrahedra, cells: &[u32]) -> Self {
        let mut list = vec![NONE; mesh.points.len()];
        let mut lists = 0;
        for node in cells.iter().flat_map(|&cell| mesh.cells[cell as usize]) {
            if list[node as usize] == NONE {
                list[node as usize] = lists;
                lists += 1;
            }
        }
        let mut web = Self { stars: vec![Vec::new(); lists as usize], list, mesh };
        (0..web.mesh.cells.len() as u32).for_each(|cell| web.link(cell));
        web
    }

    fn link(&mut self, cell: u32) {
        for node in self.mesh.cells[cell as usize] {
            if let Some(star) = self.stars.get_mut(self.list[node as usize] as usize) {
                star.push(cell);
            }
        }
    }

    fn unlink(&mut self, cell: u32) {
        for node in self.mesh.cells[cell as usize] {
            if let Some(star) = self.stars.get_mut(self.list[node as usize] as usize) {
                star.retain(|other| *other != cell);
            }
        }
    }

    /// The cells around a node; none where they are not kept.
    pub(super) fn star(&self, node: u32) -> &[u32] {
        self.stars.get(self.list[node as usize] as usize).map_or(&[], Vec::as_slice)
    }

    /// The cells that have all of `nodes`.
    pub(super) fn around(&self, nodes: &[u32]) -> Vec<u32> {
        let Some(first) = nodes.iter().find(|node| self.list[**node as usize] != NONE) else { return Vec::new() };
        let has_all = |cell: &u32| nodes.iter().all(|node| self.cell(*cell).contains(node));
        self.star(*first).iter().copied().filter(has_all).collect()
    }

    pub(super) fn cell(&self, cell: u32) -> [u32; 4] {
        self.mesh.cells[cell as usize]
    }

    pub(super) fn is_gone(&self, cell: u32) -> bool {
        self.cell(cell) == GONE
    }

    pub(super) fn grain(&self, cell: u32) -> u32 {
        self.mesh.grain[cell as usize]
    }

    pub(super) fn point(&self, node: u32) -> Vec3 {
        self.mesh.points[node as usize]
    }

    pub(super) fn go(&mut self, node: u32, place: Vec3) {
        self.mesh.points[node as usize] = place;
    }

    pub(super) fn sharpness(&self, cell: [u32; 4]) -> f64 {
        stop::point();
        sharpness(cell.map(|node| self.point(node)))
    }

    /// The cells that are sharper than `limit`, ascending.
    pub(super) fn sharper(&self, limit: f64) -> Vec<u32> {
        let is_sharper = |&cell: &u32| !self.is_gone(cell) && self.sharpness(self.cell(cell)) > limit;
        (0..self.mesh.cells.len() as u32).into_par_iter().filter(is_sharper).collect()
    }

    /// The sharpness of the sharpest of `cells`.
    pub(super) fn sharpest(&self, cells: &[u32]) -> f64 {
        cells.iter().map(|&cell| self.sharpness(self.cell(cell))).fold(-1.0, f64::max)
    }

    /// The shortest altitude of `cells`, mm.
    pub(super) fn shortest_altitude(&self, cells: impl Iterator<Item = [u32; 4]>) -> f64 {
        cells.map(|cell| shortest_altitude(cell.map(|node| self.point(node)))).fold(f64::INFINITY, f64::min)
    }

    /// Puts `new` cells with their grains in the place of `old` ones.
    fn replace(&mut self, old: &[u32], new: &[([u32; 4], u32)]) {
        old.iter().for_each(|&cell| self.unlink(cell));
        for (place, &(nodes, grain)) in new.iter().enumerate() {
            let cell = old.get(place).copied().unwrap_or(self.mesh.cells.len() as u32);
            if place < old.len() {
                (self.mesh.cells[cell as usize], self.mesh.grain[cell as usize]) = (nodes, grain);
            } else {
                self.mesh.cells.push(nodes);
                self.mesh.grain.push(grain);
            }
            self.link(cell);
        }
        old.iter().skip(new.len()).for_each(|&cell| self.mesh.cells[cell as usize] = GONE);
    }

    /// The same where that makes no altitude, and so no stable time step, shorter; whether it did.
    pub(super) fn replace_thicker(&mut self, old: &[u32], new: &[([u32; 4], u32)]) -> bool {
        let before = self.shortest_altitude(old.iter().map(|&cell| self.cell(cell)));
        let thicker = self.shortest_altitude(new.iter().map(|(cell, _)| *cell)) >= before;
        if thicker {
            self.replace(old, new);
        }
        thicker
    }

    /// Adds a node without cells.
    pub(super) fn add(&mut self, place: Vec3) -> u32 {
        self.mesh.points.push(place);
        self.list.push(self.stars.len() as u32);
        self.stars.push(Vec::new());
        self.list.len() as u32 - 1
    }

    /// Takes the node that was added last, and has no cells, out again.
    pub(super) fn take_back(&mut self, node: u32) {
        self.mesh.points.truncate(node as usize);
        self.list.truncate(node as usize);
        self.stars.pop();
    }

    /// Takes out what is gone, and the nodes that no cell has any more.
    pub(super) fn finish(self) {
        let mut cells = self.mesh.cells.iter();
        self.mesh.grain.retain(|_| cells.next() != Some(&GONE));
        self.mesh.cells.retain(|cell| *cell != GONE);
        let is_lone = |node: usize| self.stars.get(self.list[node] as usize).is_some_and(Vec::is_empty);
        let mut number = vec![0; self.mesh.points.len()];
        let mut kept = 0;
        for (node, own) in number.iter_mut().enumerate() {
            *own = kept as u32;
            if !is_lone(node) {
                self.mesh.points[kept] = self.mesh.points[node];
                kept += 1;
            }
        }
        self.mesh.points.truncate(kept);
        self.mesh.cells.iter_mut().flatten().for_each(|node| *node = number[*node as usize]);
    }
}
