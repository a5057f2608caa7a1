//! Enhanced GJK: do two convex bodies share a point, yes or no.
//!
//! Algorithms 1 and 2 of Buildings 2025, 15(21), 3883, Sec. 2.3.2, mended. As printed they never test the first support,
//! cycle, and take flat simplices for collisions. Here every support is tested; line and triangle are reduced to the
//! feature that faces the origin; a repeated support, a zero direction or too many steps end the search in doubt; and
//! a "yes" or "no" counts only with a [`certificate`]. Doubt is settled by [`exact`](crate::gjk::prove::exact).
//!
//! It computes no distance; for that see [`classical`](crate::gjk::search::classical). The newest point, `a`, is always last.

use crate::gjk::pair::{Found, Pair, View};
use crate::gjk::prove::certificate;
use crate::gjk::search::simplex::{Simplex, Vertex};
use crate::math::Vec3;
use crate::simd::{Simd, Vectorized};

/// Steps after which a search is in doubt. Bodies of 20 to 30 points need 4 on average.
const MAX_STEPS: usize = 64;

/// Algorithm 1: the search from direction `v`.
#[derive(Clone, Copy)]
pub(crate) struct Enhanced<'a> {
    pub(crate) pair: Pair<'a>,
    pub(crate) v: Vec3,
}

impl Vectorized for Enhanced<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Found {
        let Self { pair, mut v } = self;
        let (first, separation) = pair.support(simd, &v);
        let mut simplex = Simplex::point(first);
        if separation > 0.0 {
            return apart_or_undecided(&pair, &v, separation, simplex);
        }
        v = -first.w;
        for _ in 0..MAX_STEPS {
            let (a, separation) = pair.support(simd, &v);
            if separation > 0.0 {
                return apart_or_undecided(&pair, &v, separation, simplex);
            }
            if simplex.contains(a.of) {
                return Found::Undecided(pair.corners(&simplex));
            }
            simplex.add(a);
            match update(&mut simplex) {
                Some(direction) if direction != Vec3::zeros() => v = direction,
                Some(_) => return Found::Undecided(pair.corners(&simplex)),
                None => return overlap_or_undecided(&pair, simplex),
            }
        }
        Found::Undecided(pair.corners(&simplex))
    }
}

#[inline(always)]
fn apart_or_undecided(pair: &Pair<'_>, v: &Vec3, separation: f64, simplex: Simplex) -> Found {
    if separation > pair.doubt(v) || certificate::separates(pair.a, pair.b, &pair.x, v) {
        return Found::Apart(*v);
    }
    Found::Undecided(pair.corners(&simplex))
}

#[inline(always)]
fn overlap_or_undecided(pair: &Pair<'_>, simplex: Simplex) -> Found {
    match simplex.tetrahedron() {
        Some(vertices) if pair.encloses_origin(vertices) => Found::Overlap(pair.corners(&simplex)),
        _ => Found::Undecided(pair.corners(&simplex)),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_reduced_to_what_of_it_is_nearest_the_origin_and_the_search_goes_from_there() {
        let mut ends = 0;
        for k in 0..500 {
            let x = |i: i32| (f64::from(k * 31 + i * i * 7) * 1.7).sin();
            let vertex = |i: i32| Vertex { w: Vec3::new(x(i), x(i + 1), x(i + 2)), of: (i as u32, 0) };
            let (b, a) = (vertex(0), vertex(3));
            let mut simplex = Simplex::point(b);
            simplex.add(a);
            let direction = update(&mut simplex).unwrap();
            // The best of many points of the line from the newest on; B comes first in a search, so it is never the nearest.
            let point = |i: u32| a.w.lerp(&b.w, f64::from(i) / 1e4);
            let (at, nearest) =
                (0..=10_000).map(|i| (i, point(i))).min_by(|p, q| p.1.norm().total_cmp(&q.1.norm())).unwrap();
            if at == 10_000 {
                continue;
            }
            assert_eq!(simplex.vertices().len(), if at == 0 { 1 } else { 2 }, "{k}");
            assert!(direction.normalize().dot(&nearest.normalize()) < -0.99, "{k}: {direction} from {nearest}");
            ends += u32::from(at == 0);
        }
        assert!((50..450).contains(&ends), "{ends}");
    }
}
