//! A body's planes, moved inwards and turned into the dual points about a centre.

use crate::geometry::double_double::{DD_EPSILON, Dd, Dd3, cross, dot};
use crate::geometry::integer;
use crate::math::Vec3;

/// The dual points n / (n . (a - center) - thickness |n|) of the planes through three `corners` each, in 1/mm, or
/// `None` where the centre is not certainly inside all planes.
pub(super) fn dual_points(corners: &[[Vec3; 3]], center: &Vec3, thickness: f64) -> Option<Vec<Vec3>> {
    if !center.iter().all(|x| x.is_finite()) {
        return None;
    }
    let point = |triangle| {
        double_double_point(triangle, center, thickness).or_else(|| exact_point(triangle, center, thickness))
    };
    let mut points = Vec::with_capacity(corners.len());
    for triangle in corners {
        points.push(point(triangle)?);
    }
    Some(points)
}

/// `None` where double-double cannot promise the point's every bit but the last.
fn double_double_point([a, b, c]: &[Vec3; 3], center: &Vec3, thickness: f64) -> Option<Vec3> {
    let difference = |p: &Vec3, q: &Vec3| -> Dd3 { [0, 1, 2].map(|k| Dd::difference(p[k], q[k])) };
    let (u, v, arm) = (difference(b, a), difference(c, a), difference(a, center));
    let normal = cross(&u, &v);
    let squared = dot(&normal, &normal);
    let height = dot(&normal, &arm) - squared.sqrt() * thickness;
    let (u, v, arm) = ((b - a).norm(), (c - a).norm(), (a - center).norm());
    // Each component of the normal errs by a few parts of |u| |v|, and with it height and norm.
    let error = 32.0 * DD_EPSILON * u * v * (arm + thickness);
    let certain = error < f64::EPSILON / 8.0 * height.value()
        && 32.0 * DD_EPSILON * u * v < f64::EPSILON / 8.0 * squared.sqrt().value();
    // Beyond these magnitudes the low parts could underflow.
    let in_range = (1e-200..1e200).contains(&squared.value()) && (1e-200..1e200).contains(&height.value());
    let inverse = height.recip();
    (certain && in_range).then(|| Vec3::from(normal.map(|n| (n * inverse).value())))
}

/// The same in integers; `None` where the height is not positive, or indistinguishable from 0 within 2^-128 of its
/// unit.
fn exact_point(corners: &[Vec3; 3], center: &Vec3, thickness: f64) -> Option<Vec3> {
    exact_point_in(&[Vec3::x(), Vec3::y(), Vec3::z()], corners, center, thickness)
}

/// The dual point in a frame: its products with the frame's `axes`, each exact until it is rounded.
pub(super) fn exact_point_in(axes: &[Vec3; 3], corners: &[Vec3; 3], center: &Vec3, thickness: f64) -> Option<Vec3> {
    const PRECISION: usize = 128;
    let coordinates = corners.iter().chain([center]).flat_map(|p| [p.x, p.y, p.z]);
    let unit = integer::unit_exponent(coordinates.chain([thickness]));
    let center = integer::to_integers(center, unit);
    let [a, b, c] = [0, 1, 2].map(|k| integer::minus(&integer::to_integers(&corners[k], unit), &center));
    let normal = integer::cross(&integer::minus(&b, &a), &integer::minus(&c, &a));
    let shift = integer::to_integer(thickness, unit);
    let shell = ((integer::dot(&normal, &normal) * &shift * &shift) << (2 * PRECISION)).sqrt();
    let height = (integer::dot(&normal, &a) << PRECISION) - shell;
    if height.sign() != num_bigint::Sign::Plus || height.bits() <= 60 {
        return None;
    }
    let axes_unit = integer::unit_exponent(axes.iter().flat_map(|p| [p.x, p.y, p.z]));
    let along = |axis: &Vec3| {
        let product = integer::dot(&normal, &integer::to_integers(axis, axes_unit)) << PRECISION;
        integer::quotient(&product, &height, axes_unit - unit)
    };
    Some(Vec3::from(axes.each_ref().map(along)))
}
