//! Exact arithmetic for questions that rounding leaves open: touching, degenerate bodies, tiny gaps.
//!
//! All coordinates become integers after a common scaling by a power of two. GJK then runs without rounding: the
//! simplex is reduced to the smallest part that holds the point v of its hull nearest the origin, and a support point
//! nearer along v makes |v| strictly smaller, so that no simplex comes twice and the search ends, without a cap.

use crate::gjk::prove::integer::{Point, to_double};
use crate::gjk::support::Support;
use crate::math::Vec3;
use num_bigint::BigInt;
use num_traits::{Signed, Zero};

/// The two bodies, B displaced by `x`, and the scale that makes all coordinates integers.
pub(crate) struct ExactPair<'a, A: ?Sized, B: ?Sized> {
    a: &'a A,
    b: &'a B,
    /// Displacement of B, rounded.
    x: Vec3,
    /// Magnitudes of `x` where it was rounded, else 0.
    rounded: Vec3,
    /// Coordinates are integers times 2^`exponent`.
    exponent: i32,
    x_scaled: Point,
}

/// The verdict of exact arithmetic.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Decision {
    /// Apart; the direction separates them, in integers, from A to B.
    Apart(Point),
    /// The origin lies in the hull of the differences of these points.
    Overlap(Vec<(u32, u32)>),
}

impl Decision {
    /// The separating direction in doubles, if there is one.
    pub(crate) fn direction(&self) -> Option<Vec3> {
        match self {
            Self::Apart(direction) => Some(direction.direction()),
            Self::Overlap(_) => None,
        }
    }
}

/// The squared distance as a fraction, in units of 2^(2 exponent).
pub(crate) struct SquaredDistance {
    pub(crate) numerator: BigInt,
    pub(crate) denominator: BigInt,
    pub(crate) exponent: i32,
}

/// A point of A - B with the points it is the difference of.
#[derive(Clone, Debug)]
struct Corner {
    w: Point,
    of: (u32, u32),
}

/// The part of a simplex nearest the origin: its corners, and a positive multiple of the nearest point.
struct Nearest {
    corners: Vec<Corner>,
    v: Point,
}

impl<'a, A: Support + ?Sized, B: Support + ?Sized> ExactPair<'a, A, B> {
    pub(crate) fn new(a: &'a A, b: &'a B, x: &Vec3) -> Self {
        let of_a = (0..a.len()).map(|i| a.point(i));
        let of_b = (0..b.len()).map(|i| b.point(i));
        let exponent = of_a.chain(of_b).chain([*x]).flat_map(|p| [p.x, p.y, p.z]).filter_map(lowest_bit).min();
        let exponent = exponent.unwrap_or(0);
        Self { a, b, x: *x, rounded: Vec3::zeros(), exponent, x_scaled: Point::new(x, exponent) }
    }

    /// The two bodies, B displaced by `motion` times `time`, which is not rounded.
    pub(crate) fn at_time(a: &'a A, b: &'a B, motion: &Vec3, time: f64) -> Self {
        let (still, x) = (Self::new(a, b, &Vec3::zeros()), motion * time);
        let power = lowest_bit(time).unwrap_or(0);
        let lowest = motion.iter().filter_map(|value| lowest_bit(*value)).map(|bit| bit + power).min();
        let exponent = lowest.map_or(still.exponent, |bit| bit.min(still.exponent));
        Self { x, rounded: x.abs(), exponent, x_scaled: Point::product(motion, time, exponent), ..still }
    }

    /// Whether the bodies share a point, starting from the pairs of points in `start`.
    pub(crate) fn decide(&self, start: &[(u32, u32)]) -> Decision {
        let mut corners = self.starting_corners(start);
        loop {
            let Nearest { corners: kept, v } = nearest(&corners);
            if v.is_zero() {
                return Decision::Overlap(kept.iter().map(|c| c.of).collect());
            }
            corners = kept;
            match self.below(&v, &BigInt::zero(), true) {
                Some(corner) => corners.push(corner),
                None => return Decision::Apart(v.negated()),
            }
        }
    }

    /// The squared distance of the bodies, 0 when they share a point, and the direction from A to B along it.
    pub(crate) fn squared_distance(&self, start: &[(u32, u32)]) -> (SquaredDistance, Point) {
        let Nearest { corners, v } = self.descend(start);
        if v.is_zero() {
            return (self.fraction(BigInt::zero(), BigInt::from(1)), v);
        }
        // The nearest point is v scaled so that its height is that of the corners: |v|2 = height2 / v.v.
        let height = corners[0].w.dot(&v);
        (self.fraction(&height * &height, v.dot(&v)), v.negated())
    }

    /// A point of A and one of B (not displaced) that are nearest each other, one point where the bodies share any:
    /// each coordinate is the exact one, rounded once.
    pub(crate) fn closest_points(&self, start: &[(u32, u32)]) -> [Vec3; 2] {
        let Nearest { corners, .. } = self.descend(start);
        let weights = weights(&corners);
        let total: BigInt = weights.iter().sum();
        let combined = |point_of: &dyn Fn(&Corner) -> Vec3| {
            let points = corners.iter().map(|corner| Point::new(&point_of(corner), self.exponent));
            let sum = points.zip(&weights).fold(Point::zero(), |sum, (point, weight)| sum.plus(&point.times(weight)));
            sum.over(&total, i64::from(self.exponent))
        };
        [combined(&|corner| self.a.point(corner.of.0 as usize)), combined(&|corner| self.b.point(corner.of.1 as usize))]
    }

