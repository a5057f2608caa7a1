//! Compact polyhedra in half the memory: a million grains live at once while they are placed.

use crate::geometry::faces::{FaceList, Faces, Indices, Role};
use crate::geometry::round::{ENDS, Round};
use crate::geometry::{BodyForm, Polyhedron};
use crate::math::{Aabb, Vec3};

/// A polyhedron whose vertices are f32 numbers, coordinate by coordinate.
#[derive(Clone, Debug, PartialEq)]
pub struct CompactPolyhedron {
    /// All lists, contiguous: x of all vertices, then y, then z, mm, as f32; then those of the faces, padded with
    /// zeros.
    lists: Box<[u32]>,
    vertices: u32,
    /// Number of corners of all faces, with [`CONCAVE`] for a surface of triangles with dents and [`ROUND`] for a round body,
    /// which has its ends alone; with the number of vertices it determines the lists' layout.
    corners: u32,
    volume: f64,
}

/// Flags beside the number of corners: no surface has as many.
const CONCAVE: u32 = 1 << 31;
const ROUND: u32 = 1 << 30;

/// Storage of the lists of faces.
enum Width {
    /// A triangle's three indices as five bits each of a `u16`.
    Five,
    U8,
    U16,
    U32,
}

/// Bits of an index among the few vertices of nearly all bodies.
const FIVE: usize = 5;

fn packed(&[a, b, c]: &[u8; 3]) -> u16 {
    u16::from(a) | u16::from(b) << FIVE | u16::from(c) << (2 * FIVE)
}

fn unpacked(triangle: u16) -> [u8; 3] {
    [0, 1, 2].map(|corner| (triangle >> (corner * FIVE)) as u8 & ((1 << FIVE) - 1))
}

/// Rounds the coordinates to f32; the volume stays that of the original body.
impl From<Polyhedron> for CompactPolyhedron {
    fn from(body: Polyhedron) -> Self {
        let flag = match body.form() {
            BodyForm::Hull => 0,
            BodyForm::Surface => CONCAVE,
            BodyForm::Round(_) => return Self::round_within(&body),
        };
        let (vertices, faces) = (body.vertices(), body.face_lists());
        let mut compact = Self {
            lists: Box::default(),
            vertices: vertices.len() as u32,
            corners: faces.corners as u32 | flag,
            volume: body.volume(),
        };
        debug_assert_eq!(faces.iter().len(), compact.face_count(), "a closed surface");
        let packed: Vec<u16> = match compact.width() {
            Width::Five => faces.byte_triangles().into_iter().flatten().map(packed).collect(),
            _ => Vec::new(),
        };
        let bytes: &[u8] = match faces.lists {
            _ if !packed.is_empty() => bytemuck::cast_slice(&packed),
            Indices::U8(values) => values,
            Indices::U16(values) => bytemuck::cast_slice(values),
            Indices::U32(values) => bytemuck::cast_slice(values),
        };
        let words = bytes.len().div_ceil(size_of::<u32>());
        let mut lists = Vec::with_capacity(3 * vertices.len() + words);
        for axis in 0..3 {
            lists.extend(vertices.iter().map(|vertex| (vertex[axis] as f32).to_bits()));
        }
        lists.resize(3 * vertices.len() + words, 0);
        bytemuck::cast_slice_mut(&mut lists[3 * vertices.len()..])[..bytes.len()].copy_from_slice(bytes);
        compact.lists = lists.into_boxed_slice();
        compact
    }
}

