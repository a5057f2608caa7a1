//! Minkowski portal refinement: a yes or no for bodies that are known to hold their frames' origins.
//!
//! Snethen, XenonCollide, Game Programming Gems 7 (2008), with certificates. The displacement of the frames gives a point
//! v0 inside A - B for nothing. A portal is a triangle v1 v2 v3 of points of A - B that the ray from v0 through the
//! origin passes; supports along its outward normal push it out until the origin is inside the tetrahedron v0 v1 v2 v3,
//! or a support does not reach the origin. Per step this takes half the arithmetic of a simplex update, and no division.

use super::certificate;
use super::classical::Classical;
use super::enhanced::{Enhanced, Found, Pair};
use super::simd::{Kernel, Search, dispatch};
use super::simplex::{Corners, Simplex, Vertex};
use crate::math::Vec3;

/// Steps after which the search is left to [`Enhanced`]; 4 is the average for bodies of 20 to 30 points.
const MAX_STEPS: usize = 32;

/// How far a direction is turned that failed: 1 makes it perpendicular to the point in its way, 2 reflects it (Chung and
/// Wang, 1996). Between them lies what tells most pairs apart with the second support; from 1.1 to 2 it is all the same.
pub(crate) const TURN: f64 = 1.5;

/// The search from direction `v`; both bodies must hold the origins of their frames.
#[derive(Clone, Copy)]
pub(crate) struct Portal<'a> {
    pub(crate) pair: Pair<'a>,
    pub(crate) v: Vec3,
    /// Bodies that are not more than this apart may be told to be in doubt, mm.
    pub(crate) gap: f64,
}

impl Search for Portal<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Found {
        match self.refine(kernel) {
            Found::Doubt(_) => undecided(self),
            found => found,
        }
    }
}

#[cold]
#[inline(never)]
fn undecided(Portal { pair, v, gap }: Portal<'_>) -> Found {
    if gap == 0.0 { dispatch(Enhanced { pair, v }) } else { dispatch(Classical::beyond(pair, v, gap)) }
}

/// The support of `$pair` along `$v`, unless it tells the bodies apart.
macro_rules! support {
    ($pair:ident, $kernel:ident, $gap:ident, $v:expr) => {{
        let v = $v;
        let (w, separation) = $pair.support($kernel, &v);
        if separation > 0.0 {
            return apart_or_doubt(&$pair, &v, separation, $gap);
        }
        w
    }};
}

impl Portal<'_> {
    #[inline(always)]
    fn refine<K: Kernel>(&self, kernel: K) -> Found {
        let Self { pair, v, gap } = *self;
        let v0 = -pair.x;
        let mut v1 = support!(pair, kernel, gap, v);
        let mut v2 = support!(pair, kernel, gap, turned_away(&v, &v1.w));
        // Perpendicular to the plane of v0, v1, v2, on the origin's side of it.
        let mut normal = (v1.w - v0).cross(&(v2.w - v0));
        if normal.dot(&v0) > 0.0 {
            (v1, v2, normal) = (v2, v1, -normal);
        }
        let mut v3 = support!(pair, kernel, gap, normal);
        for _ in 0..MAX_STEPS {
            // Discovery: the ray must pass inside of the planes v0 v2 v3 and v0 v3 v1.
            let across = v0.cross(&v3.w);
            if v1.w.dot(&across) > 0.0 {
                v2 = v3;
            } else if v2.w.dot(&across) < 0.0 {
                v1 = v3;
            } else {
                break;
            }
            v3 = support!(pair, kernel, gap, (v1.w - v0).cross(&(v2.w - v0)));
        }
        for _ in 0..MAX_STEPS {
            let outward = (v2.w - v1.w).cross(&(v3.w - v1.w));
            if outward.dot(&v1.w) > 0.0 {
                return enclosed(&pair, &v0, [v1, v2, v3]);
            }
            let v4 = support!(pair, kernel, gap, outward);
            if (v4.w - v1.w).dot(&outward) <= 0.0 {
                break;
            }
            replace(&v0, v4, [&mut v1, &mut v2, &mut v3]);
        }
        Found::Doubt(Corners::NONE)
    }
}

/// The direction `v` turned away from `w`, the point that keeps it from telling the bodies apart.
#[inline(always)]
fn turned_away(v: &Vec3, w: &Vec3) -> Vec3 {
    v - w * (TURN * v.dot(w) / w.norm_squared())
}

/// The bodies are apart along `v`: by more than the gap, certainly?
#[inline(always)]
fn apart_or_doubt(pair: &Pair<'_>, v: &Vec3, separation: f64, gap: f64) -> Found {
    let beyond = if gap == 0.0 { separation } else { separation - gap * v.norm() };
    if beyond > pair.doubt(v) { Found::Apart(*v) } else { Found::Doubt(Corners::NONE) }
}

/// Replaces the corner of the portal that the ray leaves behind when `v4` is added.
#[inline(always)]
fn replace(v0: &Vec3, v4: Vertex, [v1, v2, v3]: [&mut Vertex; 3]) {
    let across = v4.w.cross(v0);
    let [e1, e2, e3] = [v1.w.dot(&across), v2.w.dot(&across), v3.w.dot(&across)];
    if e1 > 0.0 && e2 <= 0.0 {
        *v3 = v4;
    } else if e2 > 0.0 && e3 <= 0.0 {
        *v1 = v4;
    } else {
        *v2 = v4;
    }
}

#[inline(always)]
fn enclosed(pair: &Pair<'_>, v0: &Vec3, portal: [Vertex; 3]) -> Found {
    let [p1, p2, p3] = portal.map(|v| v.w);
    let certain = certificate::encloses_origin_roughly(&[*v0, p1, p2, p3], pair.reach);
    if certain { Found::Overlap(pair.corners(&Simplex::of(&portal))) } else { Found::Doubt(Corners::NONE) }
}
