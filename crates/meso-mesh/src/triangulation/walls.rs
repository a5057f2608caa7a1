//! The surface of a specimen as triangles. The nodes lie on a curved surface, and no point of a triangle is farther than
//! [`CHORD_MM`] from it.

use super::facets::{LONGEST, facets, refined};
use super::{Triangles, Untriangulated};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::specimen::{Container, Specimen, Surface};
use std::collections::BTreeMap;

/// The surface of `specimen`, whose container is `container`, with edges of about `size` mm, counter-clockwise from outside: plane
/// faces exactly, curved ones by triangles whose nodes lie on them.
///
/// # Errors
/// Fails like [`facets`].
pub(crate) fn walls(specimen: &Specimen, container: &dyn Container, size: f64) -> Result<Triangles, Untriangulated> {
    match (specimen, polygons(specimen, container, size)) {
        (_, Some(Surface { points, faces })) => facets(&points, faces, LONGEST * size),
        (Specimen::Sphere { diameter_mm }, None) => Ok(sphere(*diameter_mm, size)),
        (_, None) => Ok(grid(&container.aabb(), size)),
    }
}

/// The walls as plane faces; boxes have a [`grid`] of their own, and spheres have none.
pub(crate) fn polygons(specimen: &Specimen, container: &dyn Container, size: f64) -> Option<Surface> {
    match *specimen {
        Specimen::Sphere { .. } => None,
        Specimen::Cylinder { diameter_mm, height_mm } => Some(prism(diameter_mm, height_mm, size)),
        _ if container.is_box() => None,
        _ => Some(container.surface()),
    }
}

/// How far the triangles of [`walls`] may lie inside the specimen's surface, mm.
pub(crate) fn chord(specimen: &Specimen) -> f64 {
    match specimen {
        Specimen::Cylinder { .. } | Specimen::Sphere { .. } => CHORD_MM,
        _ => 0.0,
    }
}

/// A box' faces as triangles of a grid, opposite faces alike: moved along its axis, one lies node on node on the other.
fn grid(domain: &Aabb, size: f64) -> Triangles {
    let counts = [0, 1, 2].map(|i| (domain.size()[i] / size).round().max(1.0) as usize);
    let mut walls = Triangles::default();
    let mut numbers = BTreeMap::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for upper in [false, true] {
            for (i, j) in (0..counts[u]).flat_map(|i| (0..counts[v]).map(move |j| (i, j))) {
                let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                    let mut at = [0; 3];
                    (at[axis], at[u], at[v]) = (if upper { counts[axis] } else { 0 }, i + di, j + dj);
                    *numbers.entry(at).or_insert_with(|| {
                        walls.points.push(position(domain, counts, at));
                        walls.points.len() as u32 - 1
                    })
                });
                walls.triangles.extend(if upper { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] });
            }
        }
    }
    walls
}

fn position(domain: &Aabb, counts: [usize; 3], at: [usize; 3]) -> Vec3 {
    Vec3::from_fn(|axis, _| {
        if at[axis] == counts[axis] {
            domain.max[axis]
        } else {
            domain.min[axis] + domain.size()[axis] * at[axis] as f64 / counts[axis] as f64
        }
    })
}

/// Well within the least gap that is advised between bodies and walls, 0.05 mm.
const CHORD_MM: f64 = 0.02;

/// The sphere that touches the coordinate planes, from an octahedron.
fn sphere(diameter: f64, size: f64) -> Triangles {
    let radius = diameter / 2.0;
    let centre = Vec3::repeat(radius);
    let points = [Vec3::x(), Vec3::y(), -Vec3::x(), -Vec3::y(), Vec3::z(), -Vec3::z()].map(|arm| centre + arm * radius);
    let caps = |i: u32| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]];
    let triangles = (0..4).flat_map(caps).map(|triangle| (triangle, 0));
    refined(points.to_vec(), triangles, longest(radius, size), |_, position| {
        let arm = position - centre;
        centre + arm * (radius / arm.norm())
    })
}

/// The prism in the upright cylinder on z = 0 that touches the other coordinate planes, as fine as elements of `size` mm.
fn prism(diameter: f64, height: f64, size: f64) -> Surface {
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
