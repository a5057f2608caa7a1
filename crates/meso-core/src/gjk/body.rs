//! A body laid out for many queries: coordinates in blocks of eight, and what decides most pairs in one cache line.

use super::ellipsoid::Ellipsoids;
use super::support::Support;
use crate::geometry::Polyhedron;
use crate::math::{Mat3, Vec3};

/// Points per [`Block`]: one AVX-512 register of doubles.
pub(crate) const LANES: usize = 8;
/// Blocks kept inside the body: bodies of up to 32 points need no second allocation.
pub(crate) const INLINE_BLOCKS: usize = 4;

/// Eight points, coordinate by coordinate.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Block(pub(crate) [[f64; LANES]; 3]);

/// The hull of points in the body's own frame; pairs of bodies are asked about with a translation between the frames.
///
/// The points are as given: turn them before. The origin of the frame should lie inside, near the middle.
/// 832 bytes for up to 32 points: a header of 64 bytes, and four blocks of eight points.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Body {
    pub(crate) bounds: Ellipsoids,
    len: u32,
    rest: Option<Box<[Block]>>,
    inline: [Block; INLINE_BLOCKS],
}

impl Body {
    /// A body from points (mm), bounded by the ellipsoid of their second moments.
    ///
    /// # Panics
    /// Without points.
    pub fn new(points: &[Vec3]) -> Self {
        Self::bounded(points, Ellipsoids::around(points, &Ellipsoids::moments(points)))
    }

    /// A body whose points lie on or near the ellipsoid `semi_axes` (mm), turned by `rotation`, about the frame's origin.
    ///
    /// The ellipsoid is enlarged until it holds every point; it serves to tell pairs apart early.
    ///
    /// # Panics
    /// Without points.
    pub fn on_ellipsoid(points: &[Vec3], semi_axes: &Vec3, rotation: &Mat3) -> Self {
        let squares = Mat3::from_diagonal(&semi_axes.component_mul(semi_axes));
        Self::bounded(points, Ellipsoids::around(points, &(rotation * squares * rotation.transpose())))
    }

    /// Adds what the face planes of `solid`, whose vertices this body has, prove about its inside.
    ///
    /// Pairs that overlap deeply are then decided without looking at a vertex.
    #[must_use]
    pub fn with_inside_of(mut self, solid: &Polyhedron) -> Self {
        self.bounds.measure_inside(solid);
        self
    }

    /// The body without its bounds, for a single query.
    pub(crate) fn bare(points: impl ExactSizeIterator<Item = Vec3>) -> Self {
        let first = Block([[0.0; LANES]; 3]);
        let mut body = Self { bounds: Ellipsoids::unknown(), len: 0, rest: None, inline: [first; INLINE_BLOCKS] };
        body.fill(points);
        body
    }

    fn bounded(points: &[Vec3], bounds: Ellipsoids) -> Self {
        assert!(!points.is_empty(), "a body needs at least one point");
        Self { bounds, ..Self::bare(points.iter().copied()) }
    }

    /// Stores the points and repeats the first one up to a whole group of blocks: padding never changes a support.
    fn fill(&mut self, points: impl ExactSizeIterator<Item = Vec3>) {
        self.len = u32::try_from(points.len()).expect("fewer than 2^32 points");
        let group = LANES * INLINE_BLOCKS;
        let extra_blocks = (points.len().div_ceil(group).max(1) - 1) * INLINE_BLOCKS;
        let mut extra = vec![self.inline[0]; extra_blocks];
        let mut first = Vec3::zeros();
        let mut end = 0;
        for (i, p) in points.enumerate() {
            if i == 0 {
                first = p;
            }
            set(&mut self.inline, &mut extra, i, &p);
            end = i + 1;
        }
        for i in end..group + extra_blocks * LANES {
            set(&mut self.inline, &mut extra, i, &first);
        }
        self.rest = (extra_blocks > 0).then(|| extra.into_boxed_slice());
    }

    /// The index of the point in slot `i`: padding stands for the first point.
    #[inline(always)]
    pub(crate) fn unpadded(&self, i: u32) -> u32 {
        if i < self.len { i } else { 0 }
    }

    /// The four blocks every body has.
    #[inline(always)]
    pub(crate) fn inline_blocks(&self) -> &[Block; INLINE_BLOCKS] {
        &self.inline
    }

    /// Further blocks, in groups of four, of a body with more than 32 points.
    #[inline(always)]
    pub(crate) fn more_blocks(&self) -> &[Block] {
        self.rest.as_deref().unwrap_or(&[])
    }

    /// Radius of the sphere about the frame's origin that holds the body, mm.
    pub fn circumradius(&self) -> f64 {
        self.bounds.circumradius
    }

    /// Radius of a sphere about the frame's origin that lies in the body, mm; 0 where none is known.
    pub fn inradius(&self) -> f64 {
        f64::from(self.bounds.inradius)
    }
}

#[inline(always)]
fn set(inline: &mut [Block; INLINE_BLOCKS], extra: &mut [Block], i: usize, p: &Vec3) {
    let (block, lane) = (i / LANES, i % LANES);
    let Block(axes) = if block < INLINE_BLOCKS { &mut inline[block] } else { &mut extra[block - INLINE_BLOCKS] };
    for (axis, value) in axes.iter_mut().zip(p.iter()) {
        axis[lane] = *value;
    }
}

impl Support for Body {
    fn len(&self) -> usize {
        self.len as usize
    }

    #[inline(always)]
    fn point(&self, i: usize) -> Vec3 {
        let (block, lane) = (i / LANES, i % LANES);
        let Block([x, y, z]) =
            if block < INLINE_BLOCKS { &self.inline[block] } else { &self.more_blocks()[block - INLINE_BLOCKS] };
        Vec3::new(x[lane], y[lane], z[lane])
    }
}
