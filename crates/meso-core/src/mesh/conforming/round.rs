//! Curved walls as triangles: their nodes lie on the wall, and nothing of them is farther than [`CHORD_MM`] from it.

use super::facets::{LONGEST, Triangles, refined};
use crate::math::Vec3;

/// Well within the least gap that is advised between grains and walls, 0.05 mm.
pub(super) const CHORD_MM: f64 = 0.02;

/// Facets of the prism that a cylinder's surface begins with.
const SIDES: u32 = 6;
const BOTTOM: u32 = 0;
const TOP: u32 = 1;
const MANTLE: u32 = 2;

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

/// The upright cylinder on z = 0 that touches the other coordinate planes, from a prism.
pub(super) fn cylinder(diameter: f64, height: f64, size: f64) -> Triangles {
    let radius = diameter / 2.0;
    let on_the_mantle = |place: Vec3| {
        let arm = Vec3::new(place.x - radius, place.y - radius, 0.0);
        let out = arm * (radius / arm.norm());
        Vec3::new(radius + out.x, radius + out.y, place.z)
    };
    let ring = |z: f64| {
        (0..SIDES).map(move |i| {
            let angle = f64::from(i) * (std::f64::consts::TAU / f64::from(SIDES));
            Vec3::new(radius + radius * libm::cos(angle), radius + radius * libm::sin(angle), z)
        })
    };
    let of_side = |i: u32| {
        let (j, up) = ((i + 1) % SIDES, SIDES);
        [([i, j, j + up], MANTLE), ([i, j + up, i + up], MANTLE)]
    };
    let of_ends = |i: u32| [([0, i + 1, i], BOTTOM), ([SIDES, SIDES + i, SIDES + i + 1], TOP)];
    let triangles = (0..SIDES).flat_map(of_side).chain((1..SIDES - 1).flat_map(of_ends));
    let points = ring(0.0).chain(ring(height)).map(on_the_mantle).collect();
    refined(points, triangles, longest(radius, size), |facet, place| match facet {
        MANTLE => on_the_mantle(place),
        _ => place,
    })
}

/// The longest edge on a wall of `radius`, mm: the middle of a triangle with edges l is l^2 / 6 radius off a sphere.
fn longest(radius: f64, size: f64) -> f64 {
    (LONGEST * size).min((6.0 * radius * CHORD_MM).sqrt())
}
