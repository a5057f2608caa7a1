//! A pair of bodies and a displacement: its supports, and the result of a search.

use crate::gjk::body::{Body, Group};
use crate::gjk::prove::certificate::{self, Difference};
use crate::gjk::search::kernel::{self, Extremes, Real};
use crate::gjk::search::simplex::{Corners, Simplex, Vertex};
use crate::gjk::support::Support;
use crate::math::Vec3;
use crate::simd::Simd;
use nalgebra::Vector3;
use num_traits::Signed;

/// The result of a search in floating point.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Found {
    /// Proved apart along this direction, from A to B.
    Apart(Vec3),
    /// Proved to share a point: the origin lies in this tetrahedron. Where a gap was asked for: proved not that far
    /// apart. Where the frames' origins or the ellipsoids prove it, corners are missing.
    Overlap(Corners),
    /// Not proved; this is where the search ended.
    Undecided(Corners),
}

/// A pair of bodies, B displaced by `x` from where its points are.
#[derive(Clone, Copy)]
pub(crate) struct Pair<'a> {
    pub(crate) a: &'a Body,
    pub(crate) b: &'a Body,
    pub(crate) x: Vec3,
    /// At least the largest distance of any point, and of B's displacement, from the origin, summed.
    pub(crate) reach: f64,
    /// The points before they were shifted and scaled, where they were.
    pub(crate) originals: Option<&'a Originals<'a>>,
}

/// Points as they were given, whose differences are rounded once only.
#[derive(Clone, Copy)]
pub(crate) struct Originals<'a> {
    pub(crate) a: &'a [Vec3],
    pub(crate) b: &'a [Vec3],
    /// B's displacement, in their units.
    pub(crate) x: Vec3,
    /// A power of two.
    pub(crate) scale: f64,
}

/// A pair in the numbers of one precision, for searches that are the same in both.
pub(crate) trait View: Copy {
    /// f64 or f32.
    type T: Real;
    /// B's displacement.
    fn displacement(&self) -> Vector3<Self::T>;
    /// See [`Pair::reach`].
    fn reach(&self) -> Self::T;
    /// The farthest point of A along `v` and the nearest of B, which is not displaced.
    fn extremes<S: Simd>(&self, simd: S, v: &Vector3<Self::T>) -> Extremes<Self::T>;
    /// The point of A in the one slot less that of B in the other, which is not displaced.
    fn undisplaced(&self, of: (u32, u32)) -> Vector3<Self::T>;

    /// By how much `v` separates the bodies whose extremes along it these are, times |v|; negative: not at all.
    #[inline(always)]
    fn separation(&self, v: &Vector3<Self::T>, extremes: &Extremes<Self::T>) -> Self::T {
        extremes.bottom_of_b + self.displacement().dot(v) - extremes.top_of_a
    }

    /// The support of A - B along `v`, and the separation.
    #[inline(always)]
    fn support<S: Simd>(&self, simd: S, v: &Vector3<Self::T>) -> (Vertex<Self::T>, Self::T) {
        let extremes = self.extremes(simd, v);
        let of = (extremes.a, extremes.b);
        (Vertex { w: self.undisplaced(of) - self.displacement(), of }, self.separation(v, &extremes))
    }

    /// The most that rounding can add to the separation along `v`.
    #[inline(always)]
    fn doubt(&self, v: &Vector3<Self::T>) -> Self::T {
        Self::T::HEIGHT_ERROR * (v.x.abs() + v.y.abs() + v.z.abs()) * self.reach() + Self::T::TINY
    }
}

impl View for Pair<'_> {
    type T = f64;

    #[inline(always)]
    fn displacement(&self) -> Vec3 {
        self.x
    }

    #[inline(always)]
    fn reach(&self) -> f64 {
        self.reach
    }

    #[inline(always)]
    fn extremes<S: Simd>(&self, simd: S, v: &Vec3) -> Extremes<f64> {
        kernel::extremes(simd, self.a, self.b, v)
    }

    #[inline(always)]
    fn undisplaced(&self, of: (u32, u32)) -> Vec3 {
        self.a.slot(of.0 as usize) - self.b.slot(of.1 as usize)
    }
}

impl Pair<'_> {
    /// The vertex of A - B made of the points in these slots.
    pub(crate) fn vertex(&self, of: (u32, u32)) -> Vertex {
        Vertex { w: self.undisplaced(of) - self.x, of }
    }

    /// The pairs of points that make up these vertices.
    #[inline(always)]
    pub(crate) fn corners(&self, simplex: &Simplex) -> Corners {
        simplex.corners(|of| (self.a.unpadded(of.0), self.b.unpadded(of.1)))
    }

    /// True when the tetrahedron of these vertices is proved to hold the origin.
    #[inline(always)]
    pub(crate) fn encloses_origin(&self, vertices: &[Vertex; 4]) -> bool {
        certificate::encloses_origin_roughly(&vertices.map(|v| v.w), self.reach)
            || certificate::encloses_origin(&vertices.map(|v| self.difference(v.of)))
    }

    /// The vertex from the points as they were given, with bounds of its error.
    fn difference(&self, of: (u32, u32)) -> Difference {
        let (a, b) = (self.a.unpadded(of.0) as usize, self.b.unpadded(of.1) as usize);
        match self.originals {
            Some(Originals { a: from_a, b: from_b, x, scale }) => {
                let Difference { w, magnitude } = Difference::new(&from_a[a], &from_b[b], x);
                Difference { w: w * *scale, magnitude: magnitude * *scale }
            }
            None => Difference::new(&self.a.point(a), &self.b.point(b), &self.x),
        }
    }
}

/// A pair of one group each: in single precision, points and displacement are rounded once.
#[derive(Clone, Copy)]
pub(crate) struct GroupPair<'a, T> {
    pub(crate) a: &'a Group<T>,
    pub(crate) b: &'a Group<T>,
    pub(crate) x: Vector3<T>,
    pub(crate) reach: T,
}

impl<T: Real> View for GroupPair<'_, T> {
    type T = T;

    #[inline(always)]
    fn displacement(&self) -> Vector3<T> {
        self.x
    }

    #[inline(always)]
    fn reach(&self) -> T {
        self.reach
    }

    #[inline(always)]
    fn extremes<S: Simd>(&self, simd: S, v: &Vector3<T>) -> Extremes<T> {
        kernel::extremes_of_groups(simd, self.a, self.b, v)
    }

    #[inline(always)]
    fn undisplaced(&self, of: (u32, u32)) -> Vector3<T> {
        self.a.point(of.0 as usize) - self.b.point(of.1 as usize)
    }
}
