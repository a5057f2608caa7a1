//! Which aggregates are near: a grid of cells, each with the aggregates whose boxes reach into it.

use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::stop;

/// Aggregates by position.
pub(super) struct Index {
    container: Aabb,
    /// Edge of a cell, mm.
    cell: f64,
    counts: [usize; 3],
    /// The aggregates of cell `c` are `members[starts[c]..starts[c + 1]]`.
    starts: Vec<u32>,
    members: Vec<u32>,
    boxes: Vec<Aabb>,
}

impl Index {
    /// About one cell to an aggregate.
    pub(super) fn new(aggregates: &[Aggregate], container: &Aabb) -> Self {
        let size = container.size();
        let cell = libm::cbrt(size.product() / aggregates.len().max(1) as f64);
        let counts = [0, 1, 2].map(|k| (size[k] / cell).ceil().max(1.0) as usize);
        let boxes: Vec<Aabb> = aggregates.iter().map(|a| a.body.aabb()).collect();
        let mut index = Self { container: *container, cell, counts, starts: Vec::new(), members: Vec::new(), boxes };
        index.fill();
        index
    }

    /// The box of an aggregate.
    pub(super) fn aabb(&self, aggregate: u32) -> &Aabb {
        &self.boxes[aggregate as usize]
    }

    /// Edge of a cell, mm.
    pub(super) fn cell(&self) -> f64 {
        self.cell
    }

    /// Appends the aggregates whose boxes meet `aabb`, some of them more than once.
    pub(super) fn near(&self, aabb: &Aabb, found: &mut Vec<u32>) {
        for c in self.cells(aabb) {
            let members = &self.members[self.starts[c] as usize..self.starts[c + 1] as usize];
            found.extend(members.iter().filter(|&&a| self.aabb(a).intersects(aabb)));
        }
    }

    fn fill(&mut self) {
        self.starts = vec![0; self.counts.iter().product::<usize>() + 1];
        let boxes = std::mem::take(&mut self.boxes);
        for aabb in &boxes {
            stop::point();
            self.cells(aabb).for_each(|c| self.starts[c + 1] += 1);
        }
        for c in 1..self.starts.len() {
            self.starts[c] += self.starts[c - 1];
        }
        let mut next = self.starts.clone();
        self.members = vec![0; self.starts[self.starts.len() - 1] as usize];
        for (a, aabb) in (0..).zip(&boxes) {
            stop::point();
            for c in self.cells(aabb) {
                self.members[next[c] as usize] = a;
                next[c] += 1;
            }
        }
        self.boxes = boxes;
    }

    /// The cells that a box reaches into; parts outside the container count to its outermost cells.
    fn cells(&self, aabb: &Aabb) -> impl Iterator<Item = usize> + use<> {
        let counts = self.counts;
        let of = |corner: &Vec3, k: usize| {
            let cell = ((corner[k] - self.container.min[k]) / self.cell).floor();
            cell.clamp(0.0, (counts[k] - 1) as f64) as usize
        };
        let [x, y, z] = [0, 1, 2].map(|k| of(&aabb.min, k)..=of(&aabb.max, k));
        z.flat_map(move |k| y.clone().map(move |j| (j, k)))
            .flat_map(move |(j, k)| x.clone().map(move |i| (k * counts[1] + j) * counts[0] + i))
    }
}
