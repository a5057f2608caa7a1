//! Two [`Body`]s and a displacement: from the cheapest test that decides to the one that always does.
//!
//! Bounding spheres, then ellipsoids (two cache lines, no vertex), then GJK with certificates, then exact arithmetic.

use crate::geometry::CompactPolyhedron;
use crate::gjk::body::{Body, Bounds};
use crate::gjk::method::Algorithm;
use crate::gjk::pair::{Found, GroupPair, Pair, View};
use crate::gjk::prove::ellipsoid::{Ellipsoids, Known};
use crate::gjk::prove::exact::ExactPair;
use crate::gjk::prove::gauge::Solid;
use crate::gjk::search::classical::Classical;
use crate::gjk::search::enhanced::Enhanced;
use crate::gjk::search::mpr::{self, Portal, Refined};
use crate::gjk::search::simplex::Corners;
use crate::math::Vec3;
use crate::simd::{Simd, Vectorized, dispatch};
use nalgebra::Vector3;

/// Sizes of a pair, mm, below which its products of lengths do not overflow in single precision.
pub(crate) const NARROW_REACH: f64 = 1e6;

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

impl Body {
    /// True when the bodies share a point; `b_from_a` is the displacement that brings B's points into this one's frame,
    /// mm.
    ///
    /// The answer is exact for the points and the displacement as given.
    ///
    /// ```
    /// use meso_collision::{gjk::Body, math::Vec3};
    /// let octahedron = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
    /// assert!(octahedron.overlaps(&octahedron, &Vec3::new(2.0, 0.0, 0.0)));
    /// assert!(!octahedron.overlaps(&octahedron, &Vec3::new(2.0, 1e-300, 0.0)));
    /// ```
    #[inline]
    pub fn overlaps(&self, b: &Self, b_from_a: &Vec3) -> bool {
        Counters::default().overlap(self, b, b_from_a)
    }

    /// A unit axis towards B along which the bodies are more than `gap` (mm, at least 0) apart, or `None` when they are
    /// not.
    ///
    /// `Some` exactly when the distance of the bodies is more than `gap`, for the points and the displacement as given.
    /// The support gap along the axis is then proved to be more than `gap`, unless the two differ by less than about
    /// 1e-14 of the bodies' size: there, exact arithmetic decided, and the axis is the exact one rounded.
    ///
    /// `start` is a guess of the axis, such as the one found last time; a good one makes the answer cheap.
    ///
    /// ```
    /// use meso_collision::{gjk::Body, math::Vec3};
    /// let octahedron = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
    /// let axis = |gap: f64| octahedron.separating_axis(&octahedron, &Vec3::new(2.5, 0.0, 0.0), gap, None);
    /// assert!(axis(0.25).unwrap().x > 0.5);
    /// assert!(axis(0.5).is_none());
    /// ```
    #[inline]
    pub fn separating_axis(&self, b: &Self, b_from_a: &Vec3, gap: f64, start: Option<Vec3>) -> Option<Vec3> {
        Counters::default().apart(self, b, b_from_a, gap, start)
    }
}

impl Algorithm {
    /// [`Body::overlaps`] by this search from the first step, without the spheres and ellipsoids: for comparisons.
    ///
    /// ```
    /// use meso_collision::{gjk::{Algorithm, Body}, math::Vec3};
    /// let octahedron = Body::new(&[Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()]);
    /// for method in Algorithm::ALL {
    ///     assert!(method.overlap(&octahedron, &octahedron, &Vec3::new(2.0, 0.0, 0.0)));
    /// }
    /// ```
    pub fn overlap(self, a: &Body, b: &Body, b_from_a: &Vec3) -> bool {
        let query = Query { a, b, x: *b_from_a, gap: 0.0 };
        let v = if *b_from_a == Vec3::zeros() { Vec3::x() } else { *b_from_a };
        match self.search(query.pair(), v) {
            Found::Apart(_) => false,
            Found::Overlap(_) => true,
            Found::Undecided(corners) => query.decide(corners.pairs(), &mut Counters::default()).is_none(),
        }
    }
}

