//! Two [`Body`]s and a displacement: from the cheapest test that decides to the one that always does.
//!
//! Bounding spheres, then ellipsoids (two cache lines, no vertex), then GJK with certificates, then exact arithmetic.

use super::body::{Body, Bounds};
use super::classical::Classical;
use super::ellipsoid::{Ellipsoids, Known};
use super::enhanced::{Enhanced, Found, Pair};
use super::exact::ExactPair;
use super::gauge::Solid;
use super::portal::Portal;
use super::query::Method;
use super::simd::{Kernel, Search, dispatch};
use crate::geometry::CompactPolyhedron;
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
    /// Pairs put to GJK: those that neither a remembered axis nor a point inside the other's faces decided.
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
    !Query { a, b, x: *b_from_a, gap: 0.0 }.apart(counters)
}

/// [`overlap`] by a chosen search from the first step, without the spheres and ellipsoids: for comparisons.
pub fn overlap_with(method: Method, a: &Body, b: &Body, b_from_a: &Vec3) -> bool {
    let query = Query { a, b, x: *b_from_a, gap: 0.0 };
    let v = if *b_from_a == Vec3::zeros() { Vec3::x() } else { *b_from_a };
    match method.search(query.pair(), v) {
        Found::Apart(_) => false,
        Found::Overlap(_) => true,
        Found::Doubt(corners) => query.decide(corners.pairs(), &mut Counters::default()).is_none(),
    }
}

/// A unit axis from A to B along which the bodies are more than `gap` (mm, at least 0) apart, or `None` when they are not.
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
    Query { a, b, x: *b_from_a, gap }.axis(start, counters).map(|v| v.normalize())
}

/// True when the bodies are more than `gap` (mm, at least 0) apart, as [`apart`], where B is laid out, in the memory of
/// `made`, only if neither its bounds nor the faces of A tell; counts what it took.
#[inline]
pub fn apart_from(
    a: &Solid,
    b: (&Bounds, &CompactPolyhedron),
    made: &mut Body,
    (b_from_a, gap): (&Vec3, f64),
    counters: &mut Counters,
) -> bool {
    let (bounds, shape) = b;
    let (stage, known) = glance(&a.body().bounds, &bounds.0, b_from_a, gap);
    let Known::Nothing(v) = known else {
        counters.count(stage);
        return matches!(known, Known::Apart(_));
    };
    if a.meets(b, &v, b_from_a) {
        counters.count(Stage::Start);
        return false;
    }
    counters.count(Stage::Gjk);
    Query { a: a.body(), b: bounds.lay_out(shape, made), x: *b_from_a, gap }.settle(&v, counters)
}

/// What the headers tell: one cache line each, no vertex.
#[inline(always)]
fn glance(a: &Ellipsoids, b: &Ellipsoids, x: &Vec3, gap: f64) -> (Stage, Known) {
    match a.compare_spheres(b, x, gap) {
        Some(known) => (Stage::Spheres, known),
        None => (Stage::Ellipsoids, a.compare_axis(b, x, gap)),
    }
}

/// Are the bodies more than `gap` apart?
#[derive(Clone, Copy)]
pub(crate) struct Query<'a> {
    pub(crate) a: &'a Body,
    pub(crate) b: &'a Body,
    pub(crate) x: Vec3,
    pub(crate) gap: f64,
}

/// How far a query had to go.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
pub(crate) enum Stage {
    Spheres,
    Ellipsoids,
    Start,
    Gjk,
}

impl Counters {
    /// Adds what others have counted.
    pub fn add(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.after_spheres += other.after_spheres;
        self.after_ellipsoids += other.after_ellipsoids;
        self.gjk_calls += other.gjk_calls;
        self.exact_calls += other.exact_calls;
    }

