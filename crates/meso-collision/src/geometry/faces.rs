//! Polygon lists in as few bytes as their indices need: a million grains live in memory at once.

#[cfg(feature = "serde")]
use serde::{Serialize, Serializer};

/// Polygons over vertices 0, 1, 2, ..., each a run of vertex indices.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FaceList {
    lists: Owned,
    corners: u32,
    /// It stands here because it takes no memory beside `corners`.
    pub(crate) role: Role,
}

/// What the faces are to their body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Role {
    /// They bound a convex polyhedron.
    #[default]
    Hull,
    /// They are the triangles of a surface that need not be convex; `caps` has a bit for each side of its box, lower and
    /// upper along x, y, z, where a cut ends it.
    Surface { caps: u8 },
    /// They are facets within a round body, which the first six vertices determine.
    Facets,
}

/// A [`FaceList`] wherever its indices are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Faces<'a> {
    /// The corners of all faces; then, unless every face is a triangle, one past the last corner of each.
    pub(crate) lists: Indices<'a>,
    pub(crate) corners: usize,
    pub(crate) role: Role,
}

/// One face of a polyhedron: its vertex indices, counter-clockwise from outside.
#[derive(Clone, Copy, Debug)]
pub struct Face<'a> {
    lists: Indices<'a>,
    start: usize,
    end: usize,
}

/// Indices in the narrowest type that holds the largest of them.
#[derive(Clone, Debug, PartialEq)]
enum Owned {
    U8(Box<[u8]>),
    U16(Box<[u16]>),
    U32(Box<[u32]>),
}

/// Borrowed indices in the narrowest type.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Indices<'a> {
    U8(&'a [u8]),
    U16(&'a [u16]),
    U32(&'a [u32]),
}

impl FaceList {
    /// Stores the faces whose corners are `corners[0..ends[0]]`, `corners[ends[0]..ends[1]]`, ...
    pub(crate) fn new(corners: &[u32], ends: &[u32]) -> Self {
        let triangles = ends.iter().zip(1..).all(|(&end, count)| end == 3 * count);
        let lists = if triangles { Owned::new(corners) } else { Owned::new(&[corners, ends].concat()) };
        Self { lists, corners: corners.len() as u32, role: Role::Hull }
    }

    /// Triangles with these corners, one after the other.
    pub(crate) fn of_triangles(corners: Box<[u8]>) -> Self {
        Self { corners: corners.len() as u32, lists: Owned::U8(corners), role: Role::Hull }
    }

    pub(crate) fn faces(&self) -> Faces<'_> {
        let lists = match &self.lists {
            Owned::U8(values) => Indices::U8(values),
            Owned::U16(values) => Indices::U16(values),
            Owned::U32(values) => Indices::U32(values),
        };
        Faces { lists, corners: self.corners as usize, role: self.role }
    }
}

impl From<Faces<'_>> for FaceList {
    fn from(faces: Faces) -> Self {
        let lists = match faces.lists {
            Indices::U8(values) => Owned::U8(values.into()),
            Indices::U16(values) => Owned::U16(values.into()),
            Indices::U32(values) => Owned::U32(values.into()),
        };
        Self { lists, corners: faces.corners as u32, role: faces.role }
    }
}

impl<'a> Faces<'a> {
    fn len(self) -> usize {
        if self.are_triangles() { self.corners / 3 } else { self.lists.len() - self.corners }
    }

    fn are_triangles(self) -> bool {
        self.lists.len() == self.corners
    }

    pub(crate) fn iter(self) -> impl ExactSizeIterator<Item = Face<'a>> + Clone {
        (0..self.len()).map(move |f| self.face(f))
    }

    /// The faces of nearly all bodies: triangles over up to 256 vertices; `None` for others.
    pub(crate) fn byte_triangles(self) -> Option<&'a [[u8; 3]]> {
        match self.lists {
            Indices::U8(corners) if self.are_triangles() => Some(corners.as_chunks().0),
            _ => None,
        }
    }

    fn face(self, f: usize) -> Face<'a> {
        let end = |f: usize| self.lists.get(self.corners + f) as usize;
        let (start, end) = match self.are_triangles() {
            true => (3 * f, 3 * f + 3),
            false => (if f == 0 { 0 } else { end(f - 1) }, end(f)),
        };
        Face { lists: self.lists, start, end }
    }
}

/// As the list of its vertex indices.
#[cfg(feature = "serde")]
impl Serialize for Face<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.iter())
    }
}

impl<'a> Face<'a> {
    /// Number of vertices.
    #[expect(clippy::len_without_is_empty, reason = "no face is empty")]
    pub fn len(self) -> usize {
        self.end - self.start
    }

    /// The index of the face's `k`-th vertex.
    ///
    /// # Panics
    /// Where `k` is not less than [`Face::len`].
    pub fn vertex(self, k: usize) -> u32 {
        assert!(k < self.len(), "vertex {k} of a face with {}", self.len());
        self.lists.get(self.start + k)
    }

    /// The vertex indices in order.
    pub fn iter(self) -> impl ExactSizeIterator<Item = u32> + Clone + use<'a> {
        (self.start..self.end).map(move |k| self.lists.get(k))
    }

    /// The vertex indices as a list.
    pub fn to_vec(self) -> Vec<u32> {
        self.iter().collect()
    }

    /// The face cut into triangles, fan-wise from its first vertex.
    pub fn triangles(self) -> impl Iterator<Item = [u32; 3]> + Clone + use<'a> {
        let at = move |k| self.lists.get(self.start + k);
        (2..self.len()).map(move |k| [at(0), at(k - 1), at(k)])
    }
}

impl Owned {
    fn new(values: &[u32]) -> Self {
        // In vector registers, unlike the largest of references.
        match values.iter().copied().fold(0, u32::max) {
            max if max > u32::from(u16::MAX) => Self::U32(values.into()),
            max if max > u32::from(u8::MAX) => Self::U16(values.iter().map(|&i| i as u16).collect()),
            _ => Self::U8(values.iter().map(|&i| i as u8).collect()),
        }
    }
}

impl Indices<'_> {
    pub(crate) fn len(self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
            Self::U32(values) => values.len(),
        }
    }

    fn get(self, k: usize) -> u32 {
        match self {
            Self::U8(values) => u32::from(values[k]),
            Self::U16(values) => u32::from(values[k]),
            Self::U32(values) => values[k],
        }
    }
}
