//! The search for orthogonal directions in which a body is narrow.

use super::SLACK;
use super::arcs::{Arc, ArcPiece, CirclePoints, Ends, Excluded, LANES, all, support};
use crate::geometry::Polyhedron;
use crate::math::Vec3;
use crate::simd::{Lanes, Mask, Simd, Vectorized, for_each_lane};

/// Dot products of this much below 0 are taken for 0, so that pieces which touch hold orthogonal directions.
const TOUCH: f64 = 1e-13;
/// Number of squares tried around the first projection, a quarter turn in all.
const ROLLS: usize = 8;
/// Tangent of half the angle between two of these squares.
const ROLL: f64 = 0.0985;
/// Tangents of half the first and the last angle by which the square is turned.
const STEPS: [f64; 2] = [0.1, 0.003];
/// Relative precision of the least side of two arcs.
const PRECISION: f64 = 1e-11;
/// Most evaluations for the least side of two arcs; bisection alone would need 36.
const EVALUATIONS: usize = 120;

/// The smallest square hole that a body passes; [`dispatch`](crate::simd::dispatch) runs it.
pub(super) struct Smallest<'a> {
    pub(super) body: &'a Polyhedron,
}

impl Vectorized for Smallest<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> f64 {
        let points = CirclePoints::of(simd, self.body);
        let mut side = turned(simd, self.body, &points);
        let arcs = Arc::open(simd, self.body, &points, side);
        let excluded = Excluded::of(&points);
        let mut search = Search { simd, points, arcs: &arcs, excluded, pieces: [Vec::new(), Vec::new()] };
        let mut open: Vec<u32> = (0..arcs.len() as u32).collect();
        loop {
            let pairs = search.candidates(&open, side * (1.0 - SLACK));
            let less = search.first_below(&pairs, side);
            if less >= side {
                return side;
            }
            side = less;
            let mut used = vec![false; arcs.len()];
            pairs.iter().for_each(|pair| pair.arcs.iter().for_each(|&arc| used[arc as usize] = true));
            open.retain(|&arc| used[arc as usize]);
        }
    }
}

/// The side of a square around a projection: along two vertices that are far apart first, then turned while that helps.
#[inline(always)]
fn turned<S: Simd>(simd: S, body: &Polyhedron, points: &CirclePoints<S>) -> f64 {
    let (mut least, mut best) = lengthwise(simd, body, points);
    let mut step = STEPS[0];
    while step > STEPS[1] {
        let before = least;
        for (i, j, t) in [(0, 2, step), (0, 2, -step), (1, 2, step), (1, 2, -step), (0, 1, step), (0, 1, -step)] {
            let frame = rotated(&best, i, j, t);
            let side = square(simd, points, &frame[0], &frame[1]);
            if side < least {
                (least, best) = (side, frame);
            }
        }
        if least == before {
            step *= 0.5;
        }
    }
    least
}

/// The smallest of [`ROLLS`] squares around a projection along two vertices that are far apart, and its frame.
#[inline(always)]
fn lengthwise<S: Simd>(simd: S, body: &Polyhedron, points: &CirclePoints<S>) -> (f64, [Vec3; 3]) {
    let mut along = Vec3::x();
    for _ in 0..2 {
        along = support(body, &along) - support(body, &-along);
    }
    let along = along.normalize();
    let across = along.cross(&Vec3::ith(along.iamin(), 1.0)).normalize();
    let mut frame = [across, along.cross(&across), along];
    let (mut least, mut best) = (f64::INFINITY, frame);
    for _ in 0..ROLLS {
        let side = square(simd, points, &frame[0], &frame[1]);
        if side < least {
            (least, best) = (side, frame);
        }
        frame = rotated(&frame, 0, 1, ROLL);
    }
    (least, best)
}

/// The side of the square around the body whose sides are along and across `u` and `v`.
#[inline(always)]
fn square<S: Simd>(simd: S, points: &CirclePoints<S>, u: &Vec3, v: &Vec3) -> f64 {
    points.width(simd, u).max(points.width(simd, v))
}

/// The frame turned in the plane of two of its axes; `t` is the tangent of half the angle.
#[inline(always)]
fn rotated(frame: &[Vec3; 3], i: usize, j: usize, t: f64) -> [Vec3; 3] {
    let scale = 1.0 / (1.0 + t * t);
    let (cosine, sine) = ((1.0 - t * t) * scale, 2.0 * t * scale);
    let mut turned = *frame;
    turned[i] = frame[i] * cosine + frame[j] * sine;
    turned[j] = frame[j] * cosine - frame[i] * sine;
    turned
}