/// True when the bodies are more than `gap` (mm, at least 0) apart, as [`Body::separating_axis`], where B is laid out,
/// in the memory of `made`, only if neither its bounds nor the faces of A tell; counts the stages.
///
/// ```
/// use meso_collision::{geometry::convex_hull, gjk::{apart_from, Body, Counters, Solid}, math::Vec3};
/// let hull = convex_hull(&[Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()])?;
/// let solid = Solid::new(hull.vertices(), &hull.facets());
/// let (bounds, shape) = (solid.body().bounds(), hull.into());
/// let (mut made, mut counters) = (Body::new(&[Vec3::zeros()]), Counters::default());
/// let mut apart = |x| apart_from(&solid, (&bounds, &shape), &mut made, (&Vec3::new(x, 0.0, 0.0), 0.0), &mut counters);
/// assert!(!apart(1.0) && apart(1.0 + f64::EPSILON));
/// # Ok::<(), meso_collision::geometry::HullError>(())
/// ```
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
        counters.count(CascadeStage::Start);
        return false;
    }
    counters.count(CascadeStage::Gjk);
    bounds.lay_out(shape, made);
    let narrow = Query { a: a.body(), b: made, x: *b_from_a, gap }.search_narrow(&v);
    if let Some(apart) = narrow.answer() {
        return apart;
    }
    made.widen();
    Query { a: a.body(), b: made, x: *b_from_a, gap }.settle_from(&v, narrow.portal(), counters)
}

