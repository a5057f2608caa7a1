//! Minkowski portal refinement: a yes or no for bodies that are known to hold their frames' origins.
//!
//! Snethen, XenonCollide, Game Programming Gems 7 (2008), with certificates. The displacement of the frames gives a point
//! v0 inside A - B for nothing. A portal is a triangle v1 v2 v3 of points of A - B that the ray from v0 through the
//! origin passes; supports along its outward normal push it out until the origin is inside the tetrahedron v0 v1 v2 v3,
//! or a support does not reach the origin. Per step this takes half the arithmetic of a simplex update, and no division.

use super::certificate;
use super::enhanced::{Enhanced, Found, Pair, apart_or_doubt};
use super::simd::{Kernel, Search, dispatch};
use super::simplex::{Corners, Simplex, Vertex};
use crate::math::Vec3;

/// Steps after which the search is left to [`Enhanced`]; 4 is the average for bodies of 20 to 30 points.
const MAX_STEPS: usize = 32;

/// The search from direction `v`; both bodies must hold the origins of their frames.
#[derive(Clone, Copy)]
pub(crate) struct Portal<'a> {
    pub(crate) pair: Pair<'a>,
    pub(crate) v: Vec3,
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
fn undecided(Portal { pair, v }: Portal<'_>) -> Found {
    dispatch(Enhanced { pair, v })
}

/// The support of `$pair` along `$v`, unless it tells the bodies apart.
macro_rules! support {
    ($pair:ident, $kernel:ident, $v:expr) => {{
        let v = $v;
        let (w, separation) = $pair.support($kernel, &v);
        if separation > 0.0 {
            return apart_or_doubt(&$pair, &v, separation, Simplex::point(w));
        }
        w
    }};
}

impl Portal<'_> {
    #[inline(always)]
    fn refine<K: Kernel>(&self, kernel: K) -> Found {
        let Self { pair, v } = *self;
        let v0 = -pair.x;
        let mut v1 = support!(pair, kernel, v);
        // Perpendicular to the plane of v0, v1 and the origin; then to that of v0, v1, v2, towards the origin.
        let mut v2 = support!(pair, kernel, v1.w.cross(&v0));
        let mut v3 = support!(pair, kernel, (v1.w - v0).cross(&(v2.w - v0)));
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
            v3 = support!(pair, kernel, (v1.w - v0).cross(&(v2.w - v0)));
        }
        for _ in 0..MAX_STEPS {
            let outward = (v2.w - v1.w).cross(&(v3.w - v1.w));
            if outward.dot(&v1.w) > 0.0 {
                return enclosed(&pair, &v0, [v1, v2, v3]);
            }
            let v4 = support!(pair, kernel, outward);
            if (v4.w - v1.w).dot(&outward) <= 0.0 {
                break;
            }
            replace(&v0, v4, [&mut v1, &mut v2, &mut v3]);
        }
        Found::Doubt(Corners::NONE)
    }
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
