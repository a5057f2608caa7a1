//! Tetrahedra whose connections change: what is around the nodes that take part is kept up to date.

use crate::math::Vec3;
use crate::mesh::lattice::{Tetrahedra, sharpness};

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
        sharpness(cell.map(|node| self.point(node)))
    }

    /// The sharpness of the sharpest of `cells`.
    pub(super) fn sharpest(&self, cells: &[u32]) -> f64 {
        cells.iter().map(|&cell| self.sharpness(self.cell(cell))).fold(-1.0, f64::max)
    }

    /// The shortest altitude of `cells`, mm.
    pub(super) fn shortest_altitude(&self, cells: impl Iterator<Item = [u32; 4]>) -> f64 {
        cells.map(|cell| altitude(cell.map(|node| self.point(node)))).fold(f64::INFINITY, f64::min)
    }

    /// Puts `new` cells in the place of `old` ones, all of one grain.
    pub(super) fn replace(&mut self, old: &[u32], new: &[[u32; 4]]) {
        let grain = self.grain(old[0]);
        old.iter().for_each(|&cell| self.unlink(cell));
        for (place, &nodes) in new.iter().enumerate() {
            let cell = old.get(place).copied().unwrap_or(self.mesh.cells.len() as u32);
            if place < old.len() {
                self.mesh.cells[cell as usize] = nodes;
            } else {
                self.mesh.cells.push(nodes);
                self.mesh.grain.push(grain);
            }
            self.link(cell);
        }
        old.iter().skip(new.len()).for_each(|&cell| self.mesh.cells[cell as usize] = GONE);
    }

    /// Takes out what is gone.
    pub(super) fn finish(self) {
        let mut cells = self.mesh.cells.iter();
        self.mesh.grain.retain(|_| cells.next() != Some(&GONE));
        self.mesh.cells.retain(|cell| *cell != GONE);
    }
}

/// Shortest altitude of a tetrahedron, mm: six times its volume over twice its largest face's area.
fn altitude([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let faces = [u.cross(&v), v.cross(&w), w.cross(&u), (v - u).cross(&(w - u))];
    u.cross(&v).dot(&w) / faces.map(|face| face.norm_squared()).into_iter().fold(0.0, f64::max).sqrt()
}
