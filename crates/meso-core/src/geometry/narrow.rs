//! A polyhedron in half the memory: a million grains live at once while they are placed.

use super::Polyhedron;
use super::faces::{Face, FaceList, Faces, Indices};
use crate::math::{Aabb, Vec3};

/// A convex polyhedron whose vertices are f32 numbers, coordinate by coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct NarrowPolyhedron {
    /// All lists in one piece: x of all vertices, then y, then z, mm, as f32; then those of the faces, padded with zeros.
    lists: Box<[u32]>,
    vertices: u32,
    /// Of all faces.
    corners: u32,
    /// Of the faces' lists, in all.
    indices: u32,
    width: Width,
    volume: f64,
}

/// What an index is stored as.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Width {
    U8,
    U16,
    U32,
}

/// Rounds the coordinates to f32; the volume stays that of the body as it was.
impl From<Polyhedron> for NarrowPolyhedron {
    fn from(body: Polyhedron) -> Self {
        let faces = body.face_lists();
        let (width, bytes): (_, &[u8]) = match faces.lists {
            Indices::U8(values) => (Width::U8, values),
            Indices::U16(values) => (Width::U16, bytemuck::cast_slice(values)),
            Indices::U32(values) => (Width::U32, bytemuck::cast_slice(values)),
        };
        let vertices = body.vertices();
        let words = bytes.len().div_ceil(size_of::<u32>());
        let mut lists = Vec::with_capacity(3 * vertices.len() + words);
        for axis in 0..3 {
            lists.extend(vertices.iter().map(|vertex| (vertex[axis] as f32).to_bits()));
        }
        lists.resize(3 * vertices.len() + words, 0);
        bytemuck::cast_slice_mut(&mut lists[3 * vertices.len()..])[..bytes.len()].copy_from_slice(bytes);
        Self {
            lists: lists.into_boxed_slice(),
            vertices: vertices.len() as u32,
            corners: faces.corners as u32,
            indices: faces.lists.len() as u32,
            width,
            volume: body.volume(),
        }
    }
}

impl NarrowPolyhedron {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertices as usize
    }

    /// All x, all y, all z, mm.
    pub fn coordinates(&self) -> [&[f32]; 3] {
        let n = self.vertex_count();
        let all: &[f32] = bytemuck::cast_slice(&self.lists[..3 * n]);
        [&all[..n], &all[n..2 * n], &all[2 * n..]]
    }

    /// The coordinates along an axis, with whatever lies behind them in memory: so many numbers, if there are so many.
    #[inline(always)]
    pub(crate) fn window<const N: usize>(&self, axis: usize) -> Option<&[f32; N]> {
        let all: &[f32] = bytemuck::cast_slice(&self.lists);
        all[axis * self.vertex_count()..].first_chunk()
    }

    fn face_lists(&self) -> Faces<'_> {
        let (lists, len) = (&self.lists[3 * self.vertex_count()..], self.indices as usize);
        let lists = match self.width {
            Width::U8 => Indices::U8(&bytemuck::cast_slice(lists)[..len]),
            Width::U16 => Indices::U16(&bytemuck::cast_slice(lists)[..len]),
            Width::U32 => Indices::U32(&lists[..len]),
        };
        Faces { lists, corners: self.corners as usize }
    }

    /// Vertex positions, mm.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + Clone {
        let [x, y, z] = self.coordinates();
        let wide = |((x, y), z): ((&f32, &f32), &f32)| Vec3::new(f64::from(*x), f64::from(*y), f64::from(*z));
        x.iter().zip(y).zip(z).map(wide)
    }

    /// Faces as vertex indices, counter-clockwise from outside.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = Face<'_>> {
        self.face_lists().iter()
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
        Polyhedron::of_volume(self.vertices().collect(), FaceList::from(self.face_lists()), self.volume)
    }

    /// The same faces over as many other vertices (mm), which must be these moved as one body.
    pub fn with_vertices(&self, vertices: Vec<Vec3>) -> Polyhedron {
        Polyhedron::with_faces(vertices.into_boxed_slice(), FaceList::from(self.face_lists()))
    }
}
