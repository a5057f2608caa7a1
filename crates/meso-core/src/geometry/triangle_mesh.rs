//! Any closed surface of triangles, convex or not.

use super::{HullError, Polyhedron, convex_hull, integrals};
use crate::math::Vec3;
use std::collections::BTreeMap;

/// Vertices (mm) and triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct TriangleMesh {
    /// Positions, mm.
    pub vertices: Vec<Vec3>,
    /// Vertex indices.
    pub triangles: Vec<[u32; 3]>,
}

/// Why triangles are not the surface of a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SurfaceError {
    /// An edge with a triangle on one side only.
    #[error(
        "its surface is open: {edges} edge(s) have no triangle on the other side, the first from {from:?} to {to:?}"
    )]
    Open {
        /// How many such edges.
        edges: usize,
        /// One end, mm.
        from: [f64; 3],
        /// The other, mm.
        to: [f64; 3],
    },
    /// An edge that two triangles run through in the same direction.
    #[error("more than two triangles, or two of opposite sides, meet in the edge from {from:?} to {to:?}")]
    NotManifold {
        /// One end, mm.
        from: [f64; 3],
        /// The other, mm.
        to: [f64; 3],
    },
    /// The surface bounds no volume, or its inside is outside.
    #[error("it holds {volume} mm3; its triangles must be counter-clockwise seen from outside")]
    NoVolume {
        /// mm3.
        volume: f64,
    },
}

impl TriangleMesh {
    /// The mesh of `corners`, three a triangle; corners at the same place become one vertex, and triangles that lose a
    /// corner by that are left out.
    pub fn welded(corners: &[Vec3]) -> Self {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::with_capacity(corners.len() / 3));
        let mut known = BTreeMap::new();
        let mut weld = |corner: &Vec3| {
            // Adding zero makes -0 and 0 one.
            let key = [0, 1, 2].map(|axis| (corner[axis] + 0.0).to_bits());
            *known.entry(key).or_insert_with(|| {
                vertices.push(*corner);
                vertices.len() as u32 - 1
            })
        };
        for corner in corners.chunks_exact(3) {
            let triangle @ [a, b, c] = [0, 1, 2].map(|i| weld(&corner[i]));
            if a != b && b != c && c != a {
                triangles.push(triangle);
            }
        }
        Self { vertices, triangles }
    }

    /// Volume inside, mm3; negative where the triangles are clockwise.
    pub fn volume(&self) -> f64 {
        integrals::volume(&self.vertices, self.triangles.iter().copied())
    }

    /// The convex hull of its vertices.
    ///
    /// # Errors
    /// Where they have none.
    pub fn hull(&self) -> Result<Polyhedron, HullError> {
        convex_hull(&self.vertices)
    }

    /// Nothing where the surface encloses a volume without a gap, every edge between two triangles.
    ///
    /// # Errors
    /// See [`SurfaceError`].
    pub fn check_closed(&self) -> Result<(), SurfaceError> {
        let mut edges = BTreeMap::new();
        for &[a, b, c] in &self.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                if edges.insert(edge, ()).is_some() {
                    return Err(SurfaceError::NotManifold { from: self.place(edge.0), to: self.place(edge.1) });
                }
            }
        }
        let open: Vec<_> = edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).collect();
        if let Some(&&(from, to)) = open.first() {
            return Err(SurfaceError::Open { edges: open.len(), from: self.place(from), to: self.place(to) });
        }
        let volume = self.volume();
        if volume > 0.0 { Ok(()) } else { Err(SurfaceError::NoVolume { volume }) }
    }

    fn place(&self, vertex: u32) -> [f64; 3] {
        self.vertices[vertex as usize].into()
    }
}
