//! The specimen's own surface as triangles.

use super::facets::{LONGEST, Triangles, facets};
use super::round;
use crate::math::{Aabb, Vec3};
use crate::mesh::MeshError;
use crate::packing::{Container, Specimen, Surface};
use std::collections::BTreeMap;

/// The surface of `specimen`, whose room is `room`, with edges of about `size` mm, counter-clockwise from outside: plane
/// faces exactly, curved ones by triangles whose nodes lie on them.
///
/// # Errors
/// As [`facets`].
pub(super) fn walls(specimen: &Specimen, room: &dyn Container, size: f64) -> Result<Triangles, MeshError> {
    match (specimen, polygons(specimen, room, size)) {
        (_, Some(Surface { points, faces })) => facets(&points, faces, LONGEST * size),
        (Specimen::Sphere { diameter_mm }, None) => Ok(round::sphere(*diameter_mm, size)),
        (_, None) => Ok(grid(&room.aabb(), size)),
    }
}

/// The same as plane faces; boxes have their own ([`grid`], and [`boxes`](super::boxes)), and spheres have none.
pub(super) fn polygons(specimen: &Specimen, room: &dyn Container, size: f64) -> Option<Surface> {
    match *specimen {
        Specimen::Sphere { .. } => None,
        Specimen::Cylinder { diameter_mm, height_mm } => Some(round::prism(diameter_mm, height_mm, size)),
        _ if room.is_box() => None,
        _ => Some(room.surface()),
    }
}

/// How far the triangles of [`walls`] may lie inside the specimen's surface, mm.
pub(super) fn chord(specimen: &Specimen) -> f64 {
    match specimen {
        Specimen::Cylinder { .. } | Specimen::Sphere { .. } => round::CHORD_MM,
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