/// Two arcs, and how far the dot products of directions on them reach beyond 0 on both sides.
struct Pair {
    arcs: [u32; 2],
    reach: f64,
}

struct Search<'a, S: Simd> {
    simd: S,
    points: CirclePoints<S>,
    arcs: &'a [Arc],
    excluded: Excluded,
    pieces: [Vec<ArcPiece>; 2],
}

/// Pieces of arcs with the directions at their ends, by axis.
struct Spans {
    arcs: Vec<u32>,
    columns: [Vec<f64>; 6],
}

impl Spans {
    #[inline(always)]
    fn push(&mut self, arc: u32, [a, b]: Ends) {
        self.arcs.push(arc);
        let numbers = [a.x, a.y, a.z, b.x, b.y, b.z];
        self.columns.iter_mut().zip(numbers).for_each(|(column, number)| column.push(number));
    }

    /// The directions at the ends of piece `k`.
    fn ends(&self, k: usize) -> Ends {
        let [ax, ay, az, bx, by, bz] = self.columns.each_ref().map(|column| column[k]);
        [Vec3::new(ax, ay, az), Vec3::new(bx, by, bz)]
    }

    /// Fills the last register.
    fn fill(&mut self) {
        let whole = self.arcs.len().next_multiple_of(LANES);
        self.columns.iter_mut().for_each(|column| column.resize(whole, 0.0));
    }
}