/// The verdict of the headers alone: one cache line each, no vertex.
#[inline(always)]
fn glance(a: &Ellipsoids, b: &Ellipsoids, x: &Vec3, gap: f64) -> (CascadeStage, Known) {
    match a.compare_spheres(b, x, gap) {
        Some(known) => (CascadeStage::Spheres, known),
        None => (CascadeStage::Ellipsoids, a.compare_axis(b, x, gap)),
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
pub(crate) enum CascadeStage {
    Spheres,
    Ellipsoids,
    Start,
    Gjk,
}

impl Counters {
    /// The answer of [`Body::overlaps`]; counts its stages.
    ///
    /// ```
    /// use meso_collision::{gjk::{Body, Counters}, math::Vec3};
    /// let (point, mut counters) = (Body::new(&[Vec3::zeros()]), Counters::default());
    /// assert!(!counters.overlap(&point, &point, &Vec3::x()));
    /// assert_eq!((counters.pairs, counters.after_spheres), (1, 0));
    /// ```
    #[inline]
    pub fn overlap(&mut self, a: &Body, b: &Body, b_from_a: &Vec3) -> bool {
        !Query { a, b, x: *b_from_a, gap: 0.0 }.apart(self)
    }

    /// The answer of [`Body::separating_axis`]; counts its stages.
    ///
    /// ```
    /// use meso_collision::{gjk::{Body, Counters}, math::Vec3};
    /// let (point, mut counters) = (Body::new(&[Vec3::zeros()]), Counters::default());
    /// assert_eq!(counters.apart(&point, &point, &Vec3::x(), 0.5, None), Some(Vec3::x()));
    /// assert_eq!(counters.pairs, 1);
    /// ```
    #[inline]
    pub fn apart(&mut self, a: &Body, b: &Body, b_from_a: &Vec3, gap: f64, start: Option<Vec3>) -> Option<Vec3> {
        Query { a, b, x: *b_from_a, gap }.axis(start, self).map(|v| v.normalize())
    }

    /// Adds the counts of others.
    ///
    /// ```
    /// use meso_collision::gjk::Counters;
    /// let mut all = Counters { pairs: 2, ..Counters::default() };
    /// all.add(&Counters { pairs: 3, ..Counters::default() });
    /// assert_eq!(all.pairs, 5);
    /// ```
    pub fn add(&mut self, other: &Self) {
        self.pairs += other.pairs;
        self.after_spheres += other.after_spheres;
        self.after_ellipsoids += other.after_ellipsoids;
        self.gjk_calls += other.gjk_calls;
        self.exact_calls += other.exact_calls;
    }

    #[inline(always)]
    fn count(&mut self, stage: CascadeStage) {
        self.pairs += 1;
        self.after_spheres += u64::from(stage > CascadeStage::Spheres);
        self.after_ellipsoids += u64::from(stage > CascadeStage::Ellipsoids);
        self.gjk_calls += u64::from(stage == CascadeStage::Gjk);
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
                counters.count(CascadeStage::Gjk);
                self.settle(&v, counters)
            }
        }
    }

    /// The answer of the bounds or of single precision; where they leave it open, that of `open`, from the portal that
    /// the search came to.
    pub(crate) fn apart_or(&self, open: impl FnOnce(Option<Portal>) -> bool) -> bool {
        let known = self.glance().1;
        let Known::Nothing(v) = known else { return matches!(known, Known::Apart(_)) };
        self.apart_from(&v, open)
    }

    /// The answer of single precision, or of `open`, where the bounds left the pair open; `v` is the first direction.
    pub(crate) fn apart_from(&self, v: &Vec3, open: impl FnOnce(Option<Portal>) -> bool) -> bool {
        let narrow = self.search_narrow(v);
        narrow.answer().unwrap_or_else(|| open(narrow.portal()))
    }

    /// The answer by a search from direction `v`, whatever it takes.
    #[inline(never)]
    fn settle(&self, v: &Vec3, counters: &mut Counters) -> bool {
        dispatch(Both { query: self, v }).unwrap_or_else(|| self.settle_from(v, None, counters))
    }

    /// The answer where single precision did not tell; it may have come to a portal.
    #[cold]
    #[inline(never)]
    pub(crate) fn settle_from(&self, v: &Vec3, portal: Option<Portal>, counters: &mut Counters) -> bool {
        match self.search_wide(v, portal) {
            Found::Apart(_) => true,
            Found::Overlap(_) => false,
            Found::Undecided(corners) => self.decide(corners.pairs(), counters).is_some(),
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
            counters.count(CascadeStage::Start);
            return Some(axis);
        }
        counters.count(CascadeStage::Gjk);
        let portal = match self.search_narrow(&v) {
            Refined::Apart(v) => return Some(v.cast()),
            Refined::Overlap(_) => return None,
            Refined::Undecided(portal) => portal,
        };
        match self.search_wide(&v, portal) {
            Found::Apart(v) => Some(v),
            Found::Overlap(_) => None,
            Found::Undecided(corners) => self.decide(corners.pairs(), counters),
        }
    }

    /// The verdict of the headers alone.
    #[inline(always)]
    pub(crate) fn glance(&self) -> (CascadeStage, Known) {
        glance(&self.a.bounds, &self.b.bounds, &self.x, self.gap)
    }

    /// The search in single precision from direction `v`; from one that this rounds to zero it may come back undecided.
    #[inline(always)]
    fn search_narrow(&self, v: &Vec3) -> Refined<f32> {
        match self.narrow_pair() {
            Some(pair) => dispatch(Narrow { pair, v: v.cast(), gap: self.gap as f32 }),
            None => Refined::Undecided(None),
        }
    }

    /// The search in double precision, from a portal where there is one, else from direction `v`.
    ///
    /// This is the one place that chooses it: portals where both bodies hold their frames' origins, and pairs left
    /// undecided go to GJK, which is boolean where there is no gap.
    fn search_wide(&self, v: &Vec3, portal: Option<Portal>) -> Found {
        let (pair, v, gap) = (self.pair(), or_x(v), self.gap);
        if self.a.holds_origin() && self.b.holds_origin() {
            match dispatch(DoublePortal { pair, v, gap, portal }) {
                Refined::Apart(v) => return Found::Apart(v),
                Refined::Overlap(portal) => return Found::Overlap(Corners::of(portal.map(|of| self.unpadded(of)))),
                Refined::Undecided(_) => {}
            }
        }
        if gap == 0.0 { dispatch(Enhanced { pair, v }) } else { dispatch(Classical::beyond(pair, v, gap)) }
    }

    fn unpadded(&self, (a, b): (u32, u32)) -> (u32, u32) {
        (self.a.unpadded(a), self.b.unpadded(b))
    }

    #[inline(always)]
    fn narrow_pair(&self) -> Option<GroupPair<'a, f32>> {
        let (a, b) = (self.a.narrow()?, self.b.narrow()?);
        let reach = self.reach();
        (reach < NARROW_REACH && self.gap < NARROW_REACH).then(|| GroupPair {
            a,
            b,
            x: self.x.cast(),
            reach: reach as f32,
        })
    }

    /// The search in double precision, of bodies of one group.
    #[inline(always)]
    fn group_pair(&self) -> GroupPair<'a, f64> {
        GroupPair { a: self.a.first_group(), b: self.b.first_group(), x: self.x, reach: self.reach() }
    }

    #[inline(always)]
    fn reach(&self) -> f64 {
        self.a.circumradius() + self.b.circumradius() + (self.x.x.abs() + self.x.y.abs() + self.x.z.abs())
    }

    #[inline(always)]
    pub(crate) fn pair(&self) -> Pair<'a> {
        Pair { a: self.a, b: self.b, x: self.x, reach: self.reach(), originals: None }
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

impl Vectorized for Axis<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> bool {
        let pair = self.query.pair();
        let (_, separation) = pair.support(simd, &self.axis);
        separation - self.query.gap * self.axis.norm() > pair.doubt(&self.axis)
    }
}

/// A portal search in single precision.
struct Narrow<'a> {
    pair: GroupPair<'a, f32>,
    v: Vector3<f32>,
    gap: f32,
}

