//! Six times the volume of the tetrahedron between an apex and a triangle (a, b, c): n . (a - apex) with
//! n = (b - a) x (c - a).

use crate::geometry::exact::double_double::{self, Dd, Dd3};
use crate::geometry::measure::sum::TERM_ERROR;
use crate::math::Vec3;

/// Six times the volume of the tetrahedron from `apex` over a triangle, to 1e-12 unless it is nearly nothing.
pub(crate) fn six_volumes(apex: &Vec3, corners: &[Vec3; 3]) -> f64 {
    let (term, magnitude) = float_term(apex, corners);
    if is_close(term, magnitude) { term } else { double_double_term(apex, corners).value() }
}

/// True where a term of this magnitude is right to 1e-12.
#[inline(always)]
pub(crate) fn is_close(term: f64, magnitude: f64) -> bool {
    TERM_ERROR * magnitude <= 1e-12 * term.abs()
}

/// A term, and the sum of the magnitudes of its six products.
#[inline(always)]
pub(crate) fn float_term(apex: &Vec3, [a, b, c]: &[Vec3; 3]) -> (f64, f64) {
    let (u, v, w) = (b - a, c - a, a - apex);
    let [p, q] = [u.yzx().component_mul(&v.zxy()), u.zxy().component_mul(&v.yzx())];
    ((p - q).dot(&w), (p.abs() + q.abs()).dot(&w.abs()))
}

/// A term in double-double.
pub(crate) fn double_double_term(apex: &Vec3, [a, b, c]: &[Vec3; 3]) -> Dd {
    let difference = |p: &Vec3, q: &Vec3| -> Dd3 { [0, 1, 2].map(|k| Dd::difference(p[k], q[k])) };
    let normal = double_double::cross(&difference(b, a), &difference(c, a));
    double_double::dot(&normal, &difference(a, apex))
}
