//! Classical GJK: the point of A - B nearest the origin, and with it the distance (Sec. 2.3.1).
//!
//! Gilbert, Johnson, Keerthi, IEEE J. Robot. Autom. 4 (1988). The simplex is reduced at every step to the smallest part
//! that holds its point nearest the origin, by one of two [sub-algorithms](SubAlgorithm). Used for distances, for gaps,
//! and as the yardstick of [`enhanced`](crate::gjk::search::enhanced).

use crate::gjk::pair::{Found, Pair, View};
use crate::gjk::prove::certificate;
use crate::gjk::search::nearest::SubAlgorithm;
use crate::gjk::search::simplex::{Simplex, Vertex};
use crate::math::Vec3;
use crate::simd::{Simd, Vectorized};

/// Steps after which a search is in doubt.
const MAX_STEPS: usize = 128;

/// How a search ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Until {
    /// The bodies are proved to be more than this apart, or not more.
    Apart(f64),
    /// The nearest point is found as well as rounding allows: the search ends in [`Found::Undecided`], or in an
    /// overlap.
    Nearest,
}

/// The search from direction `v`.
#[derive(Clone, Copy)]
pub(crate) struct Classical<'a> {
    pub(crate) pair: Pair<'a>,
    pub(crate) v: Vec3,
    pub(crate) sub_algorithm: SubAlgorithm,
    pub(crate) until: Until,
}

impl<'a> Classical<'a> {
    /// Are the bodies more than `gap` apart?
    #[inline(always)]
    pub(crate) fn beyond(pair: Pair<'a>, v: Vec3, gap: f64) -> Self {
        Self { pair, v, sub_algorithm: SubAlgorithm::SignedVolumes, until: Until::Apart(gap) }
    }
}

impl Vectorized for Classical<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Found {
        let Self { pair, v, sub_algorithm, until } = self;
        let (first, separation) = pair.support(simd, &v);
        let mut simplex = Simplex::point(first);
        if let Some(found) = self.decided(&v, separation, &first.w, simplex) {
            return found;
        }
        // v is now the nearest point: the search goes against it.
        let mut v = first.w;
        for _ in 0..MAX_STEPS {
            let direction = -v;
            if direction == Vec3::zeros() {
                return Found::Undecided(pair.corners(&simplex));
            }
            let (a, separation) = pair.support(simd, &direction);
            if let Some(found) = self.decided(&direction, separation, &v, simplex) {
                return found;
            }
            // |v|2 - v.w bounds the further fall of |v|2.
            let progress = v.norm_squared() - v.dot(&a.w);
            if simplex.contains(a.of) || until == Until::Nearest && progress <= 0.0 {
                return Found::Undecided(pair.corners(&simplex));
            }
            let before = simplex;
            simplex.add(a);
            let nearest = sub_algorithm.reduce(&mut simplex);
            if let Some(vertices) = simplex.tetrahedron() {
                return if pair.encloses_origin(vertices) {
                    Found::Overlap(pair.corners(&simplex))
                } else {
                    Found::Undecided(pair.corners(&simplex))
                };
            }
            if nearest.norm_squared() >= v.norm_squared() {
                return Found::Undecided(pair.corners(&before));
            }
            v = nearest;
        }
        Found::Undecided(pair.corners(&simplex))
    }
}

impl Classical<'_> {
    /// The answer, once the support gap along `direction` is certainly above the asked one, or a point of A - B
    /// certainly nearer.
    #[inline(always)]
    fn decided(&self, direction: &Vec3, separation: f64, nearest: &Vec3, simplex: Simplex) -> Option<Found> {
        let Until::Apart(gap) = self.until else { return None };
        let pair = &self.pair;
        if gap == 0.0 {
            let proved =
                |_| separation > pair.doubt(direction) || certificate::separates(pair.a, pair.b, &pair.x, direction);
            return (separation > 0.0)
                .then(|| if proved(()) { Found::Apart(*direction) } else { Found::Undecided(pair.corners(&simplex)) });
        }
        let norm = direction.norm();
        if separation - gap * norm > pair.doubt(direction) {
            return Some(Found::Apart(*direction));
        }
        // `nearest` is a projection, which a sliver can throw off: only a combination of points of A - B proves.
        let near = nearest.norm() < gap && distance_bound(simplex.vertices()) + 1e-14 * pair.reach < gap;
        near.then(|| Found::Overlap(pair.corners(&simplex)))
    }
}

/// A distance from the origin at which there certainly is a point of the simplex, up to the rounding of its corners.
///
/// Whatever the weights, as long as none is negative: a bad guess of them makes the bound larger, not wrong.
fn distance_bound(vertices: &[Vertex]) -> f64 {
    let weights = match vertices {
        [a, b] => [b.w.dot(&(b.w - a.w)), a.w.dot(&(a.w - b.w)), 0.0],
        [a, b, c] => {
            let normal = (b.w - a.w).cross(&(c.w - a.w));
            [(b, c), (c, a), (a, b)].map(|(p, q)| normal.dot(&p.w.cross(&q.w)))
        }
        _ => [1.0, 0.0, 0.0],
    };
    let weights = weights.map(|w| w.max(0.0));
    let total: f64 = weights.iter().sum();
    let point: Vec3 = vertices.iter().zip(weights).map(|(v, weight)| v.w * (weight / total)).sum();
    // NaN (no weight at all) proves nothing: no comparison with it holds.
    point.norm()
}
