//! A polyhedron in half the memory: a million grains live at once while they are placed.

use super::Polyhedron;
use super::faces::{Face, FaceList};
use crate::math::{Aabb, Vec3};

/// A convex polyhedron whose vertices are f32 numbers, coordinate by coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct NarrowPolyhedron {
    /// x of all vertices, then y, then z, mm.
    coordinates: Box<[f32]>,
    faces: FaceList,
    volume: f64,
}

/// Rounds the coordinates to f32; the volume stays that of the body as it was.
impl From<Polyhedron> for NarrowPolyhedron {
    fn from(body: Polyhedron) -> Self {
        let (vertices, faces, volume) = body.into_parts();
        let mut coordinates = Vec::with_capacity(3 * vertices.len());
        for axis in 0..3 {
            coordinates.extend(vertices.iter().map(|vertex| vertex[axis] as f32));
        }
        Self { coordinates: coordinates.into_boxed_slice(), faces, volume }
    }
}

impl NarrowPolyhedron {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.coordinates.len() / 3
    }

    /// All x, all y, all z, mm.
    pub fn coordinates(&self) -> [&[f32]; 3] {
        let (x, yz) = self.coordinates.split_at(self.vertex_count());
        let (y, z) = yz.split_at(x.len());
        [x, y, z]
    }

    /// Vertex positions, mm.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + Clone {
        let [x, y, z] = self.coordinates();
        let wide = |((x, y), z): ((&f32, &f32), &f32)| Vec3::new(f64::from(*x), f64::from(*y), f64::from(*z));
        x.iter().zip(y).zip(z).map(wide)
    }

    /// Faces as vertex indices, counter-clockwise from outside.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = Face<'_>> {
        self.faces.iter()
    }

    /// Volume, mm3.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// The smallest axis-aligned box around the body.
    pub fn aabb(&self) -> Aabb {
        let low = self.coordinates().map(|all| f64::from(all.iter().copied().fold(f32::INFINITY, f32::min)));
        let high = self.coordinates().map(|all| f64::from(all.iter().copied().fold(f32::NEG_INFINITY, f32::max)));
        Aabb { min: low.into(), max: high.into() }
    }

    /// The same body in double precision.
    pub fn widened(&self) -> Polyhedron {
        Polyhedron::of_volume(self.vertices().collect(), self.faces.clone(), self.volume)
    }

    /// The same faces over as many other vertices (mm), which must be these moved as one body.
    pub fn with_vertices(&self, vertices: Vec<Vec3>) -> Polyhedron {
        Polyhedron::with_faces(vertices.into_boxed_slice(), self.faces.clone())
    }
}
