//! Broad phase: a grid of cells that each list the bodies whose box reaches into them.

use super::cell_lists::CellLists;
use crate::math::{Aabb, Vec3};

/// Bodies by the cells their boxes reach into. Bodies are only ever added.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    bodies: CellLists<u32>,
    /// Lowest cell of every body, by body.
    lowest: Vec<[i32; 3]>,
}

impl Grid {
    /// A grid over `domain` with cells of about `cell` mm.
    pub(super) fn new(domain: &Aabb, cell: f64) -> Self {
        Self { bodies: CellLists::new(domain, cell), lowest: Vec::new() }
    }

    /// Adds the next body; bodies are numbered from 0 in the order they come.
    pub(super) fn insert(&mut self, aabb: &Aabb) {
        self.bodies.insert(aabb, self.lowest.len() as u32);
        self.lowest.push(self.bodies.range(aabb).0);
    }

    /// The bodies that reach into the cell at `point`.
    pub(super) fn at(&self, point: &Vec3) -> impl Iterator<Item = u32> {
        self.bodies.at(point)
    }

    /// Every body whose cells meet those of `aabb`, each once; stops and returns false when `visit` returns false.
    pub(super) fn all_near(&self, aabb: &Aabb, mut visit: impl FnMut(u32) -> bool) -> bool {
        let low = self.bodies.range(aabb).0;
        self.bodies.all(aabb, |cell, body| {
            // Two ranges of cells share a lowest common cell; the pair is met there and nowhere else.
            let lowest = self.lowest[body as usize];
            let first = (0..3).all(|i| cell[i] == low[i].max(lowest[i]));
            !first || visit(body)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aggregate::random::{Purpose, Stream};

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
        let mut grid = Grid::new(&domain, 4.0);
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
