//! A body laid out for many queries: coordinates side by side, and the bounds that decide most pairs in one cache line.

use crate::geometry::{CompactPolyhedron, Facet, Polyhedron};
use crate::gjk::prove::ellipsoid::Ellipsoids;
use crate::gjk::support::Support;
use crate::math::{Mat3, Vec3};
use crate::simd::{Wide, widest};
use nalgebra::{Scalar, Vector3};

/// Points per [`Group`]: four AVX-512 registers of doubles for each coordinate.
pub(crate) const GROUP: usize = 32;

/// Thirty-two points, coordinate by coordinate, in f64 or f32.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Group<T = f64>(pub(crate) [[T; GROUP]; 3]);

impl<T: Scalar + Copy> Group<T> {
    /// The point in slot `i`.
    #[inline(always)]
    pub(crate) fn point(&self, i: usize) -> Vector3<T> {
        let Self([x, y, z]) = self;
        Vector3::new(x[i], y[i], z[i])
    }
}

/// Radii, mm, within which no product of lengths over- or underflows in single precision.
const NARROW_RADII: std::ops::Range<f64> = 1e-5..1e5;

/// The hull of points in the body's own frame; pairs of bodies are asked about with a translation between the frames.
///
/// The points are as given: turn them before. The origin of the frame should lie inside, near the middle.
/// 1216 bytes for up to 32 points: a header of 64 bytes, and 12 and 24 bytes for each point in f32 and f64.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Body {
    pub(crate) bounds: Ellipsoids,
    len: u32,
    /// See [`Body::narrow`].
    is_narrow: bool,
    rest: Option<Box<[Group]>>,
    /// The first points, rounded to f32.
    narrow: Group<f32>,
    first: Group,
}

/// Bounds that decide most pairs without their points, in one cache line: for bodies that are made only when
/// they are needed.
#[derive(Clone, Copy, Debug)]
pub struct Bounds(pub(crate) Ellipsoids);

impl Bounds {
    /// Makes `body` the one that these are of: its memory is used again. In a body of one group only the points in f32
    /// are laid out, which are exact: [`Body::widen`] makes the others of them.
    #[inline]
    pub(crate) fn lay_out(&self, shape: &CompactPolyhedron, body: &mut Body) {
        body.bounds = self.0;
        if shape.vertex_count() > GROUP {
            body.fill(shape.vertices());
        } else {
            (body.len, body.rest) = (shape.vertex_count() as u32, None);
            widest(LaidOut { shape, group: &mut body.narrow });
        }
        body.note_narrow();
    }
}

/// Lays out up to a group of vertices on wide registers, and repeats the first one.
struct LaidOut<'a> {
    shape: &'a CompactPolyhedron,
    group: &'a mut Group<f32>,
}

impl Wide for LaidOut<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (shape, len) = (self.shape, self.shape.vertex_count());
        for (axis, slots) in self.group.0.iter_mut().enumerate() {
            // Where as much memory lies behind the vertices, whole registers are read and the excess is not used.
            match shape.window::<GROUP>(axis) {
                Some(window) => {
                    slots.copy_from_slice(window);
                    let first = slots[0];
                    slots[len..].fill(first);
                }
                None => {
                    let along = shape.coordinates()[axis];
                    for (i, slot) in slots.iter_mut().enumerate() {
                        *slot = along[if i < len { i } else { 0 }];
                    }
                }
            }
        }
    }
}

/// The points in f64.
struct Widened<'a>(&'a Group<f32>, &'a mut Group);

impl Wide for Widened<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self(Group(narrow), Group(wide)) = self;
        for (narrow, wide) in narrow.iter().zip(wide) {
            for i in 0..GROUP {
                wide[i] = f64::from(narrow[i]);
            }
        }
    }
}

