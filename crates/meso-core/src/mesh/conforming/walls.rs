//! The specimen's own surface as triangles.

use super::facets::{LONGEST, Triangles, refined};
use super::round;
use crate::math::{Aabb, Vec3};
use crate::packing::{Room, Specimen, Surface};
use std::collections::BTreeMap;

/// The surface of `specimen`, whose room is `room`, with edges of about `size` mm, counter-clockwise from outside: plane
/// faces exactly, curved ones by triangles whose nodes lie on them.
pub(super) fn walls(specimen: &Specimen, room: &dyn Room, size: f64) -> Triangles {
    match *specimen {
        Specimen::Cylinder { diameter_mm, height_mm } => round::cylinder(diameter_mm, height_mm, size),
        Specimen::Sphere { diameter_mm } => round::sphere(diameter_mm, size),
        _ if room.is_box() => grid(&room.aabb(), size),
        _ => {
            let Surface { points, faces } = room.surface();
            polygons(points, &faces, LONGEST * size, |place| place)
        }
    }
}

/// How far the triangles of [`walls`] may lie inside the specimen's surface, mm.
pub(super) fn chord(specimen: &Specimen) -> f64 {
    match specimen {
        Specimen::Cylinder { .. } | Specimen::Sphere { .. } => round::CHORD_MM,
        _ => 0.0,
    }
}

/// Polygons as triangles with no edge longer than `limit` mm; new nodes go `onto` their place.
pub(super) fn polygons(points: Vec<Vec3>, faces: &[Vec<u32>], limit: f64, onto: impl Fn(Vec3) -> Vec3) -> Triangles {
    let fans = faces.iter().map(|face| fan(&points, face)).collect::<Vec<_>>();
    let triangles = (0..).zip(fans).flat_map(|(facet, fan)| fan.into_iter().map(move |triangle| (triangle, facet)));
    refined(points, triangles, limit, |_, place| onto(place))
}

/// The fan of a polygon whose smallest triangle is largest: a corner in the middle of a side must not begin it.
fn fan(points: &[Vec3], face: &[u32]) -> Vec<[u32; 3]> {
    let from = |apex: usize| -> Vec<[u32; 3]> {
        let at = |k: usize| face[(apex + k) % face.len()];
        (2..face.len()).map(|k| [at(0), at(k - 1), at(k)]).collect()
    };
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| points[i as usize]);
        (b - a).cross(&(c - a)).norm()
    };
    let smallest = |fan: &[[u32; 3]]| fan.iter().map(area).fold(f64::INFINITY, f64::min);
    let fans = (0..face.len()).map(from);
    fans.max_by(|a, b| smallest(a).total_cmp(&smallest(b))).unwrap_or_default()
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
