//! Proofs that survive rounding: a separating direction, or four points around the origin.
//!
//! u = 2^-53. A coordinate reaches the sums below with a relative error of at most u (it was shifted once), a
//! difference of two points with one of at most 2u; every operation adds u. Products may underflow, by at most
//! [`UNDERFLOW`] together; everything else the bounds cover with room to spare.

use crate::gjk::search::kernel::Real;
use crate::gjk::support::Support;
use crate::math::Vec3;
use nalgebra::Vector3;

/// Unit roundoff of f64.
const U: f64 = f64::EPSILON / 2.0;
/// More than all products of one sum can lose by underflow.
const UNDERFLOW: f64 = f64::UNDERFLOW;

/// True when the heights of all points prove that `v` separates A from B + x.
///
/// Points of A lie lower: max a . v < min b . v + x . v.
pub(crate) fn separates<A, B>(a: &A, b: &B, x: &Vec3, v: &Vec3) -> bool
where
    A: Support + ?Sized,
    B: Support + ?Sized,
{
    let top_of_a = (0..a.len()).map(|i| highest(&a.point(i), v)).fold(f64::NEG_INFINITY, f64::max);
    let top_of_b = (0..b.len()).map(|i| highest(&b.point(i), &-v)).fold(f64::NEG_INFINITY, f64::max);
    let along = -highest(&-x, v);
    let doubt = 4.0 * U * (top_of_a.abs() + top_of_b.abs() + along.abs());
    along - (top_of_a + top_of_b) > doubt + UNDERFLOW
}

/// An upper bound of p . v; 5 u: one for the coordinate, one for each product, two for the sum, and its own.
#[inline(always)]
pub(crate) fn highest(p: &Vec3, v: &Vec3) -> f64 {
    let terms = p.component_mul(v);
    terms.sum() + 6.0 * U * terms.abs().sum()
}

/// A point of A - B and bounds of its coordinates' magnitudes, each wrong by at most u times the bound.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Difference {
    pub(crate) w: Vec3,
    pub(crate) magnitude: Vec3,
}

impl Difference {
    /// a - (b + x).
    #[inline(always)]
    pub(crate) fn new(a: &Vec3, b: &Vec3, x: &Vec3) -> Self {
        let first = a - b;
        let w = first - x;
        let rounded_twice = first.zip_map(x, |d, x| if x == 0.0 { 0.0 } else { d.abs() });
        Self { w, magnitude: w.abs() + rounded_twice }
    }
}

/// True when the origin is proved to lie strictly inside the tetrahedron of the four points.
///
/// It does when the determinants of the four triples have the signs of a barycentric combination. A determinant's sign
/// is certain beyond 12 u times its permanent: three relative errors of u in the entries, five operations, and room.
pub(crate) fn encloses_origin(points: &[Difference; 4]) -> bool {
    let [p0, p1, p2, p3] = points;
    let first = certain_determinant(p1, p2, p3);
    let others = [certain_determinant(p0, p3, p2), certain_determinant(p0, p1, p3), certain_determinant(p0, p2, p1)];
    first != 0.0 && others.iter().all(|d| d * first.signum() > 0.0)
}

/// det(a, b, c), or 0 where its sign is in doubt.
fn certain_determinant(a: &Difference, b: &Difference, c: &Difference) -> f64 {
    let determinant = a.w.dot(&b.w.cross(&c.w));
    let ([b1, b2, b3], [c1, c2, c3]) = (b.magnitude.into(), c.magnitude.into());
    let cross: Vec3 = Vec3::new(b2 * c3 + b3 * c2, b3 * c1 + b1 * c3, b1 * c2 + b2 * c1);
    let permanent = a.magnitude.dot(&cross);
    if determinant.abs() > 12.0 * U * permanent + UNDERFLOW { determinant } else { 0.0 }
}