    #[inline(always)]
    fn count(&mut self, stage: Stage) {
        self.pairs += 1;
        self.after_spheres += u64::from(stage > Stage::Spheres);
        self.after_ellipsoids += u64::from(stage > Stage::Ellipsoids);
        self.gjk_calls += u64::from(stage == Stage::Gjk);
    }
}

impl<'a> Query<'a> {
    /// The answer alone; the headers are looked at in the caller's own code, where they cost least.
    #[inline(always)]
    pub(crate) fn apart(&self, counters: &mut Counters) -> bool {
        let (stage, known) = self.glance();
        match known {
            Known::Apart(_) | Known::Overlap => {
                counters.count(stage);
                matches!(known, Known::Apart(_))
            }
            Known::Nothing(v) => {
                counters.count(Stage::Gjk);
                self.settle(&v, counters)
            }
        }
    }

    /// The answer by a search from direction `v`, whatever it takes.
    #[inline(never)]
    pub(crate) fn settle(&self, v: &Vec3, counters: &mut Counters) -> bool {
        match self.search(v) {
            Found::Apart(_) => true,
            Found::Overlap(_) => false,
            Found::Doubt(corners) => self.decide(corners.pairs(), counters).is_some(),
        }
    }

    /// The axis, not of unit length.
    fn axis(&self, start: Option<Vec3>, counters: &mut Counters) -> Option<Vec3> {
        let (stage, known) = self.glance();
        let v = match known {
            Known::Nothing(v) => v,
            Known::Apart(v) => {
                counters.count(stage);
                return Some(v);
            }
            Known::Overlap => {
                counters.count(stage);
                return None;
            }
        };
        if let Some(axis) = start.filter(|&axis| dispatch(Axis { query: *self, axis })) {
            counters.count(Stage::Start);
            return Some(axis);
        }
        counters.count(Stage::Gjk);
        match self.search(&v) {
            Found::Apart(v) => Some(v),
            Found::Overlap(_) => None,
            Found::Doubt(corners) => self.decide(corners.pairs(), counters),
        }
    }

    /// What the headers tell.
    #[inline(always)]
    pub(crate) fn glance(&self) -> (Stage, Known) {
        glance(&self.a.bounds, &self.b.bounds, &self.x, self.gap)
    }

    /// The search in floating point from direction `v`.
    #[inline(always)]
    fn search(&self, v: &Vec3) -> Found {
        let (pair, gap) = (self.pair(), self.gap);
        let v = if *v == Vec3::zeros() { Vec3::x() } else { *v };
        if self.a.bounds.inradius > 0.0 && self.b.bounds.inradius > 0.0 {
            dispatch(Portal { pair, v, gap })
        } else if gap == 0.0 {
            dispatch(Enhanced { pair, v })
        } else {
            dispatch(Classical::beyond(pair, v, gap))
        }
    }

    #[inline(always)]
    fn pair(&self) -> Pair<'a> {
        let norm1 = self.x.x.abs() + self.x.y.abs() + self.x.z.abs();
        let reach = self.a.circumradius() + self.b.circumradius() + norm1;
        Pair { a: self.a, b: self.b, x: self.x, reach, originals: None }
    }

    #[cold]
    #[inline(never)]
    fn decide(&self, start: &[(u32, u32)], counters: &mut Counters) -> Option<Vec3> {
        counters.exact_calls += 1;
        let exact = ExactPair::new(self.a, self.b, &self.x);
        if self.gap == 0.0 {
            return exact.decide(start).direction();
        }
        let (distance2, direction) = exact.squared_distance(start);
        distance2.exceeds(self.gap).then(|| direction.direction())
    }
}

/// Does this axis prove the bodies of the query apart?
#[derive(Clone, Copy)]
struct Axis<'a> {
    query: Query<'a>,
    axis: Vec3,
}

impl Search for Axis<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> bool {
        let pair = self.query.pair();
        let (_, separation) = pair.support(kernel, &self.axis);
        separation - self.query.gap * self.axis.norm() > pair.doubt(&self.axis)
    }
}