impl CompactPolyhedron {
    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertices as usize
    }

    /// All x, all y, all z, mm.
    pub fn coordinates(&self) -> [&[f32]; 3] {
        let n = self.vertex_count();
        let all: &[f32] = bytemuck::cast_slice(self.all_coordinates());
        [&all[..n], &all[n..2 * n], &all[2 * n..]]
    }

    /// All coordinates, contiguous, in memory order.
    #[inline(always)]
    pub fn all_coordinates(&self) -> &[u32] {
        &self.lists[..3 * self.vertex_count()]
    }

    /// The coordinates along an axis, extended to the wanted length by the memory behind them where there is enough.
    #[inline(always)]
    pub(crate) fn window<const N: usize>(&self, axis: usize) -> Option<&[f32; N]> {
        let all: &[f32] = bytemuck::cast_slice(&self.lists);
        all[axis * self.vertex_count()..].first_chunk()
    }

    /// The body by what it is; the vertices of a round one are its ends.
    pub fn form(&self) -> BodyForm {
        match self.role() {
            Role::Hull => BodyForm::Hull,
            Role::Surface { .. } => BodyForm::Surface,
            Role::Facets => {
                let [x, y, z] = self.coordinates();
                let end = |end: usize| Vec3::new(x[end].into(), y[end].into(), z[end].into());
                BodyForm::Round(Round::of_ends(&std::array::from_fn::<_, ENDS, _>(end)))
            }
        }
    }

    /// The ends alone: its facets follow from them.
    fn round_within(body: &Polyhedron) -> Self {
        let ends = &body.vertices()[..ENDS];
        let along = |axis: usize| ends.iter().map(move |end| (end[axis] as f32).to_bits());
        let lists = (0..3).flat_map(along).collect();
        Self { lists, vertices: ENDS as u32, corners: ROUND, volume: body.volume() }
    }

    pub(crate) fn role(&self) -> Role {
        match self.corners & (CONCAVE | ROUND) {
            0 => Role::Hull,
            CONCAVE => Role::Surface { caps: 0 },
            _ => Role::Facets,
        }
    }

    fn corner_count(&self) -> u32 {
        self.corners & !(CONCAVE | ROUND)
    }

    /// By Euler's formula: two faces meet at every edge, and so do two corners of faces for every edge. A surface with
    /// dents may have handles, and consists of triangles.
    fn face_count(&self) -> usize {
        let faces = match self.role() {
            Role::Hull => self.corners / 2 + 2 - self.vertices,
            Role::Surface { .. } | Role::Facets => self.corner_count() / 3,
        };
        faces as usize
    }

    fn are_triangles(&self) -> bool {
        self.corner_count() as usize == 3 * self.face_count()
    }

    fn width(&self) -> Width {
        let last_vertex = self.vertices - 1;
        // Lists of other faces than triangles end with where each of them ends.
        let most = if self.are_triangles() { last_vertex } else { last_vertex.max(self.corner_count()) };
        match most {
            _ if self.are_triangles() && last_vertex < 1 << FIVE => Width::Five,
            0..=0xff => Width::U8,
            0x100..=0xffff => Width::U16,
            _ => Width::U32,
        }
    }

    /// The faces, in the form that a body has which is worked with.
    pub(crate) fn faces(&self) -> FaceList {
        let (lists, corners) = (&self.lists[3 * self.vertex_count()..], self.corner_count() as usize);
        let len = if self.are_triangles() { corners } else { corners + self.face_count() };
        let lists = match self.width() {
            Width::Five => {
                let triangles: &[u16] = bytemuck::cast_slice(lists);
                let corners = triangles[..self.face_count()].iter().flat_map(|&triangle| unpacked(triangle));
                let mut faces = FaceList::of_triangles(corners.collect());
                faces.role = self.role();
                return faces;
            }
            Width::U8 => Indices::U8(&bytemuck::cast_slice(lists)[..len]),
            Width::U16 => Indices::U16(&bytemuck::cast_slice(lists)[..len]),
            Width::U32 => Indices::U32(&lists[..len]),
        };
        FaceList::from(Faces { lists, corners, role: self.role() })
    }

    /// Vertex positions, mm.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = Vec3> + Clone {
        let [x, y, z] = self.coordinates();
        let wide = |((x, y), z): ((&f32, &f32), &f32)| Vec3::new(f64::from(*x), f64::from(*y), f64::from(*z));
        x.iter().zip(y).zip(z).map(wide)
    }

    /// Volume, mm3.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// The smallest axis-aligned box around the body.
    pub fn aabb(&self) -> Aabb {
        if let BodyForm::Round(round) = self.form() {
            return round.aabb();
        }
        let low = self.coordinates().map(|all| f64::from(all.iter().copied().fold(f32::INFINITY, f32::min)));
        let high = self.coordinates().map(|all| f64::from(all.iter().copied().fold(f32::NEG_INFINITY, f32::max)));
        Aabb { min: low.into(), max: high.into() }
    }

    /// Returns the body in double precision.
    pub fn widened(&self) -> Polyhedron {
        Polyhedron::of_volume(self.vertices().collect(), self.faces(), self.volume)
    }

    /// Keeps the faces over as many other vertices (mm), which must be these moved as one body.
    pub fn with_vertices(&self, vertices: Vec<Vec3>) -> Polyhedron {
        Polyhedron::with_faces(vertices.into_boxed_slice(), self.faces())
    }
}
