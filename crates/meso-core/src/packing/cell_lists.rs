//! Items by the cells of a grid that their boxes reach into.

use crate::math::{Aabb, Vec3};

/// No more cells than this, whatever the sizes: 96 MB of empty lists.
const MOST_CELLS: f64 = 4.0e6;

/// A list of items for every cell. An item stands in the list of every cell that its box reaches into; whoever looks reads
/// it there and nowhere else. Items are only ever added.
#[derive(Clone, Debug)]
pub(super) struct CellLists<T> {
    origin: Vec3,
    cell: f64,
    counts: [i32; 3],
    /// By cell, each in one piece: links from item to item would each wait for memory.
    lists: Vec<Vec<T>>,
}

impl<T: Copy> CellLists<T> {
    /// Over `domain` with cells of about `cell` mm.
    pub(super) fn new(domain: &Aabb, cell: f64) -> Self {
        let size = domain.size();
        let cell = cell.max(libm::cbrt(size.product() / MOST_CELLS));
        let counts = [0, 1, 2].map(|i| (size[i] / cell).ceil().max(1.0) as i32);
        let lists = vec![Vec::new(); counts.iter().map(|&n| n as usize).product()];
        Self { origin: domain.min, cell, counts, lists }
    }

    /// Adds an item with this box.
    pub(super) fn insert(&mut self, aabb: &Aabb, item: T) {
        let (low, high) = self.range(aabb);
        for cell in cells(low, high) {
            let cell = self.flat(cell);
            self.lists[cell].push(item);
        }
    }

    /// The items of the cell at `point`, the last first.
    pub(super) fn at(&self, point: &Vec3) -> impl Iterator<Item = T> {
        self.list(self.cell_of(point))
    }

    /// Every item of every cell that `aabb` reaches into, once for each such cell, with the cell, the last first; stops
    /// and returns false when `visit` returns false.
    #[inline]
    pub(super) fn all(&self, aabb: &Aabb, mut visit: impl FnMut([i32; 3], T) -> bool) -> bool {
        let (low, high) = self.range(aabb);
        cells(low, high).all(|cell| self.list(cell).all(|item| visit(cell, item)))
    }

    /// The lowest and the highest cell that `aabb` reaches into.
    pub(super) fn range(&self, aabb: &Aabb) -> ([i32; 3], [i32; 3]) {
        (self.cell_of(&aabb.min), self.cell_of(&aabb.max))
    }

    fn list(&self, cell: [i32; 3]) -> impl Iterator<Item = T> {
        self.lists[self.flat(cell)].iter().rev().copied()
    }

    fn cell_of(&self, point: &Vec3) -> [i32; 3] {
        [0, 1, 2].map(|i| (((point[i] - self.origin[i]) / self.cell) as i32).clamp(0, self.counts[i] - 1))
    }

    fn flat(&self, cell: [i32; 3]) -> usize {
        ((cell[2] * self.counts[1] + cell[1]) * self.counts[0] + cell[0]) as usize
    }
}

fn cells(low: [i32; 3], high: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    (low[2]..=high[2])
        .flat_map(move |z| (low[1]..=high[1]).flat_map(move |y| (low[0]..=high[0]).map(move |x| [x, y, z])))
}
