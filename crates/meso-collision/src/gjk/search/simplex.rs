//! Storage of a simplex in the configuration space obstacle A - B; it knows no policy.

use nalgebra::Vector3;

/// A point of A - B, and the points of A and B it is the difference of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertex<T = f64> {
    /// Position in A - B, rounded.
    pub(crate) w: Vector3<T>,
    /// Slots in A and in B.
    pub(crate) of: (u32, u32),
}

/// At most four vertices; the newest, `a` in the paper's letters, is the last.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Simplex {
    vertices: [Vertex; 4],
    len: usize,
}

impl Simplex {
    /// The simplex of one vertex.
    #[inline(always)]
    pub(crate) fn point(a: Vertex) -> Self {
        Self { vertices: [a; 4], len: 1 }
    }

    /// The vertices, newest last.
    #[inline(always)]
    pub(crate) fn vertices(&self) -> &[Vertex] {
        &self.vertices[..self.len]
    }

    /// All four vertices, if there are four.
    #[inline(always)]
    pub(crate) fn tetrahedron(&self) -> Option<&[Vertex; 4]> {
        (self.len == 4).then_some(&self.vertices)
    }

    /// Adds the newest vertex.
    #[inline(always)]
    pub(crate) fn add(&mut self, a: Vertex) {
        self.vertices[self.len] = a;
        self.len += 1;
    }

    /// Keeps these, in this order.
    #[inline(always)]
    pub(crate) fn keep(&mut self, kept: &[Vertex]) {
        self.len = kept.len();
        self.vertices[..kept.len()].copy_from_slice(kept);
    }

    /// True when a vertex is the difference of the same two points.
    #[inline(always)]
    pub(crate) fn contains(&self, of: (u32, u32)) -> bool {
        self.vertices().iter().any(|v| v.of == of)
    }

    /// The pairs of points the vertices are made of; `points_of` tells points from slots.
    #[inline(always)]
    pub(crate) fn corners(&self, points_of: impl Fn((u32, u32)) -> (u32, u32)) -> Corners {
        Corners { of: self.vertices.map(|v| points_of(v.of)), len: self.len }
    }
}

/// At most four pairs of points, of A and of B.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corners {
    of: [(u32, u32); 4],
    len: usize,
}

impl Corners {
    /// These pairs.
    pub(crate) fn of(pairs: [(u32, u32); 3]) -> Self {
        let [p, q, r] = pairs;
        Self { of: [p, q, r, r], len: 3 }
    }

    /// No pairs.
    pub(crate) const NONE: Self = Self { of: [(0, 0); 4], len: 0 };

    /// The pairs.
    pub(crate) fn pairs(&self) -> &[(u32, u32)] {
        &self.of[..self.len]
    }
}