impl Body {
    /// A body from points (mm), bounded by the ellipsoid of their second moments.
    ///
    /// # Panics
    /// Without points.
    ///
    /// ```
    /// use meso_collision::{gjk::Body, math::Vec3};
    /// let corners = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()];
    /// let body = Body::new(&corners);
    /// assert!(body.overlaps(&body, &Vec3::new(2.0, 0.0, 0.0)));
    /// ```
    pub fn new(points: &[Vec3]) -> Self {
        Self::bounded(points, Ellipsoids::around(points, &Ellipsoids::moments(points)))
    }

    /// A body whose points lie on or near the ellipsoid `semi_axes` (mm), turned by `rotation`, about the frame's
    /// origin.
    ///
    /// The ellipsoid is enlarged until it holds every point; it serves to tell pairs apart early.
    ///
    /// # Panics
    /// Without points.
    ///
    /// ```
    /// use meso_collision::{gjk::Body, math::{Mat3, Vec3}};
    /// let corners = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()];
    /// let body = Body::on_ellipsoid(&corners, &Vec3::repeat(1.0), &Mat3::identity());
    /// assert!(!body.overlaps(&body, &Vec3::new(2.1, 0.0, 0.0)));
    /// ```
    pub fn on_ellipsoid(points: &[Vec3], semi_axes: &Vec3, rotation: &Mat3) -> Self {
        let squares = Mat3::from_diagonal(&semi_axes.component_mul(semi_axes));
        Self::bounded(points, Ellipsoids::around(points, &(rotation * squares * rotation.transpose())))
    }

    /// Adds the inner bounds that the faces of `solid` prove; this body has its vertices.
    ///
    /// Pairs that overlap deeply are then decided without looking at a vertex.
    ///
    /// ```
    /// use meso_collision::{geometry::convex_hull, gjk::Body, math::Vec3};
    /// let corners = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()];
    /// let solid = convex_hull(&corners)?;
    /// let body = Body::new(solid.vertices()).with_inside_of(&solid);
    /// assert!(body.inradius() > 0.57 && body.circumradius() >= 1.0);
    /// # Ok::<(), meso_collision::geometry::HullError>(())
    /// ```
    #[must_use]
    pub fn with_inside_of(self, solid: &Polyhedron) -> Self {
        self.with_facets(solid.facets())
    }

    /// Adds inner bounds like [`with_inside_of`](Self::with_inside_of), from the solid's facets.
    pub(crate) fn with_facets(mut self, facets: impl IntoIterator<Item = Facet>) -> Self {
        self.bounds.measure_inside(facets);
        self.note_narrow();
        self
    }

    /// The body without its bounds, for a single query.
    pub(crate) fn bare(points: impl ExactSizeIterator<Item = Vec3>) -> Self {
        let (narrow, first) = (Group([[0.0; GROUP]; 3]), Group([[0.0; GROUP]; 3]));
        let mut body = Self { bounds: Ellipsoids::unknown(), len: 0, is_narrow: false, rest: None, narrow, first };
        body.fill(points);
        body
    }

    fn bounded(points: &[Vec3], bounds: Ellipsoids) -> Self {
        assert!(!points.is_empty(), "a body needs at least one point");
        let mut body = Self { bounds, ..Self::bare(points.iter().copied()) };
        for (narrow, first) in body.narrow.0.iter_mut().zip(&body.first.0) {
            *narrow = first.map(|x| x as f32);
        }
        body
    }

    /// Makes the points in f64 of those in f32: see [`Bounds::lay_out`].
    pub(crate) fn widen(&mut self) {
        if self.is_one_group() {
            widest(Widened(&self.narrow, &mut self.first));
        }
    }

    /// All points in f32, of a body that a search in single precision can work on: of one group, known to hold its
    /// frame's origin, and of a size whose cube that precision holds.
    #[inline(always)]
    pub(crate) fn narrow(&self) -> Option<&Group<f32>> {
        self.is_narrow.then_some(&self.narrow)
    }

