//! Enhanced GJK: do two convex bodies share a point, yes or no.
//!
//! Algorithms 1 and 2 of Buildings 2025, 15(21), 3883, Sec. 2.3.2, mended. As printed they never test the first support,
//! cycle, and take flat simplices for collisions. Here every support is tested; line and triangle are reduced to the
//! feature that faces the origin; a repeated support, a zero direction or too many steps end the search in doubt; and
//! a "yes" or "no" counts only with a [`certificate`]. Doubt is settled by [`exact`](super::exact).
//!
//! It computes no distance; for that see [`classical`](super::classical). The newest point, `a`, is always last.

use super::body::Body;
use super::certificate::{self, Difference};
use super::simd::{HEIGHT_ERROR, Kernel, Search};
use super::simplex::{Corners, Simplex, Vertex};
use super::support::Support;
use crate::math::Vec3;

/// Steps after which a search is in doubt. Bodies of 20 to 30 points need 4 on average.
const MAX_STEPS: usize = 64;

/// What a search in floating point found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Found {
    /// Proved apart along this direction, from A to B.
    Apart(Vec3),
    /// Proved to share a point: the origin lies in this tetrahedron. Where a gap was asked for: proved not that far apart.
    /// Where the frames' origins or the ellipsoids prove it, corners are missing.
    Overlap(Corners),
    /// Not proved; this is where the search ended.
    Doubt(Corners),
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
    /// A power of two.
    pub(crate) scale: f64,
}

impl Pair<'_> {
    /// The vertex of A - B made of the points in slots `a` and `b`.
    #[inline(always)]
    fn vertex(&self, a: u32, b: u32) -> Vertex {
        let w = self.a.slot(a as usize) - self.b.slot(b as usize) - self.x;
        Vertex { w, of: (a, b) }
    }

    /// The pairs of points that make up these vertices.
    #[inline(always)]
    pub(crate) fn corners(&self, simplex: &Simplex) -> Corners {
        simplex.corners(|of| (self.a.unpadded(of.0), self.b.unpadded(of.1)))
    }

    /// The support of A - B along `v`, and by how much `v` separates the bodies, times |v|; negative: not at all.
    #[inline(always)]
    pub(crate) fn support<K: Kernel>(&self, kernel: K, v: &Vec3) -> (Vertex, f64) {
        let e = kernel.extremes(self.a, self.b, v);
        (self.vertex(e.a, e.b), e.bottom_of_b + self.x.dot(v) - e.top_of_a)
    }

    /// What rounding can add to the separation along `v`.
    #[inline(always)]
    pub(crate) fn doubt(&self, v: &Vec3) -> f64 {
        HEIGHT_ERROR * v.lp_norm_1() * self.reach + f64::MIN_POSITIVE
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
            Some(Originals { a: from_a, b: from_b, scale }) => {
                let Difference { w, magnitude } = Difference::new(&from_a[a], &from_b[b], &Vec3::zeros());
                Difference { w: w * *scale, magnitude: magnitude * *scale }
            }
            None => Difference::new(&self.a.point(a), &self.b.point(b), &self.x),
        }
    }
}

trait OneNorm {
    fn lp_norm_1(&self) -> f64;
}

impl OneNorm for Vec3 {
    #[inline(always)]
    fn lp_norm_1(&self) -> f64 {
        self.x.abs() + self.y.abs() + self.z.abs()
    }
}

/// Algorithm 1: the search from direction `v`.
#[derive(Clone, Copy)]
pub(crate) struct Enhanced<'a> {
    pub(crate) pair: Pair<'a>,
    pub(crate) v: Vec3,
}

