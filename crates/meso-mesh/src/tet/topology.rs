//! A mesh whose cells are replaced, with the cells around every node that takes part.

use super::tetrahedra::TetMesh;
use super::tetrahedra::{min_dihedral_cos2, shortest_altitude};
use meso_collision::math::Vec3;
use meso_concrete::parallel;

/// Stands for a node that is not there yet.
pub(crate) const NEW: u32 = u32::MAX;

/// A proposal: `new` cells with their owners in place of `old` ones.
pub(crate) struct Replacement {
    pub(crate) old: Vec<u32>,
    pub(crate) new: Vec<([u32; 4], u32)>,
}

/// A mesh, with the cells around some of its nodes.
pub(crate) struct Topology<'a> {
    pub(crate) mesh: &'a mut TetMesh,
    incidence: Incidence,
}

impl<'a> Topology<'a> {
    /// With the cells around the corners of `cells`.
    pub(crate) fn new(mesh: &'a mut TetMesh, cells: impl Iterator<Item = u32>) -> Self {
        let corners = cells.flat_map(|cell| mesh.cell(cell));
        let incidence = Incidence::around(&mesh.cells, mesh.points.len(), corners);
        Self { incidence, mesh }
    }

    /// The cells around a node; none where they are not kept.
    pub(crate) fn star(&self, node: u32) -> &[u32] {
        self.incidence.cells(node)
    }

    /// The cells that have all of `nodes`.
    pub(crate) fn around(&self, nodes: &[u32]) -> Vec<u32> {
        let Some(first) = nodes.iter().find(|node| self.incidence.tracks(**node)) else { return Vec::new() };
        let has_all = |cell: &u32| nodes.iter().all(|node| self.cell(*cell).contains(node));
        self.star(*first).iter().copied().filter(has_all).collect()
    }

    pub(crate) fn cell(&self, cell: u32) -> [u32; 4] {
        self.mesh.cell(cell)
    }

    pub(crate) fn is_removed(&self, cell: u32) -> bool {
        self.mesh.is_removed(cell)
    }

    pub(crate) fn owner(&self, cell: u32) -> u32 {
        self.mesh.owner[cell as usize]
    }

    pub(crate) fn point(&self, node: u32) -> Vec3 {
        self.mesh.position(node)
    }

    pub(crate) fn move_to(&mut self, node: u32, position: Vec3) {
        self.mesh.points[node as usize] = position;
    }

    pub(crate) fn cos2(&self, nodes: [u32; 4]) -> f64 {
        min_dihedral_cos2(self.mesh.corners(nodes))
    }

    /// Whether a cell is there, and worse than `limit`.
    pub(crate) fn is_worse(&self, cell: u32, limit: f64) -> bool {
        !self.is_removed(cell) && self.mesh.cos2(cell) > limit
    }

    /// The cells that are worse than `limit`, ascending.
    pub(crate) fn worse(&self, limit: f64) -> Vec<u32> {
        parallel::filter(self.mesh.cells.len(), |cell| self.is_worse(cell as u32, limit))
    }

    /// The [`min_dihedral_cos2`] of the worst of `cells`.
    pub(crate) fn worst(&self, cells: &[u32]) -> f64 {
        self.mesh.worst(cells.iter().copied())
    }

    /// The shortest altitude of `cells`, mm.
    pub(crate) fn shortest_altitude(&self, cells: impl Iterator<Item = [u32; 4]>) -> f64 {
        cells.map(|nodes| shortest_altitude(self.mesh.corners(nodes))).fold(f64::INFINITY, f64::min)
    }

