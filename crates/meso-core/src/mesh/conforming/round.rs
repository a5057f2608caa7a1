//! Curved walls as triangles: their nodes lie on the wall, and nothing of them is farther than [`CHORD_MM`] from it.

use super::facets::{LONGEST, Triangles, refined};
use crate::math::Vec3;
use crate::packing::Surface;

/// Well within the least gap that is advised between grains and walls, 0.05 mm.
pub(super) const CHORD_MM: f64 = 0.02;

/// The sphere that touches the coordinate planes, from an octahedron.
pub(super) fn sphere(diameter: f64, size: f64) -> Triangles {
    let radius = diameter / 2.0;
    let centre = Vec3::repeat(radius);
    let points = [Vec3::x(), Vec3::y(), -Vec3::x(), -Vec3::y(), Vec3::z(), -Vec3::z()].map(|arm| centre + arm * radius);
    let caps = |i: u32| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]];
    let triangles = (0..4).flat_map(caps).map(|triangle| (triangle, 0));
    refined(points.to_vec(), triangles, longest(radius, size), |_, place| {
        let arm = place - centre;
        centre + arm * (radius / arm.norm())
    })
}

/// The prism in the upright cylinder on z = 0 that touches the other coordinate planes, as fine as elements of `size` mm.
pub(super) fn prism(diameter: f64, height: f64, size: f64) -> Surface {
    let radius = diameter / 2.0;
    let sides = (std::f64::consts::TAU * radius / longest(radius, size)).ceil().max(6.0) as u32;
    let ring = |z: f64| {
        (0..sides).map(move |i| {
            let angle = f64::from(i) * (std::f64::consts::TAU / f64::from(sides));
            Vec3::new(radius + radius * libm::cos(angle), radius + radius * libm::sin(angle), z)
        })
    };
    let ends = [(0..sides).rev().collect(), (sides..2 * sides).collect()];
    let side = |i: u32| (i, (i + 1) % sides);
    let mantle = (0..sides).map(side).map(|(i, j)| vec![i, j, j + sides, i + sides]);
    Surface { points: ring(0.0).chain(ring(height)).collect(), faces: ends.into_iter().chain(mantle).collect() }
}

/// The longest edge on a wall of `radius`, mm: the middle of a triangle with edges l is l^2 / 6 radius off a sphere.
fn longest(radius: f64, size: f64) -> f64 {
    (LONGEST * size).min((6.0 * radius * CHORD_MM).sqrt())
}
