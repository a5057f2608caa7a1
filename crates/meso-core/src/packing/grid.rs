//! Broad phase: a grid of cells that each list the bodies whose box reaches into them.

use crate::math::{Aabb, Vec3};

/// Ends a cell's list.
const NONE: u32 = u32::MAX;
/// No more cells than this, whatever the sizes: 64 MB of list heads.
const MOST_CELLS: f64 = 16.0e6;

/// Bodies by the cells their boxes reach into. Bodies are only ever added.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    origin: Vec3,
    cell: f64,
    counts: [i32; 3],
    /// First node of every cell's list.
    heads: Vec<u32>,
    /// (body, next node).
    nodes: Vec<(u32, u32)>,
    /// Lowest cell of every body, by body.
    lowest: Vec<[i32; 3]>,
}

impl Grid {
    /// A grid over `domain` with cells of about `cell` mm.
    pub(super) fn new(domain: &Aabb, cell: f64) -> Self {
        let size = domain.size();
        let cell = cell.max(libm::cbrt(size.product() / MOST_CELLS));
        let counts = [0, 1, 2].map(|i| (size[i] / cell).ceil().max(1.0) as i32);
        let heads = vec![NONE; counts.iter().map(|&n| n as usize).product()];
        Self { origin: domain.min, cell, counts, heads, nodes: Vec::new(), lowest: Vec::new() }
    }

    /// Adds the next body; bodies are numbered from 0 in the order they come.
    pub(super) fn insert(&mut self, aabb: &Aabb) {
        let body = self.lowest.len() as u32;
        let (low, high) = (self.cell_of(&aabb.min), self.cell_of(&aabb.max));
        self.lowest.push(low);
        for cell in cells(low, high) {
            let head = self.flat(cell);
            self.nodes.push((body, self.heads[head]));
            self.heads[head] = (self.nodes.len() - 1) as u32;
        }
    }

    /// The bodies that reach into the cell at `point`.
    pub(super) fn at(&self, point: &Vec3) -> impl Iterator<Item = u32> {
        self.list(self.cell_of(point)).map(|(body, _)| body)
    }

    /// Every body whose cells meet those of `aabb`, each once; stops and returns false when `visit` returns false.
    pub(super) fn all_near(&self, aabb: &Aabb, mut visit: impl FnMut(u32) -> bool) -> bool {
        let (low, high) = (self.cell_of(&aabb.min), self.cell_of(&aabb.max));
        cells(low, high).all(|cell| {
            self.list(cell).all(|(body, lowest)| {
                // Two ranges of cells share a lowest common cell; the pair is met there and nowhere else.
                let first = (0..3).all(|i| cell[i] == low[i].max(lowest[i]));
                !first || visit(body)
            })
        })
    }

    fn list(&self, cell: [i32; 3]) -> impl Iterator<Item = (u32, [i32; 3])> {
        let mut node = self.heads[self.flat(cell)];
        std::iter::from_fn(move || {
            let &(body, next) = self.nodes.get(node as usize)?;
            node = next;
            Some((body, self.lowest[body as usize]))
        })
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