/// The proof for points whose coordinates are each wrong by at most 4 u `reach`, at a fraction of the cost: no
/// determinant is then wrong by more than 128 u reach^3, in f64 1e-14 of the box the points lie in.
///
/// With vectors no longer than `reach`, nine entries of 4 u each with a minor of at most reach^2 make 36 u reach^3, the
/// roundings of the products and sums another 10 u.
#[inline(always)]
pub(crate) fn encloses_origin_roughly<T: Real>(points: &[Vector3<T>; 4], reach: T) -> bool {
    let [p0, p1, p2, p3] = points;
    let (c01, c23) = (p0.cross(p1), p2.cross(p3));
    let determinants = [p1.dot(&c23), -p0.dot(&c23), p3.dot(&c01), -p2.dot(&c01)];
    let bound = T::ENCLOSING * reach * reach * reach + T::UNDERFLOW;
    determinants.iter().all(|&d| d > bound) || determinants.iter().all(|&d| d < -bound)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers of 53 bits from a generator after G. Marsaglia (xorshift64*).
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> u64 {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11
        }

        fn point(&mut self) -> [i128; 3] {
            [0; 3].map(|_| i128::from(self.next()))
        }
    }

    fn float(p: &[i128; 3]) -> Vec3 {
        Vec3::from_fn(|axis, _| p[axis] as f64)
    }

    fn dot(p: &[i128; 3], v: &[i128; 3]) -> i128 {
        (0..3).map(|axis| p[axis] * v[axis]).sum()
    }

    /// u of a sum of magnitudes, in the numbers' own units.
    fn u(sum: i128) -> i128 {
        sum >> 53
    }

    #[test]
    fn bodies_that_a_last_digit_of_their_coordinates_may_let_touch_are_not_separated() {
        let (mut numbers, mut nearest) = (Numbers(1), f64::NEG_INFINITY);
        for _ in 0..100_000 {
            let (a, b, v) = (numbers.point(), numbers.point(), numbers.point());
            let (top, bottom) = (dot(&a, &v), dot(&b, &v));
            // The least shift with which they might still touch, since each coordinate is known to u alone.
            let shift = (top - bottom + u(top + bottom + (top - bottom).abs())).div_euclid(v[0]) as f64;
            let along = shift as i128 * v[0];
            if bottom + along - top > u(top + bottom + along.abs()) {
                continue;
            }
            let (a, b, v, x) = (float(&a), float(&b), float(&v), Vec3::new(shift, 0.0, 0.0));
            assert!(!separates(&[a][..], &[b][..], &x, &v), "{a} {b} {x} {v}");
            let (top_of_a, top_of_b, along) = (highest(&a, &v), highest(&b, &-v), -highest(&-x, &v));
            let size = U * (top_of_a.abs() + top_of_b.abs() + along.abs());
            nearest = nearest.max((along - (top_of_a + top_of_b)) / size);
        }
        // With 4 u less, which is `doubt` on the wrong side, some are. `doubt` itself is room: the sixth u in `highest`
        // covers the rounding of the last sum.
        assert!((-4.0..0.0).contains(&nearest), "{nearest}");
    }

    #[test]
    fn a_shift_against_the_direction_separates_nothing_however_its_terms_cancel() {
        let (mut numbers, origin) = (Numbers(3), [Vec3::zeros()]);
        for _ in 0..10_000 {
            let (mut v, [x, y, _]) = (numbers.point(), numbers.point());
            v.sort_unstable();
            // Two terms of up to 2^105, and a third that leaves a last digit or less of their sum.
            let (x, y) = (x / 2, y / 2);
            let z = (x * v[0] + y * v[1]).div_euclid(v[2]) + 1;
            let shift = [x, y, -z];
            assert!((-v[2]..0).contains(&dot(&shift, &v)));
            assert!(!separates(&origin[..], &origin[..], &float(&shift), &float(&v)), "{shift:?} along {v:?}");
        }
    }

    #[test]
    fn heights_that_vanish_by_underflow_separate_nothing() {
        // Products of 0.48 and 0.6 of the least subnormal number: 0 and 1 of it.
        let least = 2f64.powi(-537);
        let v = Vec3::new(least, 0.0, 0.0);
        let (a, b, x) = (0.48 * v, -0.48 * v, 0.6 * v);
        assert_eq!([highest(&a, &v), highest(&b, &-v)], [0.0; 2]);
        assert!(-highest(&-x, &v) > 0.0);
        assert!(!separates(&[a][..], &[b][..], &x, &v), "a lies higher than b + x by 0.36 of it");
    }

    #[test]
    fn differences_that_were_rounded_twice_enclose_nothing_by_it() {
        let (mut numbers, mut misled) = (Numbers(2), 0);
        for _ in 0..20_000 {
            // Differences of 1 to 2 in steps of 2^-56, of which 2^-52 is left, and a shift that takes all but some
            // steps away.
            let unit = 2f64.powi(-56);
            let exact: [[i128; 3]; 4] = [0; 4].map(|_| [0; 3].map(|_| i128::from(numbers.next() % 400) - 200));
            let points = exact.map(|w| {
                let b = Vec3::from_fn(|axis, _| -(w[axis] as f64) * unit);
                Difference::new(&Vec3::repeat(1.5), &b, &Vec3::repeat(1.5))
            });
            let is_in = |points: &[[i128; 3]; 4]| {
                let [p0, p1, p2, p3] = points;
                let all = [det(p1, p2, p3), det(p0, p3, p2), det(p0, p1, p3), det(p0, p2, p1)];
                all.iter().all(|d| *d > 0) || all.iter().all(|d| *d < 0)
            };
            let found = encloses_origin(&points);
            assert!(!found || is_in(&exact));
            let rounded = points.map(|point| [0, 1, 2].map(|axis| (point.w[axis] / unit) as i128));
            misled += usize::from(is_in(&rounded) && !is_in(&exact));
        }
        assert!(misled > 100, "{misled}");
    }

    fn det(a: &[i128; 3], b: &[i128; 3], c: &[i128; 3]) -> i128 {
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    }
}
