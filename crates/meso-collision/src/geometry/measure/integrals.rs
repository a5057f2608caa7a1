//! The volume of a closed triangulated surface to 1e-14, however thin or far away the body is.
//!
//! The sum of n . (a - apex) over all triangles (a, b, c), n = (b - a) x (c - a), is six times the volume, for any
//! apex. With the apex in the middle of a convex body no term is negative and n nearly along a - apex, so little
//! cancels: the terms' rounding is bounded beside the sum, and where the bound is too large the sum is taken in
//! double-double, then in integers.

use crate::geometry::exact::double_double::{DD_EPSILON, Dd};
use crate::geometry::exact::integer;
use crate::geometry::measure::facet_kernels::SixVolumes;
use crate::geometry::measure::sum::Sum;
use crate::geometry::measure::tetrahedron::{double_double_term, float_term};
use crate::math::Vec3;
use crate::simd::widest;
use num_bigint::BigInt;

/// Promised relative error of the volume.
const ACCURACY: f64 = 1e-14;

/// The volume within the triangles over `vertices`, counter-clockwise from outside, in the cube of their unit.
///
/// NaN where a vertex is not finite.
pub(crate) fn volume(vertices: &[Vec3], triangles: impl Iterator<Item = [u32; 3]> + Clone) -> f64 {
    let corners = triangles.map(|t| t.map(|i| vertices[i as usize]));
    summed(vertices, corners.clone(), |apex| float_sum(apex, corners))
}

/// [`volume`] where few vertices need no more than a byte to be named: eight triangles at a time.
pub(crate) fn volume_of_few(vertices: &[Vec3], triangles: &[[u8; 3]]) -> f64 {
    let corners = triangles.iter().map(|t| t.map(|i| vertices[usize::from(i)]));
    summed(vertices, corners, |&apex| widest(SixVolumes { apex, vertices, triangles }).bounded())
}

/// A sixth of the sum that `in_floats` gives from an apex, with an error bound, or of a better sum where that is
/// needed.
fn summed(
    vertices: &[Vec3],
    corners: impl Iterator<Item = [Vec3; 3]> + Clone,
    in_floats: impl FnOnce(&Vec3) -> (f64, f64),
) -> f64 {
    let apex = vertices.iter().sum::<Vec3>() / vertices.len().max(1) as f64;
    if !apex.iter().all(|x| x.is_finite()) {
        return f64::NAN;
    }
    let (sum, error) = in_floats(&apex);
    if error <= 0.9 * ACCURACY * sum {
        return sum / 6.0;
    }
    let (sum, error) = double_double_sum(&apex, corners.clone());
    if error <= 0.9 * ACCURACY * sum { sum / 6.0 } else { exact_volume(&apex, corners) }
}

/// Six volumes and a bound of the error.
fn float_sum(apex: &Vec3, corners: impl Iterator<Item = [Vec3; 3]>) -> (f64, f64) {
    let mut sum = Sum::default();
    for triangle in corners {
        let (term, magnitude) = float_term(apex, &triangle);
        sum.add(term, magnitude);
    }
    sum.bounded()
}

fn double_double_sum(apex: &Vec3, corners: impl Iterator<Item = [Vec3; 3]>) -> (f64, f64) {
    let (mut sum, mut magnitude, mut count) = (Dd::ZERO, 0.0, 0.0);
    for [a, b, c] in corners {
        sum = sum + double_double_term(apex, &[a, b, c]);
        magnitude += (b - a).abs().sum() * (c - a).abs().sum() * (a - apex).abs().sum();
        count += 1.0;
    }
    (sum.value(), (10.0 + count) * DD_EPSILON * magnitude)
}

fn exact_volume(apex: &Vec3, corners: impl Iterator<Item = [Vec3; 3]> + Clone) -> f64 {
    let coordinates = corners.clone().flatten().chain([*apex]).flat_map(|p| [p.x, p.y, p.z]);
    let unit = integer::unit_exponent(coordinates);
    let apex = integer::to_integers(apex, unit);
    let relative = |p: Vec3| integer::minus(&integer::to_integers(&p, unit), &apex);
    let six: BigInt = corners
        .map(|t| {
            let [a, b, c] = t.map(relative);
            integer::dot(&a, &integer::cross(&b, &c))
        })
        .sum();
    integer::quotient(&six, &BigInt::from(6), 3 * unit)
}