    /// The part of a simplex of A - B that no point of A - B is nearer than.
    fn descend(&self, start: &[(u32, u32)]) -> Nearest {
        let mut corners = self.starting_corners(start);
        loop {
            let found = nearest(&corners);
            if found.v.is_zero() {
                return found;
            }
            let height = found.corners[0].w.dot(&found.v);
            match self.below(&found.v, &height, false) {
                Some(corner) => {
                    corners = found.corners;
                    corners.push(corner);
                }
                None => return found,
            }
        }
    }

    fn fraction(&self, numerator: BigInt, denominator: BigInt) -> SquaredDistance {
        SquaredDistance { numerator, denominator, exponent: self.exponent }
    }

    fn starting_corners(&self, start: &[(u32, u32)]) -> Vec<Corner> {
        let of = if start.is_empty() { &[(0, 0)] } else { start };
        of.iter().map(|&of| self.corner(of)).collect()
    }

    fn corner(&self, of: (u32, u32)) -> Corner {
        let a = Point::new(&self.a.point(of.0 as usize), self.exponent);
        let b = Point::new(&self.b.point(of.1 as usize), self.exponent);
        Corner { w: a.minus(&b).minus(&self.x_scaled), of }
    }

    /// A corner whose height along `v` is below `bound` (or equal to it, where `or_equal`); `None` if there is none.
    ///
    /// The lowest by rounded heights is tried first; only if it fails must all that rounding could hide be looked at.
    fn below(&self, v: &Point, bound: &BigInt, or_equal: bool) -> Option<Corner> {
        let accepts = |corner: &Corner| {
            let height = corner.w.dot(v);
            if or_equal { height <= *bound } else { height < *bound }
        };
        let rounded = v.direction();
        let down = Point::negated(v).direction();
        let origin = self.a.point(0);
        let of_a = Heights::new(self.a, [&Vec3::zeros(); 2], &origin, &down);
        let of_b = Heights::new(self.b, [&self.x, &self.rounded], &origin, &rounded);
        let first = self.corner((of_a.highest() as u32, of_b.highest() as u32));
        if accepts(&first) {
            return Some(first);
        }
        let a = self.highest_of(self.a, of_a.candidates(), &v.negated());
        let b = self.highest_of(self.b, of_b.candidates(), v);
        Some(self.corner((a, b))).filter(accepts)
    }

    fn highest_of<S: Support + ?Sized>(&self, body: &S, candidates: Vec<usize>, v: &Point) -> u32 {
        let height = |i: &usize| Point::new(&body.point(*i), self.exponent).dot(v);
        candidates.into_iter().max_by_key(height).expect("a highest point is a candidate") as u32
    }
}

/// Rounded heights of a body's points along a direction, with their error bounds.
struct Heights(Vec<(f64, f64)>);

impl Heights {
    /// Heights of points + `x` - `origin`: near the pair, so that its distance from the frame's origin costs no digits.
    /// Displacements are `x`, and the magnitudes that were rounded in it.
    fn new<S: Support + ?Sized>(body: &S, x: [&Vec3; 2], origin: &Vec3, v: &Vec3) -> Self {
        Self((0..body.len()).map(|i| height(&body.point(i), x, origin, v)).collect())
    }

    fn highest(&self) -> usize {
        (1..self.0.len()).fold(0, |best, i| if self.0[i].0 > self.0[best].0 { i } else { best })
    }

    /// The points that can be highest.
    fn candidates(&self) -> Vec<usize> {
        let floor = self.0.iter().map(|(h, error)| h - error).fold(f64::NEG_INFINITY, f64::max);
        (0..self.0.len()).filter(|&i| self.0[i].0 + self.0[i].1 >= floor).collect()
    }
}

/// Height of p + x - origin along `v` (largest component about 1), and a bound of its error: one rounding for the
/// `rounded` part of x, one for each subtraction, one for each component of v, four for the dot product; and the
/// components of v below 2^-900.
fn height(p: &Vec3, [x, rounded]: [&Vec3; 2], origin: &Vec3, v: &Vec3) -> (f64, f64) {
    let moved = p + x;
    let shifted = moved - origin;
    let rounded_twice = moved.zip_map(x, |m, x| if x == 0.0 { 0.0 } else { m.abs() });
    let size = (shifted.abs() + rounded_twice + rounded).zip_map(v, |s, v| s * (v.abs() + 1e-270));
    let (height, error) = (shifted.dot(v), size.sum() * (8.0 * f64::EPSILON) + 1e-320);
    // Where it overflows, nothing is known.
    if height.is_finite() && error.is_finite() { (height, error) } else { (0.0, f64::INFINITY) }
}

