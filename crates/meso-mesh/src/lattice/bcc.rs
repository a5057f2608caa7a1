//! The body-centred cubic lattice that fills a box: node numbers, neighbours, tetrahedra.
//!
//! Nodes are the corners of the box's cubic cells, then the cells' centres. Every face between two cells carries four
//! tetrahedra, each spanned by the two centres and one edge of the face: dihedral angles 60 and 90 degrees. On the
//! box's own faces the pyramid below a face is halved by a diagonal, 45 degrees at worst.

use crate::cells::side_bits;
use meso_collision::math::{Aabb, Vec3};

/// The lattice of a box.
pub(super) struct Bcc {
    domain: Aabb,
    pub(super) spacing: Vec3,
    pub(super) counts: [usize; 3],
}

/// Kinds of lattice edges, the longest last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum EdgeKind {
    /// Between a corner and a centre: sqrt(3)/2 of the spacing.
    Short,
    /// Between two corners or two centres: the spacing.
    Long,
    /// Across a square on the box's surface: sqrt(2) of the spacing.
    Diagonal,
}

impl Bcc {
    pub(super) fn new(domain: Aabb, element_size: f64) -> Self {
        let counts = [0, 1, 2].map(|i| (domain.size()[i] / element_size).round().max(1.0) as usize);
        let spacing = Vec3::from_fn(|i, _| domain.size()[i] / counts[i] as f64);
        Self { domain, spacing, counts }
    }

    /// With one more cell on each of the `open` sides, low and high by axis; the others' nodes stay where they are.
    pub(super) fn reaching_beyond(self, open: [[bool; 2]; 3]) -> Self {
        let more = |high: usize| Vec3::from_fn(|i, _| if open[i][high] { self.spacing[i] } else { 0.0 });
        Self {
            domain: Aabb { min: self.domain.min - more(0), max: self.domain.max + more(1) },
            spacing: self.spacing,
            counts: [0, 1, 2].map(|i| self.counts[i] + open[i].iter().filter(|open| **open).count()),
        }
    }

    /// The box that it fills.
    pub(super) fn domain(&self) -> &Aabb {
        &self.domain
    }

    /// Number of corner nodes; centres follow.
    pub(super) fn corners(&self) -> usize {
        self.counts.iter().map(|c| c + 1).product()
    }

    pub(super) fn nodes(&self) -> usize {
        self.corners() + self.counts.iter().product::<usize>()
    }

    pub(super) fn corner(&self, [i, j, k]: [usize; 3]) -> u32 {
        ((k * (self.counts[1] + 1) + j) * (self.counts[0] + 1) + i) as u32
    }

    pub(super) fn centre(&self, [i, j, k]: [usize; 3]) -> u32 {
        (self.corners() + (k * self.counts[1] + j) * self.counts[0] + i) as u32
    }

    fn is_corner(&self, node: u32) -> bool {
        (node as usize) < self.corners()
    }

    /// Cell indices of a node, as a corner or as a centre.
    fn indices(&self, node: u32) -> [usize; 3] {
        let corner = self.is_corner(node);
        let (rest, extra) = if corner { (node as usize, 1) } else { (node as usize - self.corners(), 0) };
        let [nx, ny, _] = self.counts.map(|c| c + extra);
        [rest % nx, rest / nx % ny, rest / (nx * ny)]
    }

    /// Position of a node, mm; nodes on the box's faces have its own coordinates.
    pub(super) fn position(&self, node: u32) -> Vec3 {
        let at = self.indices(node);
        let shift = if self.is_corner(node) { 0.0 } else { 0.5 };
        Vec3::from_fn(|axis, _| {
            if at[axis] == self.counts[axis] {
                self.domain.max[axis]
            } else {
                self.domain.min[axis] + (at[axis] as f64 + shift) * self.spacing[axis]
            }
        })
    }

    /// The box's faces a node lies on: bits 2 axis (low) and 2 axis + 1 (high).
    pub(super) fn walls(&self, node: u32) -> u8 {
        if !self.is_corner(node) {
            return 0;
        }
        let at = self.indices(node);
        side_bits(|axis| [at[axis] == 0, at[axis] == self.counts[axis]])
    }

