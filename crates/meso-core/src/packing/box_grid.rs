//! Broad phase: a grid of cells that each list the bodies whose box reaches into them.

use super::cell_grid::{CellGrid, cells, is_first_common};
use crate::math::Aabb;

/// Bodies by the cells their boxes reach into. Bodies are only ever added.
#[derive(Clone, Debug)]
pub(super) struct BoxGrid {
    grid: CellGrid,
    /// By cell, each in one piece: links from body to body would each wait for memory.
    lists: Vec<Vec<u32>>,
    /// Lowest cell of every body, by body.
    lowest: Vec<[u16; 3]>,
}

impl BoxGrid {
    /// A grid over `domain` with cells of about `cell` mm.
    pub(super) fn new(domain: &Aabb, cell: f64) -> Self {
        let grid = CellGrid::new(domain, cell);
        Self { lists: vec![Vec::new(); grid.len()], grid, lowest: Vec::new() }
    }

    /// Adds the next body; bodies are numbered from 0 in the order they come.
    pub(super) fn insert(&mut self, aabb: &Aabb) {
        let (low, high) = self.grid.range(aabb);
        for cell in cells(low, high) {
            self.lists[self.grid.flat(cell)].push(self.lowest.len() as u32);
        }
        self.lowest.push(low.map(|i| i as u16));
    }

    /// Every body whose cells meet those of `aabb`, each once; stops and returns false when `visit` returns false.
    pub(super) fn all_near(&self, aabb: &Aabb, mut visit: impl FnMut(u32) -> bool) -> bool {
        let (low, high) = self.grid.range(aabb);
        cells(low, high).all(|cell| {
            self.lists[self.grid.flat(cell)]
                .iter()
                .rev()
                .all(|&body| !is_first_common(cell, low, self.lowest[body as usize]) || visit(body))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aggregate::random::{Purpose, Stream};
    use crate::math::Vec3;

    #[test]
    fn near_bodies_are_named_once_each() {
        let domain = Aabb { min: Vec3::zeros(), max: Vec3::repeat(30.0) };
        let mut stream = Stream::new(3, Purpose::Sample, 0, 0);
        let boxes: Vec<Aabb> = (0..200)
            .map(|_| {
                let min = stream.point(&domain.min, &domain.max);
                Aabb { min, max: min + stream.point(&Vec3::zeros(), &Vec3::repeat(9.0)) }
            })
            .collect();
        let mut grid = BoxGrid::new(&domain, 4.0);
        boxes.iter().for_each(|aabb| grid.insert(aabb));
        for aabb in &boxes {
            let mut seen = vec![0; boxes.len()];
            grid.all_near(aabb, |body| {
                seen[body as usize] += 1;
                true
            });
            for (body, other) in boxes.iter().enumerate() {
                assert!(seen[body] <= 1);
                assert!(seen[body] == 1 || !aabb.intersects(other), "a near body was missed");
            }
        }
    }
}
