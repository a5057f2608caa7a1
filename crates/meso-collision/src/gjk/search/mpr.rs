//! Minkowski portal refinement: a yes or no for bodies that are known to hold their frames' origins.
//!
//! Snethen, XenonCollide, Game Programming Gems 7 (2008), with certificates. The displacement of the frames gives a
//! point v0 inside A - B for nothing. A portal is a triangle v1 v2 v3 of points of A - B that the ray from v0 through
//! the origin passes; supports along its outward normal push it out until the origin is inside the tetrahedron v0 v1 v2
//! v3, or a support does not reach the origin. Per step this takes half the arithmetic of a simplex update, and no
//! division.
//!
//! The search is the same in both precisions. In single precision it proves most pairs, with bounds of that precision;
//! the others go on in double precision from the portal it came to.

use crate::gjk::pair::View;
use crate::gjk::prove::certificate;
use crate::gjk::search::kernel::Real;
use crate::simd::Simd;
use nalgebra::Vector3;

/// Steps after which the search ends undecided; 4 is the average for bodies of 20 to 30 points.
pub(crate) const MAX_STEPS: usize = 32;

/// How far a direction is turned that failed: 1 makes it perpendicular to the point in its way, 2 reflects it (Chung
/// and Wang, 1996). Values in between separate most pairs with the second support; from 1.1 to 2 it is all the same.
pub(crate) const TURN: f32 = 1.5;

/// The slots of a portal's corners.
pub(crate) type Portal = [(u32, u32); 3];

/// The result of a search.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Refined<T> {
    /// Proved apart along this direction, by more than the gap.
    Apart(Vector3<T>),
    /// Proved to share a point: the origin lies in the tetrahedron of v0 and this portal.
    Overlap(Portal),
    /// Not proved; the portal, where there is one.
    Undecided(Option<Portal>),
}

impl<T> Refined<T> {
    /// Whether the bodies are apart; `None` where the search left it open.
    #[inline(always)]
    pub(crate) fn answer(&self) -> Option<bool> {
        match self {
            Self::Apart(_) => Some(true),
            Self::Overlap(_) => Some(false),
            Self::Undecided(_) => None,
        }
    }

    /// The portal that an undecided search came to.
    #[inline(always)]
    pub(crate) fn portal(&self) -> Option<Portal> {
        if let Self::Undecided(portal) = self { *portal } else { None }
    }
}

/// A point of A - B as seen from v0: a point of A less one of B, which is not displaced.
///
/// There v0 is 0 and the ray runs to the displacement x, so that no step of the search adds or subtracts it.
#[derive(Clone, Copy)]
struct Corner<T> {
    p: Vector3<T>,
    /// Slots in A and in B.
    of: (u32, u32),
}

/// The support of `$view` along `$v`, unless it tells the bodies apart.
macro_rules! support {
    ($view:ident, $simd:ident, $gap:ident, $v:expr, $portal:expr) => {{
        let v = $v;
        let extremes = $view.extremes($simd, &v);
        let separation = $view.separation(&v, &extremes);
        if separation > num_traits::zero() {
            // The bodies are apart along `v`: by more than the gap, certainly?
            let beyond = if $gap == num_traits::zero() { separation } else { separation - $gap * v.norm() };
            let certain = beyond > $view.doubt(&v);
            return if certain { Refined::Apart(v) } else { Refined::Undecided($portal) };
        }
        corner(&$view, (extremes.a, extremes.b))
    }};
}

/// The search from direction `v`; both bodies must hold the origins of their frames. Bodies that are not more than
/// `gap` apart may be left undecided.
#[inline(always)]
pub(crate) fn search<V: View, S: Simd>(view: V, simd: S, v: Vector3<V::T>, gap: V::T) -> Refined<V::T> {
    let zero: V::T = num_traits::zero();
    let x = view.displacement();
    let mut v1 = support!(view, simd, gap, v, None);
    let mut v2 = support!(view, simd, gap, turned_away(&v, &(v1.p - x), view.reach()), None);
    // Perpendicular to the plane of v0, v1, v2, on the side of it that x is on.
    let mut normal = v1.p.cross(&v2.p);
    if normal.dot(&x) < zero {
        (v1, v2, normal) = (v2, v1, -normal);
    }
    let mut v3 = support!(view, simd, gap, normal, None);
    for _ in 0..MAX_STEPS {
        // Discovery: the ray must pass inside of the planes v0 v2 v3 and v0 v3 v1.
        let across = v3.p.cross(&x);
        if v1.p.dot(&across) > zero {
            v2 = v3;
        } else if v2.p.dot(&across) < zero {
            v1 = v3;
        } else {
            return refine(view, simd, [v1, v2, v3], gap);
        }
        v3 = support!(view, simd, gap, v1.p.cross(&v2.p), None);
    }
    Refined::Undecided(None)
}