    pub(super) fn kind(&self, a: u32, b: u32) -> EdgeKind {
        if self.is_corner(a) != self.is_corner(b) {
            return EdgeKind::Short;
        }
        let (a, b) = (self.indices(a), self.indices(b));
        if (0..3).filter(|&i| a[i] != b[i]).count() == 1 { EdgeKind::Long } else { EdgeKind::Diagonal }
    }

    /// Calls `visit` with every neighbour of `node`.
    pub(super) fn neighbours(&self, node: u32, mut visit: impl FnMut(u32)) {
        let at = self.indices(node);
        let corner = self.is_corner(node);
        let like = |at| if corner { self.corner(at) } else { self.centre(at) };
        for axis in 0..3 {
            let count = self.counts[axis] + usize::from(corner);
            if at[axis] > 0 {
                visit(like(moved(at, axis, -1)));
            }
            if at[axis] + 1 < count {
                visit(like(moved(at, axis, 1)));
            }
        }
        self.other_kind(at, corner, &mut visit);
        self.diagonals(node, at, &mut visit);
    }

    /// The up to eight centres around a corner, or corners around a centre.
    fn other_kind(&self, at: [usize; 3], corner: bool, visit: &mut impl FnMut(u32)) {
        for bits in 0..8_usize {
            let step = [0, 1, 2].map(|axis| bits >> axis & 1);
            if !corner {
                visit(self.corner([0, 1, 2].map(|axis| at[axis] + step[axis])));
            } else if (0..3).all(|axis| at[axis] >= step[axis] && at[axis] - step[axis] < self.counts[axis]) {
                visit(self.centre([0, 1, 2].map(|axis| at[axis] - step[axis])));
            }
        }
    }

    /// The ends of the box-face diagonals at a corner: they run from (u, v) to (u + 1, v + 1).
    fn diagonals(&self, node: u32, at: [usize; 3], visit: &mut impl FnMut(u32)) {
        let walls = self.walls(node);
        for axis in (0..3).filter(|axis| walls >> (2 * axis) & 3 != 0) {
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            if at[u] > 0 && at[v] > 0 {
                visit(self.corner(moved(moved(at, u, -1), v, -1)));
            }
            if at[u] < self.counts[u] && at[v] < self.counts[v] {
                visit(self.corner(moved(moved(at, u, 1), v, 1)));
            }
        }
    }

    /// Calls `visit` with the tetrahedra of the cells in layer `k`; their orientation is not settled.
    pub(super) fn tetrahedra(&self, k: usize, mut visit: impl FnMut([u32; 4])) {
        for j in 0..self.counts[1] {
            for i in 0..self.counts[0] {
                for axis in 0..3 {
                    self.face_tetrahedra([i, j, k], axis, &mut visit);
                }
            }
        }
    }

    /// The tetrahedra at the upper face of a cell across `axis`, and at the lower face where that is the box's.
    fn face_tetrahedra(&self, cell: [usize; 3], axis: usize, visit: &mut impl FnMut([u32; 4])) {
        let centre = self.centre(cell);
        let upper = self.square(moved(cell, axis, 1), axis);
        if cell[axis] + 1 < self.counts[axis] {
            let next = self.centre(moved(cell, axis, 1));
            (0..4).for_each(|e| visit([centre, next, upper[e], upper[(e + 1) % 4]]));
        } else {
            pyramid(centre, upper, visit);
        }
        if cell[axis] == 0 {
            pyramid(centre, self.square(cell, axis), visit);
        }
    }

    /// The corners of the cell face that lies across `axis` at `cell`, in turn: (u, v), (u+1, v), (u+1, v+1), (u, v+1).
    fn square(&self, cell: [usize; 3], axis: usize) -> [u32; 4] {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let next = moved(cell, u, 1);
        [cell, next, moved(next, v, 1), moved(cell, v, 1)].map(|at| self.corner(at))
    }
}

fn pyramid(apex: u32, [a, b, c, d]: [u32; 4], visit: &mut impl FnMut([u32; 4])) {
    visit([apex, a, b, c]);
    visit([apex, a, c, d]);
}

fn moved(mut at: [usize; 3], axis: usize, by: isize) -> [usize; 3] {
    at[axis] = at[axis].wrapping_add_signed(by);
    at
}
