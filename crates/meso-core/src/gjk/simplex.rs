//! Storage of a simplex in the configuration space obstacle A - B; it knows no policy.

use crate::math::Vec3;

/// A point of A - B, and the points of A and B it is the difference of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vertex {
    /// Position in A - B, rounded.
    pub(crate) w: Vec3,
    /// Indices in A and in B.
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

    /// The pairs of points, as a starting point for exact arithmetic.
    pub(crate) fn pairs(&self) -> Vec<(u32, u32)> {
        self.vertices().iter().map(|v| v.of).collect()
    }
}