impl Vectorized for Narrow<'_> {
    type Output = Refined<f32>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Refined<f32> {
        mpr::search(self.pair, simd, self.v, self.gap)
    }
}

/// A portal search in single precision, and where that leaves it open in double precision from the portal it came to.
///
/// In one go, since the two answers make one that no branch has to foretell. Two pointers, which travel in registers:
/// the pairs themselves were copied twice, with loads that had to wait for the stores of their parts.
struct Both<'a> {
    query: &'a Query<'a>,
    v: &'a Vec3,
}

impl Vectorized for Both<'_> {
    type Output = Option<bool>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Option<bool> {
        let Self { query, v } = self;
        let (narrow, gap) = (query.narrow_pair()?, query.gap);
        match mpr::search(narrow, simd, v.cast(), gap as f32) {
            Refined::Undecided(Some(portal)) => mpr::resume(query.group_pair(), simd, portal, gap)?.answer(),
            refined => refined.answer(),
        }
    }
}

/// A portal search in double precision, from the portal that single precision came to where that is one.
struct DoublePortal<'a> {
    pair: Pair<'a>,
    v: Vec3,
    gap: f64,
    portal: Option<Portal>,
}

impl Vectorized for DoublePortal<'_> {
    type Output = Refined<f64>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Refined<f64> {
        let Self { pair, v, gap, portal } = self;
        if let Some(portal) = portal
            && let Some(refined) = mpr::resume(pair, simd, portal, gap)
        {
            return refined;
        }
        mpr::search(pair, simd, v, gap)
    }
}

/// A direction to start from.
#[inline(always)]
fn or_x(v: &Vec3) -> Vec3 {
    if *v == Vec3::zeros() { Vec3::x() } else { *v }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex_hull;

    /// From -1 to 1 (D. E. Knuth's MMIX generator).
    struct Dice(u64);

    impl Dice {
        fn roll(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self) -> Vec3 {
            Vec3::from_fn(|_, _| self.roll())
        }

        /// A solid of 24 points about its frame's origin, which it is known to hold.
        fn body(&mut self) -> Body {
            let axes = Vec3::from_fn(|_, _| 1.0 + 0.4 * self.roll());
            let points: Vec<Vec3> = (0..24).map(|_| self.vector().normalize().component_mul(&axes)).collect();
            Body::new(&points).with_inside_of(&convex_hull(&points).unwrap())
        }
    }

    #[test]
    fn portals_settle_ordinary_pairs_in_either_precision_whatever_triangle_they_begin_with() {
        let (mut dice, mut overlaps, mut narrow, mut wide) = (Dice(1), 0, 0, 0);
        for _ in 0..500 {
            let (a, b, x) = (dice.body(), dice.body(), dice.vector() * 2.0);
            assert!(a.holds_origin() && b.holds_origin());
            let query = Query { a: &a, b: &b, x, gap: 0.0 };
            let truth = query.decide(&[], &mut Counters::default()).is_some();
            let found = query.search_narrow(&x).answer();
            assert!(found.is_none_or(|apart| apart == truth));
            narrow += u32::from(found.is_none());
            let slot = |dice: &mut Dice| (12.0 + 12.0 * dice.roll()) as u32;
            let portal: Portal = [0; 3].map(|_| (slot(&mut dice), slot(&mut dice)));
            for portal in [None, Some(portal)] {
                let found = dispatch(DoublePortal { pair: query.pair(), v: x, gap: 0.0, portal }).answer();
                assert!(found.is_none_or(|apart| apart == truth));
                wide += u32::from(found.is_none());
            }
            overlaps += u32::from(!truth);
        }
        assert!((100..400).contains(&overlaps), "{overlaps}");
        assert!(narrow < 5 && wide == 0, "{narrow} and {wide} were left open");
    }

    #[test]
    fn a_direction_that_single_precision_rounds_to_zero_misleads_no_search() {
        let (mut dice, mut open) = (Dice(2), 0);
        for _ in 0..100 {
            let (a, b, x) = (dice.body(), dice.body(), dice.vector() * 2.0);
            let query = Query { a: &a, b: &b, x, gap: 0.0 };
            let truth = query.decide(&[], &mut Counters::default()).is_some();
            assert!(query.narrow_pair().is_some());
            for v in [Vec3::zeros(), 1e-60 * x] {
                let found = query.search_narrow(&v).answer();
                assert!(found.is_none_or(|apart| apart == truth));
                open += u32::from(found.is_none());
            }
        }
        assert!((20..200).contains(&open), "{open} of 200 were left open");
    }
}
