//! A body's planes, moved inwards and turned into the dual points about a centre.

use crate::geometry::exact::double_double::{DD_EPSILON, Dd, Dd3, cross, dot};
use crate::geometry::exact::integer;
use crate::math::Vec3;
use crate::simd::{Wide, widest};

/// Planes looked at together.
const LANES: usize = 8;

/// The dual points n / (n . (a - center) - thickness |n|) of the planes through three `corners` each, in 1/mm, or
/// `None` where the centre is not certainly inside all planes.
pub(super) fn dual_points(corners: &[[Vec3; 3]], center: &Vec3, thickness: f64) -> Option<Vec<Vec3>> {
    let is_finite = center.iter().all(|x| x.is_finite());
    is_finite.then(|| widest(DualPoints { corners, center: *center, thickness })).flatten()
}

/// Polar points, eight at a time in double-double, and in integers where that cannot promise every bit but the last.
struct DualPoints<'a> {
    corners: &'a [[Vec3; 3]],
    center: Vec3,
    thickness: f64,
}

impl Wide for DualPoints<'_> {
    type Output = Option<Vec<Vec3>>;

    #[inline(always)]
    fn run(self) -> Option<Vec<Vec3>> {
        let Self { corners, center, thickness } = self;
        let mut points = Vec::with_capacity(corners.len());
        // By corner, axis and lane.
        let mut eight = [[[0.0; LANES]; 3]; 3];
        for some in corners.chunks(LANES) {
            for (lane, triangle) in some.iter().enumerate() {
                for (corner, point) in triangle.iter().enumerate() {
                    (0..3).for_each(|axis| eight[corner][axis][lane] = point[axis]);
                }
            }
            let (found, certain) = double_double_points(&eight, &center, thickness);
            for (lane, triangle) in some.iter().enumerate() {
                points.push(match certain[lane] {
                    1 => Vec3::new(found[0][lane], found[1][lane], found[2][lane]),
                    _ => exact_point(triangle, &center, thickness)?,
                });
            }
        }
        Some(points)
    }
}

/// The points by axis, and 1 for each that is certain.
#[inline(always)]
fn double_double_points(
    [a, b, c]: &[[[f64; LANES]; 3]; 3],
    center: &Vec3,
    thickness: f64,
) -> ([[f64; LANES]; 3], [u64; LANES]) {
    let (mut points, mut certain) = ([[0.0; LANES]; 3], [0; LANES]);
    let at = |corner: &[[f64; LANES]; 3], lane: usize| Vec3::new(corner[0][lane], corner[1][lane], corner[2][lane]);
    for lane in 0..LANES {
        let (point, is_certain) = double_double_point([at(a, lane), at(b, lane), at(c, lane)], center, thickness);
        [points[0][lane], points[1][lane], points[2][lane]] = point;
        certain[lane] = u64::from(is_certain);
    }
    (points, certain)
}

/// The point, and whether double-double promises its every bit but the last. Without a branch.
#[inline(always)]
fn double_double_point([a, b, c]: [Vec3; 3], center: &Vec3, thickness: f64) -> ([f64; 3], bool) {
    let difference =
        |p: &Vec3, q: &Vec3| -> Dd3 { [Dd::difference(p.x, q.x), Dd::difference(p.y, q.y), Dd::difference(p.z, q.z)] };
    let (u, v, arm) = (difference(&b, &a), difference(&c, &a), difference(&a, center));
    let normal = cross(&u, &v);
    let squared = dot(&normal, &normal);
    let height = dot(&normal, &arm) - squared.sqrt() * thickness;
    let (u, v, arm) = ((b - a).norm(), (c - a).norm(), (a - center).norm());
    // Each component of the normal errs by a few parts of |u| |v|, and with it height and norm.
    let error = 32.0 * DD_EPSILON * u * v * (arm + thickness.abs());
    let certain = (error < f64::EPSILON / 8.0 * height.value())
        & (32.0 * DD_EPSILON * u * v < f64::EPSILON / 8.0 * squared.sqrt().value());
    // Beyond these magnitudes the low parts could underflow.
    let in_range = |x: f64| (1e-200..1e200).contains(&x);
    let certain = certain & in_range(squared.value()) & in_range(height.value());
    let inverse = height.recip();
    let [x, y, z] = normal;
    ([(x * inverse).value(), (y * inverse).value(), (z * inverse).value()], certain)
}

/// Finds the polar point in integers; `None` where the height is not positive, or indistinguishable from 0 within
/// 2^-128 of its unit.
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
    let shell = if thickness < 0.0 { -shell } else { shell };
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The polar point of the plane y a + b + c = y^2 + 1, moved inwards by y, about the origin.
    fn dual_point(y: u64) -> Option<Vec3> {
        let y = y as f64;
        let corners = [[y, 1.0, 0.0], [y + 1.0, 1.0 - y, 0.0], [y, 2.0, -1.0]].map(Vec3::from);
        dual_points(&[corners], &Vec3::zeros(), y).map(|points| points[0])
    }

    #[test]
    fn a_dual_point_has_every_bit_but_the_last_or_there_is_none() {
        // Pell's equation, (y^2 + 1)^2 - y^2 (y^2 + 2) = 1: y^2 + 1 - y sqrt(y^2 + 2) is left, which for y above 10^4
        // is 1 / (2 y^2 + 2) to every bit. From 2^34 on it lies below 2^-68 of the coordinates' unit.
        let larger = |y: &u64| Some(y * 5 / 4);
        let ys: Vec<u64> = std::iter::successors(Some(10_000), larger).take_while(|y| *y < 1 << 42).collect();
        let mut found = 0;
        for (y, point) in ys.iter().filter_map(|&y| dual_point(y).map(|point| (u128::from(y), point))) {
            let inverse = 2 * (y * y + 1);
            let truth = [y * inverse, inverse, inverse].map(|x| x as f64);
            for (x, truth) in point.iter().zip(truth) {
                assert!((truth.next_down()..=truth.next_up()).contains(x), "{y}: {x:e} for {truth:e}");
            }
            found += 1;
        }
        assert!(found > 60 && found < ys.len(), "{found} of {}", ys.len());
    }
}