impl<S: Simd> Search<'_, S> {
    /// Pairs of the `open` arcs that hold orthogonal directions at `side`, the farthest reaching first.
    #[inline(always)]
    fn candidates(&mut self, open: &[u32], side: f64) -> Vec<Pair> {
        let column = || Vec::with_capacity(open.len() + LANES);
        let mut spans = Spans { arcs: Vec::with_capacity(open.len()), columns: std::array::from_fn(|_| column()) };
        for &k in open {
            let arc = self.arcs[k as usize];
            arc.narrow(self.simd, &self.points, side, &mut self.excluded, &mut self.pieces[0]);
            for piece in &self.pieces[0] {
                spans.push(k, arc.ends(piece));
            }
        }
        spans.fill();
        let mut pairs = Vec::new();
        for i in 0..spans.arcs.len() {
            self.partners(&spans.ends(i), &spans, i, |k, reach| {
                pairs.push(Pair { arcs: [spans.arcs[i], spans.arcs[k]], reach });
            });
        }
        if let Some(best) = (0..pairs.len()).max_by(|&p, &q| pairs[p].reach.total_cmp(&pairs[q].reach)) {
            pairs.swap(0, best);
        }
        pairs
    }

    /// Visits the spans from the `first` on that hold a direction orthogonal to one between `ends`.
    #[inline(always)]
    fn partners(&self, ends: &Ends, spans: &Spans, first: usize, mut visit: impl FnMut(usize, f64)) {
        let [a, b] = [all(self.simd, &ends[0]), all(self.simd, &ends[1])];
        let (zero, limit) = (S::F64::all(self.simd, 0.0), S::F64::all(self.simd, -TOUCH));
        let [ax, ay, az, bx, by, bz] = spans.columns.each_ref();
        for at in (first / S::F64::LANES..ax.len() / S::F64::LANES).map(|register| register * S::F64::LANES) {
            let load = |column| S::F64::load(self.simd, column, at);
            let (c, d) = ([load(ax), load(ay), load(az)], [load(bx), load(by), load(bz)]);
            let (p, q, r, s) = (dot(&a, &c), dot(&a, &d), dot(&b, &c), dot(&b, &d));
            let most = p.max(q).max(r.max(s));
            let least = (zero - p).max(zero - q).max((zero - r).max(zero - s));
            let reach = least.or(least.above(most), most);
            let found = reach.above(limit).bits();
            if found != 0 {
                let reach = reach.to_array();
                for_each_lane(found, |lane| {
                    if (first..spans.arcs.len()).contains(&(at + lane)) {
                        visit(at + lane, reach.as_ref()[lane]);
                    }
                });
            }
        }
    }

    /// The first least side of the pairs that is below `side`, or infinity.
    #[inline(always)]
    fn first_below(&mut self, pairs: &[Pair], side: f64) -> f64 {
        for pair in pairs {
            let less = self.least_side(pair, side);
            if less < side {
                return less;
            }
        }
        f64::INFINITY
    }

    /// The least side at which a pair of arcs holds orthogonal directions; infinity where it is not below `side`.
    ///
    /// The secant method between bounds: the reach falls to 0 with the side, or the pieces vanish.
    #[inline(always)]
    fn least_side(&mut self, pair: &Pair, side: f64) -> f64 {
        let arcs = pair.arcs.map(|k| self.arcs[k as usize]);
        let side = side * (1.0 - SLACK);
        let mut last = (side, self.reach(&arcs, side));
        if last.1 < -TOUCH {
            return f64::INFINITY;
        }
        let (mut low, mut high, mut lifted, tiny) = (0.0, side, 0.0, PRECISION * side);
        let mut next = side * (1.0 - 0.2 * last.1.max(1e-6));
        for _ in 0..EVALUATIONS {
            let now = (next, self.reach(&arcs, next));
            (low, high) = if now.1 >= -TOUCH { (low, next) } else { (next, high) };
            if high - low <= 4.0 * tiny {
                break;
            }
            let middle = if low > 0.0 { 0.5 * (low + high) } else { high - 2.0 * (side - high) };
            if now.1 == f64::NEG_INFINITY {
                // The root is likely just above, where the pieces begin.
                next = if lifted == low { middle } else { low + 3.0 * tiny };
                lifted = next;
                continue;
            }
            // Beyond the root of the secant by a little, so that the next value is likely on its other side.
            let beyond = if now.1 >= -TOUCH { -tiny } else { tiny };
            let root = now.0 - now.1 * (now.0 - last.0) / (now.1 - last.1) + beyond;
            next = if root > low && root < high { root } else { middle };
            last = now;
        }
        self.side(&arcs, high)
    }

    /// How far dot products of narrow directions on two arcs reach beyond 0 on both sides, at most the length of a piece;
    /// minus infinity without pieces.
    #[inline(always)]
    fn reach(&mut self, arcs: &[Arc; 2], side: f64) -> f64 {
        self.find(arcs, side);
        let mut most = f64::NEG_INFINITY;
        for p in &self.pieces[0] {
            for q in &self.pieces[1] {
                let (a, b) = (arcs[0].ends(p), arcs[1].ends(q));
                most = most.max(reach(&a, &b).min((a[1] - a[0]).norm()).min((b[1] - b[0]).norm()));
            }
        }
        most
    }

    /// Finds the pieces of two arcs on which the body is at most `side` wide.
    #[inline(always)]
    fn find(&mut self, arcs: &[Arc; 2], side: f64) {
        for (arc, pieces) in arcs.iter().zip(&mut self.pieces) {
            arc.narrow(self.simd, &self.points, side, &mut self.excluded, pieces);
        }
    }

    /// The side of a square around the body whose directions are on two arcs, one of them at the end of a piece.
    #[inline(always)]
    fn side(&mut self, arcs: &[Arc; 2], side: f64) -> f64 {
        self.find(arcs, side);
        let mut least = f64::INFINITY;
        for p in &self.pieces[0] {
            for q in &self.pieces[1] {
                let (a, b) = (arcs[0].ends(p), arcs[1].ends(q));
                if reach(&a, &b) >= -TOUCH {
                    for (u, other) in [(a[0], 1), (a[1], 1), (b[0], 0), (b[1], 0)] {
                        let v = arcs[other].orthogonal_to(&u);
                        least = least.min(square(self.simd, &self.points, &u, &v));
                    }
                }
            }
        }
        least
    }
}

/// Dot products, lane by lane.
#[inline(always)]
fn dot<L: Lanes<T = f64>>(&[ax, ay, az]: &[L; 3], &[bx, by, bz]: &[L; 3]) -> L {
    ax.times_plus(bx, ay.times_plus(by, az * bz))
}

/// How far the dot products of directions on two pieces reach beyond 0 on both sides; below 0 if all have one sign.
#[inline(always)]
fn reach([a, b]: &Ends, [c, d]: &Ends) -> f64 {
    let dots = [a.dot(c), a.dot(d), b.dot(c), b.dot(d)];
    let most = dots.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let least = dots.into_iter().fold(f64::INFINITY, f64::min);
    most.min(-least)
}