/// Exponent of the lowest set bit of a double; `None` for 0.
fn lowest_bit(value: f64) -> Option<i32> {
    let (mantissa, exponent) = crate::gjk::prove::integer::decode(value);
    (mantissa != 0).then(|| exponent + mantissa.trailing_zeros() as i32)
}

/// The smallest part of the simplex whose hull holds the point nearest the origin.
///
/// That part is the one whose own nearest point lies strictly inside it and has no other corner below it. Parts are
/// tried by size, so that the one found is not degenerate; one always fits (Caratheodory).
fn nearest(corners: &[Corner]) -> Nearest {
    let n = corners.len();
    let parts = |size: u32| (1u32..1 << n).filter(move |mask| mask.count_ones() == size);
    for mask in (1..=n.min(3) as u32).flat_map(parts) {
        let part: Vec<&Corner> = (0..n).filter(|i| mask >> i & 1 == 1).map(|i| &corners[i]).collect();
        let Some(v) = inner_nearest(&part) else { continue };
        let height = part[0].w.dot(&v);
        let others = (0..n).filter(|i| mask >> i & 1 == 0);
        if v.is_zero() || others.into_iter().all(|i| corners[i].w.dot(&v) >= height) {
            return Nearest { corners: part.into_iter().cloned().collect(), v };
        }
    }
    // No point, edge or triangle is nearest: the origin is strictly inside.
    Nearest { corners: corners.to_vec(), v: Point::zero() }
}

/// The shares of the corners in their point nearest the origin, which lies strictly inside; only their ratios count.
fn weights(corners: &[Corner]) -> Vec<BigInt> {
    match corners.iter().map(|corner| &corner.w).collect::<Vec<_>>()[..] {
        [a, b] => {
            let e = b.minus(a);
            vec![b.dot(&e), -a.dot(&e)]
        }
        [a, b, c] => {
            let n = b.minus(a).cross(&c.minus(a));
            [(b, c), (c, a), (a, b)].map(|(p, q)| n.dot(&p.cross(q))).to_vec()
        }
        [a, b, c, d] => {
            let (ab, cd) = (a.cross(b), c.cross(d));
            [b.dot(&cd), a.dot(&cd), d.dot(&ab), c.dot(&ab)].map(|volume| volume.abs()).to_vec()
        }
        _ => vec![BigInt::from(1)],
    }
}

/// A positive multiple of the point of the part's affine hull nearest the origin, if it lies strictly inside the part.
fn inner_nearest(part: &[&Corner]) -> Option<Point> {
    match part {
        [a] => Some(a.w.clone()),
        [a, b] => inner_nearest_of_edge(&a.w, &b.w),
        [a, b, c] => inner_nearest_of_triangle(&a.w, &b.w, &c.w),
        _ => None,
    }
}

fn inner_nearest_of_edge(a: &Point, b: &Point) -> Option<Point> {
    let e = b.minus(a);
    let along = a.dot(&e);
    let inside = along.is_negative() && b.dot(&e).is_positive();
    inside.then(|| a.times(&e.dot(&e)).minus(&e.times(&along)))
}

fn inner_nearest_of_triangle(a: &Point, b: &Point, c: &Point) -> Option<Point> {
    let n = b.minus(a).cross(&c.minus(a));
    if n.is_zero() {
        return None;
    }
    // Barycentric coordinates of the origin's projection, times n.n.
    let inside = [(b, c), (c, a), (a, b)].iter().all(|(p, q)| n.dot(&p.cross(q)).is_positive());
    inside.then(|| {
        let height = n.dot(a);
        if height.is_zero() {
            Point::zero()
        } else if height.is_positive() {
            n
        } else {
            n.negated()
        }
    })
}

impl SquaredDistance {
    /// The distance, rounded; positive whenever the exact one is.
    pub(crate) fn sqrt(&self) -> f64 {
        if self.numerator.is_zero() {
            return 0.0;
        }
        // Enough bits that the root of the quotient has more than 64; an even number, to be halved.
        let missing = 2 * 66 + self.denominator.bits() as i64 - self.numerator.bits() as i64;
        let shift = missing + (missing & 1);
        let quotient = if shift >= 0 {
            (&self.numerator << shift as u64) / &self.denominator
        } else {
            &self.numerator / (&self.denominator << (-shift) as u64)
        };
        let root = to_double(&quotient.sqrt(), i64::from(self.exponent) - shift / 2);
        root.max(f64::from_bits(1))
    }

    /// True when the distance is more than `gap`, exactly; `gap` is finite and not negative.
    pub(crate) fn exceeds(&self, gap: f64) -> bool {
        let (mantissa, exponent) = crate::gjk::prove::integer::decode(gap);
        let gap2 = BigInt::from(mantissa) * BigInt::from(mantissa) * &self.denominator;
        // numerator 2^(2 own) > gap2 2^(2 exponent)
        let difference = 2 * (i64::from(self.exponent) - i64::from(exponent));
        if difference >= 0 {
            (&self.numerator << difference as u64) > gap2
        } else {
            self.numerator > gap2 << (-difference) as u64
        }
    }
}