/// The search from a portal on.
#[inline(always)]
fn refine<V: View, S: Simd>(view: V, simd: S, [mut v1, mut v2, mut v3]: [Corner<V::T>; 3], gap: V::T) -> Refined<V::T> {
    let zero: V::T = num_traits::zero();
    let x = view.displacement();
    for _ in 0..MAX_STEPS {
        let outward = (v2.p - v1.p).cross(&(v3.p - v1.p));
        let portal = [v1.of, v2.of, v3.of];
        if outward.dot(&(v1.p - x)) > zero {
            let corners = [-x, v1.p - x, v2.p - x, v3.p - x];
            let certain = certificate::encloses_origin_roughly(&corners, view.reach());
            return if certain { Refined::Overlap(portal) } else { Refined::Undecided(Some(portal)) };
        }
        let v4 = support!(view, simd, gap, outward, Some(portal));
        // Progress that rounding hides shows nothing more in this precision.
        if (v4.p - v1.p).dot(&outward) <= V::T::PROGRESS * view.doubt(&outward) {
            return Refined::Undecided(Some(portal));
        }
        replace(&x, v4, [&mut v1, &mut v2, &mut v3]);
    }
    Refined::Undecided(None)
}

/// The search in f64 from the portal that single precision came to; `None` where in f64 that is none, and tells
/// nothing.
#[inline(always)]
pub(crate) fn resume<V: View<T = f64>, S: Simd>(view: V, simd: S, portal: Portal, gap: f64) -> Option<Refined<f64>> {
    let [p, q, r] = portal;
    let corners = [corner(&view, p), corner(&view, q), corner(&view, r)];
    // Certificates hold for any triangle: whether it is a portal only matters where they fail, which is rare.
    let refined = refine(view, simd, corners, gap);
    (refined.answer().is_some() || is_portal(&view.displacement(), &corners)).then_some(refined)
}

#[inline(always)]
fn corner<V: View>(view: &V, of: (u32, u32)) -> Corner<V::T> {
    Corner { p: view.undisplaced(of), of }
}

/// True when the ray from v0 through `x` passes the triangle, which faces away from v0.
#[inline(always)]
fn is_portal<T: Real>(x: &Vector3<T>, corners: &[Corner<T>; 3]) -> bool {
    let zero: T = num_traits::zero();
    let [p, q, r] = [corners[0].p, corners[1].p, corners[2].p];
    p.cross(&q).dot(x) >= zero && q.cross(&r).dot(x) >= zero && r.cross(&p).dot(x) >= zero
}

/// The direction `v` turned away from `w`, the point that keeps it from telling the bodies apart, and shortened.
///
/// The length of `w` is measured in `reach`: a division by its square would be waited for.
#[inline(always)]
fn turned_away<T: Real>(v: &Vector3<T>, w: &Vector3<T>, reach: T) -> Vector3<T> {
    let (one, turn): (T, T) = (num_traits::one(), nalgebra::convert(f64::from(TURN)));
    let unit = one / (reach * reach);
    v * (unit * w.norm_squared()) - w * (turn * unit * v.dot(w))
}

/// Replaces the corner of the portal that the ray leaves behind when `v4` is added.
#[inline(always)]
fn replace<T: Real>(x: &Vector3<T>, v4: Corner<T>, [v1, v2, v3]: [&mut Corner<T>; 3]) {
    let zero: T = num_traits::zero();
    let across = x.cross(&v4.p);
    let [e1, e2, e3] = [v1.p.dot(&across), v2.p.dot(&across), v3.p.dot(&across)];
    if e1 > zero && e2 <= zero {
        *v3 = v4;
    } else if e2 > zero && e3 <= zero {
        *v1 = v4;
    } else {
        *v2 = v4;
    }
}