    /// Replaces cells where that makes no altitude, and so no stable time step, shorter; whether it did.
    pub(crate) fn replace_thicker(&mut self, proposed: &Replacement) -> bool {
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

    /// The proposal with a new node at `position` in place of [`NEW`].
    pub(crate) fn insert_thicker(&mut self, position: Vec3, mut proposed: Replacement) -> bool {
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

/// The list of a node that is not tracked.
const UNTRACKED: u32 = u32::MAX;
/// Least capacity of a list that had to move.
const LEAST: u32 = 8;

/// For every tracked node the cells around it, in the order in which they came.
pub(crate) struct Incidence {
    /// Where a node's list begins in `cells`, or [`UNTRACKED`].
    start: Vec<u32>,
    length: Vec<u32>,
    capacity: Vec<u32>,
    cells: Vec<u32>,
}

impl Incidence {
    /// The cells around the nodes that `wanted` marks.
    pub(crate) fn of(mesh: &[[u32; 4]], wanted: &[bool]) -> Self {
        let tracked = |node: u32| wanted.get(node as usize) == Some(&true);
        let mut length = vec![0_u32; wanted.len()];
        let corners = || mesh.iter().flatten().copied().filter(|&node| tracked(node));
        corners().for_each(|node| length[node as usize] += 1);
        let mut end = 0;
        let mut begin = |(length, wanted): (&u32, &bool)| {
            end += length;
            if *wanted { end - length } else { UNTRACKED }
        };
        let start: Vec<u32> = length.iter().zip(wanted).map(&mut begin).collect();
        let capacity = length.clone();
        length.fill(0);
        let mut cells = vec![0; end as usize];
        for (number, cell) in (0..).zip(mesh) {
            for &node in cell.iter().filter(|&&node| tracked(node)) {
                cells[(start[node as usize] + length[node as usize]) as usize] = number;
                length[node as usize] += 1;
            }
        }
        Self { start, length, capacity, cells }
    }

    /// The cells around `nodes`.
    pub(crate) fn around(mesh: &[[u32; 4]], count: usize, nodes: impl Iterator<Item = u32>) -> Self {
        let mut wanted = vec![false; count];
        nodes.for_each(|node| wanted[node as usize] = true);
        Self::of(mesh, &wanted)
    }

    pub(crate) fn tracks(&self, node: u32) -> bool {
        self.start[node as usize] != UNTRACKED
    }

    /// The cells around a node; none where it is not tracked.
    pub(crate) fn cells(&self, node: u32) -> &[u32] {
        if !self.tracks(node) {
            return &[];
        }
        let (start, length) = (self.start[node as usize] as usize, self.length[node as usize] as usize);
        &self.cells[start..start + length]
    }

    /// Adds a cell to the lists of its nodes.
    pub(crate) fn link(&mut self, cell: u32, nodes: &[u32]) {
        for &node in nodes {
            if self.tracks(node) {
                self.push(node, cell);
            }
        }
    }

    /// Takes a cell out of the lists of its nodes.
    pub(crate) fn unlink(&mut self, cell: u32, nodes: &[u32]) {
        for &node in nodes {
            let start = self.start[node as usize] as usize;
            if let Some(at) = self.cells(node).iter().position(|other| *other == cell) {
                let end = start + self.length[node as usize] as usize;
                self.cells.copy_within(start + at + 1..end, start + at);
                self.length[node as usize] -= 1;
            }
        }
    }

    /// Gives the cells of `node` to `into`, before its own, and leaves it nothing.
    pub(crate) fn join(&mut self, node: u32, into: u32) {
        let all = [self.cells(node), self.cells(into)].concat();
        self.length[node as usize] = 0;
        self.length[into as usize] = 0;
        all.into_iter().for_each(|cell| self.push(into, cell));
    }

    /// Tracks one node more, without cells.
    pub(crate) fn add_node(&mut self) {
        self.start.push(self.cells.len() as u32);
        self.length.push(0);
        self.capacity.push(0);
    }

    /// Forgets the node that was added last.
    pub(crate) fn forget_last_node(&mut self) {
        self.start.pop();
        self.length.pop();
        self.capacity.pop();
    }

    fn push(&mut self, node: u32, cell: u32) {
        let at = node as usize;
        if self.length[at] == self.capacity[at] {
            self.make_room(at);
        }
        self.cells[(self.start[at] + self.length[at]) as usize] = cell;
        self.length[at] += 1;
    }

    /// Moves a list to the end of all, with twice its length to grow.
    fn make_room(&mut self, at: usize) {
        let (start, length) = (self.start[at] as usize, self.length[at] as usize);
        self.start[at] = self.cells.len() as u32;
        self.capacity[at] = (2 * length as u32).max(LEAST);
        self.cells.extend_from_within(start..start + length);
        self.cells.resize(self.start[at] as usize + self.capacity[at] as usize, 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_that_give_way_leave_the_lists_of_their_nodes_and_others_come_in() {
        // An edge from 3 to 4 in the place of the triangle of 0, 1 and 2; node 2 is not tracked.
        let (old, new) = ([[0, 1, 2, 3], [0, 2, 1, 4]], [[0, 1, 4, 3], [1, 2, 4, 3], [2, 0, 4, 3]]);
        let mut incidence = Incidence::of(&old, &[true, true, false, true, true]);
        (0..).zip(&old).for_each(|(cell, nodes)| incidence.unlink(cell, nodes));
        (2..).zip(&new).for_each(|(cell, nodes)| incidence.link(cell, nodes));
        assert_eq!(
            [0, 1, 2, 3, 4].map(|node| incidence.cells(node).to_vec()),
            [vec![2, 4], vec![2, 3], vec![], vec![2, 3, 4], vec![2, 3, 4]]
        );
        incidence.join(0, 1);
        assert_eq!([0, 1].map(|node| incidence.cells(node).to_vec()), [vec![], vec![2, 4, 2, 3]]);
    }
}