impl Search for Enhanced<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<K: Kernel>(self, kernel: K) -> Found {
        let Self { pair, mut v } = self;
        let (first, separation) = pair.support(kernel, &v);
        let mut simplex = Simplex::point(first);
        if separation > 0.0 {
            return apart_or_doubt(&pair, &v, separation, simplex);
        }
        v = -first.w;
        for _ in 0..MAX_STEPS {
            let (a, separation) = pair.support(kernel, &v);
            if separation > 0.0 {
                return apart_or_doubt(&pair, &v, separation, simplex);
            }
            if simplex.contains(a.of) {
                return Found::Doubt(pair.corners(&simplex));
            }
            simplex.add(a);
            match update(&mut simplex) {
                Some(direction) if direction != Vec3::zeros() => v = direction,
                Some(_) => return Found::Doubt(pair.corners(&simplex)),
                None => return overlap_or_doubt(&pair, simplex),
            }
        }
        Found::Doubt(pair.corners(&simplex))
    }
}

#[inline(always)]
fn apart_or_doubt(pair: &Pair<'_>, v: &Vec3, separation: f64, simplex: Simplex) -> Found {
    if separation > pair.doubt(v) || certificate::separates(pair.a, pair.b, &pair.x, v, 0.0) {
        return Found::Apart(*v);
    }
    Found::Doubt(pair.corners(&simplex))
}

#[inline(always)]
fn overlap_or_doubt(pair: &Pair<'_>, simplex: Simplex) -> Found {
    match simplex.tetrahedron() {
        Some(vertices) if pair.encloses_origin(vertices) => Found::Overlap(pair.corners(&simplex)),
        _ => Found::Doubt(pair.corners(&simplex)),
    }
}

/// Algorithm 2: reduces the simplex to the part that faces the origin and returns the direction to search along,
/// or `None` when the origin seems to lie in the tetrahedron.
#[inline(always)]
pub(crate) fn update(simplex: &mut Simplex) -> Option<Vec3> {
    match *simplex.vertices() {
        [b, a] => Some(line(simplex, b, a)),
        [c, b, a] => Some(triangle(simplex, c, b, a)),
        [d, c, b, a] => tetrahedron(simplex, d, c, b, a),
        _ => None,
    }
}

#[inline(always)]
fn line(simplex: &mut Simplex, b: Vertex, a: Vertex) -> Vec3 {
    let (ab, ao) = (b.w - a.w, -a.w);
    if ab.dot(&ao) <= 0.0 {
        simplex.keep(&[a]);
        return ao;
    }
    simplex.keep(&[b, a]);
    ab.cross(&ao).cross(&ab)
}

#[inline(always)]
fn triangle(simplex: &mut Simplex, c: Vertex, b: Vertex, a: Vertex) -> Vec3 {
    let (ab, ac, ao) = (b.w - a.w, c.w - a.w, -a.w);
    let normal = ab.cross(&ac);
    if normal.cross(&ac).dot(&ao) > 0.0 && ac.dot(&ao) > 0.0 {
        return line(simplex, c, a);
    }
    if ab.cross(&normal).dot(&ao) > 0.0 {
        return line(simplex, b, a);
    }
    let outward = normal.dot(&ao) > 0.0;
    // Kept so that the normal of (b - a) x (c - a) faces the origin: the tetrahedron step counts on it.
    let kept = if outward { [c, b, a] } else { [b, c, a] };
    simplex.keep(&kept);
    if outward { normal } else { -normal }
}

/// The base (b, c, d) was the last triangle: its side with the origin is where `a` was found.
#[inline(always)]
fn tetrahedron(simplex: &mut Simplex, d: Vertex, c: Vertex, b: Vertex, a: Vertex) -> Option<Vec3> {
    let (ab, ac, ad, ao) = (b.w - a.w, c.w - a.w, d.w - a.w, -a.w);
    // Outward normals, since (c - b) x (d - b) faces a.
    if ab.cross(&ac).dot(&ao) > 0.0 {
        return Some(triangle(simplex, c, b, a));
    }
    if ac.cross(&ad).dot(&ao) > 0.0 {
        return Some(triangle(simplex, d, c, a));
    }
    if ad.cross(&ab).dot(&ao) > 0.0 {
        return Some(triangle(simplex, b, d, a));
    }
    None
}
