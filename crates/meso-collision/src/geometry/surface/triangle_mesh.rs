//! Any closed surface of triangles, convex or not.

use crate::geometry::measure::integrals;
use crate::geometry::{HullError, Polyhedron, Triangles, convex_hull};
use crate::math::Vec3;
use std::collections::HashMap;

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
    #[error("it encloses {volume} mm3; its triangles must be counter-clockwise seen from outside")]
    NoVolume {
        /// mm3.
        volume: f64,
    },
}

impl Polyhedron {
    /// The body inside a closed surface that need not be convex.
    ///
    /// Its triangles get the order of a tree of boxes, which every copy of the body keeps: see [`Triangles::in_order`].
    pub fn of_surface(mesh: &TriangleMesh) -> Self {
        let tree = mesh.facets();
        let ordered = tree.order().iter().map(|&t| mesh.triangles[t as usize]);
        Self::from_parts(mesh.vertices.clone(), ordered).with_dents()
    }
}

impl TriangleMesh {
    /// The mesh of `corners`, three a triangle; corners at the same position become one vertex, and triangles that lose a
    /// corner by that are left out.
    pub fn welded(corners: &[Vec3]) -> Self {
        let (mut vertices, mut triangles) = (Vec::new(), Vec::with_capacity(corners.len() / 3));
        let mut known = HashMap::with_capacity(corners.len() / 6);
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

    /// Its triangles by their corners, to be asked which points they hold and whether they are apart from others.
    pub fn facets(&self) -> Triangles {
        Triangles::new(self.triangles.iter().map(|t| t.map(|i| self.vertices[i as usize])).collect())
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
        self.check_edges()?;
        let volume = self.volume();
        if volume > 0.0 { Ok(()) } else { Err(SurfaceError::NoVolume { volume }) }
    }

    /// Succeeds where every edge lies between two triangles that pass it in opposite directions.
    ///
    /// # Errors
    /// [`SurfaceError::Open`] and [`SurfaceError::NotManifold`].
    pub fn check_edges(&self) -> Result<(), SurfaceError> {
        let of_triangle = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
        let mut edges: Vec<(u32, u32)> = self.triangles.iter().flat_map(of_triangle).collect();
        edges.sort_unstable();
        if let Some(&[(from, to), ..]) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(SurfaceError::NotManifold { from: self.position(from), to: self.position(to) });
        }
        let mut opposite: Vec<(u32, u32)> = edges.iter().map(|&(from, to)| (to, from)).collect();
        opposite.sort_unstable();
        // Two lists compare faster than every edge is looked up.
        if edges != opposite {
            let open: Vec<_> = edges.iter().filter(|edge| opposite.binary_search(edge).is_err()).collect();
            let &(from, to) = open[0];
            return Err(SurfaceError::Open { edges: open.len(), from: self.position(from), to: self.position(to) });
        }
        Ok(())
    }

    fn position(&self, vertex: u32) -> [f64; 3] {
        self.vertices[vertex as usize].into()
    }
}