    fn note_narrow(&mut self) {
        let in_range = NARROW_RADII.contains(&self.bounds.circumradius);
        self.is_narrow = self.holds_origin() && self.is_one_group() && in_range;
    }

    /// True for a body that is known to hold its frame's origin.
    #[inline(always)]
    pub(crate) fn holds_origin(&self) -> bool {
        self.bounds.inradius() > 0.0
    }

    /// Stores the points and repeats the first one up to a whole group: padding never changes a support.
    fn fill(&mut self, points: impl ExactSizeIterator<Item = Vec3>) {
        self.len = u32::try_from(points.len()).expect("fewer than 2^32 points");
        let mut rest = vec![self.first; points.len().div_ceil(GROUP).max(1) - 1];
        let slots = GROUP * (1 + rest.len());
        let mut first_point = Vec3::zeros();
        let mut end = 0;
        for (i, p) in points.enumerate() {
            first_point = if i == 0 { p } else { first_point };
            set(&mut self.first, &mut rest, i, &p);
            end = i + 1;
        }
        for i in end..slots {
            set(&mut self.first, &mut rest, i, &first_point);
        }
        self.rest = (!rest.is_empty()).then(|| rest.into_boxed_slice());
    }

    /// The index of the point in slot `i`: padding stands for the first point.
    #[inline(always)]
    pub(crate) fn unpadded(&self, i: u32) -> u32 {
        if i < self.len { i } else { 0 }
    }

    /// The group every body has.
    #[inline(always)]
    pub(crate) fn first_group(&self) -> &Group {
        &self.first
    }

    /// Further groups, of a body with more than 32 points.
    #[inline(always)]
    pub(crate) fn more_groups(&self) -> &[Group] {
        self.rest.as_deref().unwrap_or(&[])
    }

    /// True for a body of at most 32 points.
    #[inline(always)]
    pub(crate) fn is_one_group(&self) -> bool {
        self.rest.is_none()
    }

    /// The point in slot `i`.
    #[inline(always)]
    pub(crate) fn slot(&self, i: usize) -> Vec3 {
        let group = if i < GROUP { &self.first } else { &self.more_groups()[i / GROUP - 1] };
        group.point(i % GROUP)
    }

    /// Its figures beside its points.
    ///
    /// ```
    /// use meso_collision::{gjk::{Body, Bounds}, math::Vec3};
    /// let bounds: Bounds = Body::new(&[Vec3::x(), -Vec3::x()]).bounds();
    /// ```
    pub fn bounds(&self) -> Bounds {
        Bounds(self.bounds)
    }

    /// Radius of the sphere about the frame's origin that holds the body, mm.
    ///
    /// ```
    /// use meso_collision::{gjk::Body, math::Vec3};
    /// let reach = Body::new(&[2.0 * Vec3::x(), -Vec3::x()]).circumradius();
    /// assert!((2.0..2.001).contains(&reach));
    /// ```
    pub fn circumradius(&self) -> f64 {
        self.bounds.circumradius
    }

    /// Radius of a sphere about the frame's origin that lies in the body, mm; 0 where none is known.
    ///
    /// ```
    /// use meso_collision::{gjk::Body, math::Vec3};
    /// assert_eq!(Body::new(&[Vec3::x(), -Vec3::x()]).inradius(), 0.0);
    /// ```
    pub fn inradius(&self) -> f64 {
        f64::from(self.bounds.inradius()).max(0.0)
    }
}

#[inline(always)]
fn set(first: &mut Group, rest: &mut [Group], i: usize, p: &Vec3) {
    let Group(axes) = if i < GROUP { first } else { &mut rest[i / GROUP - 1] };
    for (axis, value) in axes.iter_mut().zip(p.iter()) {
        axis[i % GROUP] = *value;
    }
}

impl Support for Body {
    fn len(&self) -> usize {
        self.len as usize
    }

    fn point(&self, i: usize) -> Vec3 {
        self.slot(i)
    }
}
