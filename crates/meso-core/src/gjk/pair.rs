//! Two [`Body`]s and a displacement: from the cheapest test that decides to the one that always does.
//!
//! Bounding spheres, then ellipsoids (two cache lines, no vertex), then GJK with certificates, then exact arithmetic.

use super::body::Body;
use super::classical::{Classical, Until};
use super::ellipsoid::Hint;
use super::enhanced::{Enhanced, Found, Pair};
use super::exact::ExactPair;
use super::nearest::SubAlgorithm;
use super::simd::{Kernel, Search, dispatch};
use super::simplex::Simplex;
use crate::math::Vec3;

/// How many pairs each stage was left with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Pairs asked about.
    pub pairs: u64,
    /// Pairs left after the bounding and inscribed spheres.
    pub after_spheres: u64,
    /// Pairs left after the ellipsoids.
    pub after_ellipsoids: u64,
    /// Pairs put to GJK: those that a remembered axis did not decide.
    pub gjk_calls: u64,
    /// Pairs put to exact arithmetic.
    pub exact_calls: u64,
}

/// True when the bodies share a point; `b_from_a` is what to add to B's points to have them in A's frame, mm.
///
/// The answer is exact for the points and the displacement as given.
///
/// ```
/// use meso_core::{gjk::{Body, overlap}, math::Vec3};
/// let octahedron = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
/// assert!(overlap(&octahedron, &octahedron, &Vec3::new(2.0, 0.0, 0.0)));
/// assert!(!overlap(&octahedron, &octahedron, &Vec3::new(2.0, 1e-300, 0.0)));
/// ```
#[inline]
pub fn overlap(a: &Body, b: &Body, b_from_a: &Vec3) -> bool {
    overlap_counted(a, b, b_from_a, &mut Counters::default())
}

/// [`overlap`], counting what it took.
#[inline]
pub fn overlap_counted(a: &Body, b: &Body, b_from_a: &Vec3, counters: &mut Counters) -> bool {
    let query = Query { a, b, x: *b_from_a, gap: 0.0 };
    match query.compare(counters) {
        Hint::Apart(_) => false,
        Hint::Overlap => true,
        Hint::Unsure(v) => query.search(v, counters).is_none(),
    }
}

/// A unit axis from A to B along which the bodies are more than `gap` (mm) apart, or `None` when they are not.
///
/// `Some` exactly when the distance of the bodies is more than `gap`, for the points and the displacement as given. The
/// support gap along the axis is then proved to be more than `gap`, unless the two differ by less than about 1e-14 of
/// the bodies' size: there, exact arithmetic decided, and the axis is the exact one rounded.
///
/// `start` is a guess of the axis, such as the one found last time; a good one makes the answer cheap.
///
/// ```
/// use meso_core::{gjk::{Body, apart}, math::Vec3};
/// let octahedron = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
/// let axis = apart(&octahedron, &octahedron, &Vec3::new(2.5, 0.0, 0.0), 0.25, None).unwrap();
/// assert!(axis.x > 0.5);
/// assert!(apart(&octahedron, &octahedron, &Vec3::new(2.5, 0.0, 0.0), 0.5, None).is_none());
/// ```
#[inline]
pub fn apart(a: &Body, b: &Body, b_from_a: &Vec3, gap: f64, start: Option<Vec3>) -> Option<Vec3> {
    apart_counted(a, b, b_from_a, gap, start, &mut Counters::default())
}

/// [`apart`], counting what it took.
#[inline]
pub fn apart_counted(
    a: &Body,
    b: &Body,
    b_from_a: &Vec3,
    gap: f64,
    start: Option<Vec3>,
    counters: &mut Counters,
) -> Option<Vec3> {
    let query = Query { a, b, x: *b_from_a, gap };
    let v = match query.compare(counters) {
        Hint::Apart(n) => return Some(n.normalize()),
        Hint::Overlap => return None,
        Hint::Unsure(v) => v,
    };
    if let Some(axis) = start
        && query.separated_along(&axis)
    {
        return Some(axis.normalize());
    }
    query.search(v, counters).map(|v| v.normalize())
}

/// Are the bodies more than `gap` apart?
#[derive(Clone, Copy)]
struct Query<'a> {
    a: &'a Body,
    b: &'a Body,
    x: Vec3,
    gap: f64,
}

impl<'a> Query<'a> {
    /// The stages that look at no vertex.
    #[inline(always)]
    fn compare(&self, counters: &mut Counters) -> Hint {
        counters.pairs += 1;
        let (a, b) = (&self.a.bounds, &self.b.bounds);
        if let Some(decided) = a.compare_spheres(b, &self.x, self.gap) {
            return decided;
        }
        counters.after_spheres += 1;
        let hint = a.compare_axis(b, &self.x, self.gap);
        counters.after_ellipsoids += u64::from(matches!(hint, Hint::Unsure(_)));
        hint
    }

    #[inline(always)]
    fn pair(&self) -> Pair<'a> {
        let norm1 = self.x.x.abs() + self.x.y.abs() + self.x.z.abs();
        Pair {
            a: self.a,
            b: self.b,
            x: self.x,
            reach: self.a.circumradius() + self.b.circumradius() + norm1,
            originals: None,
        }
    }

    fn separated_along(&self, axis: &Vec3) -> bool {
        dispatch(Along { pair: self.pair(), v: *axis, gap: self.gap })
    }

    /// GJK, then exact arithmetic: the axis, not of unit length.
    #[inline]
    fn search(&self, v: Vec3, counters: &mut Counters) -> Option<Vec3> {
        counters.gjk_calls += 1;
        let v = if v == Vec3::zeros() { Vec3::x() } else { v };
        let found = if self.gap == 0.0 {
            dispatch(Enhanced { pair: self.pair(), v })
        } else {
            let (sub_algorithm, until) = (SubAlgorithm::SignedVolumes, Until::Apart(self.gap));
            dispatch(Classical { pair: self.pair(), v, sub_algorithm, until })
        };
        match found {
            Found::Apart(v) => Some(v),
            Found::Overlap(_) => None,
            Found::Doubt(simplex) => self.decide(&simplex, counters),
        }
    }

    #[cold]
    #[inline(never)]
    fn decide(&self, start: &Simplex, counters: &mut Counters) -> Option<Vec3> {
        counters.exact_calls += 1;
        let exact = ExactPair::new(self.a, self.b, &self.x);
        if self.gap == 0.0 {
            return exact.decide(&start.pairs()).direction();
        }
        let (distance2, direction) = exact.squared_distance(&start.pairs());
        distance2.exceeds(self.gap).then(|| direction.direction())
    }
}

/// Does `v` separate the pair by more than `gap`?
#[derive(Clone, Copy)]
struct Along<'a> {
    pair: Pair<'a>,
    v: Vec3,
    gap: f64,
}

impl Search for Along<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> bool {
        let (_, separation) = self.pair.support(kernel, &self.v);
        separation - self.gap * self.v.norm() > self.pair.doubt(&self.v)
    }
}
