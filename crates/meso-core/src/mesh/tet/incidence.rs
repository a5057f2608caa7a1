//! The cells around the nodes.

/// The list of a node that is not tracked.
const UNTRACKED: u32 = u32::MAX;
/// Least capacity of a list that had to move.
const LEAST: u32 = 8;

/// For every tracked node the cells around it, in the order in which they came.
pub(in crate::mesh) struct Incidence {
    /// Where a node's list begins in `cells`, or [`UNTRACKED`].
    start: Vec<u32>,
    length: Vec<u32>,
    capacity: Vec<u32>,
    cells: Vec<u32>,
}

impl Incidence {
    /// The cells around the nodes that `wanted` marks.
    pub(in crate::mesh) fn of(mesh: &[[u32; 4]], wanted: &[bool]) -> Self {
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
    pub(in crate::mesh) fn around(mesh: &[[u32; 4]], count: usize, nodes: impl Iterator<Item = u32>) -> Self {
        let mut wanted = vec![false; count];
        nodes.for_each(|node| wanted[node as usize] = true);
        Self::of(mesh, &wanted)
    }

    pub(in crate::mesh) fn tracks(&self, node: u32) -> bool {
        self.start[node as usize] != UNTRACKED
    }

    /// The cells around a node; none where it is not tracked.
    pub(in crate::mesh) fn cells(&self, node: u32) -> &[u32] {
        if !self.tracks(node) {
            return &[];
        }
        let (start, length) = (self.start[node as usize] as usize, self.length[node as usize] as usize);
        &self.cells[start..start + length]
    }

    /// Adds a cell to the lists of its nodes.
    pub(in crate::mesh) fn link(&mut self, cell: u32, nodes: &[u32; 4]) {
        for &node in nodes {
            if self.tracks(node) {
                self.push(node, cell);
            }
        }
    }

    /// Takes a cell out of the lists of its nodes.
    pub(in crate::mesh) fn unlink(&mut self, cell: u32, nodes: &[u32; 4]) {
        for &node in nodes {
            let start = self.start[node as usize] as usize;
            if let Some(at) = self.cells(node).iter().position(|other| *other == cell) {
                let end = start + self.length[node as usize] as usize;
                self.cells.copy_within(start + at + 1..end, start + at);
                self.length[node as usize] -= 1;
            }
        }
    }

    /// Gives what `node` has to `into`, before its own, and leaves it nothing.
    pub(in crate::mesh) fn join(&mut self, node: u32, into: u32) {
        let all = [self.cells(node), self.cells(into)].concat();
        self.length[node as usize] = 0;
        self.length[into as usize] = 0;
        all.into_iter().for_each(|cell| self.push(into, cell));
    }

    /// Tracks one node more, without cells.
    pub(in crate::mesh) fn add_node(&mut self) {
        self.start.push(self.cells.len() as u32);
        self.length.push(0);
        self.capacity.push(0);
    }

    /// Forgets the node that was added last.
    pub(in crate::mesh) fn forget_last_node(&mut self) {
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
