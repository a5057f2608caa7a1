//! The body whose planes are y_i . x = 1, from the hull of the points y_i.

use super::{ACCURACY, OffsetError, ill_conditioned};
use crate::geometry::Polyhedron;
use crate::geometry::double_double::{Dd, Dd3, cross, dot};
use crate::geometry::hull::Facets;
use crate::math::Vec3;

/// Half an ulp of 1.
const ROUNDING: f64 = f64::EPSILON / 2.0;
/// Vertices closer than so many roundings of the body's extent are one.
const MERGED: f64 = 16.0;

/// The intersection of the half-spaces y . (x - center) <= 1.
pub(super) fn intersect(points: &[Vec3], center: &Vec3) -> Result<Polyhedron, OffsetError> {
    let scaled = normalised(points)?;
    let facets = Facets::of(&scaled.points)?;
    let vertices: Vec<Vec3> =
        facets.iter().map(|facet| vertex(&scaled.points, facet)).collect::<Option<_>>().ok_or_else(flat)?;
    let faces = faces_around(&facets, points.len());
    let (vertices, faces) = merged(&vertices, faces);
    let local = Polyhedron::from_parts(vertices, &faces);
    if local.faces().len() < 4 {
        return Err(flat());
    }
    check(&local, &(center * scaled.scale))?;
    let placed = local.vertices().iter().map(|v| center + v / scaled.scale).collect();
    let length = 1.0 / scaled.scale;
    Ok(Polyhedron::from_parts(placed, &faces).with_volume(local.volume() * length * length * length))
}

fn flat() -> OffsetError {
    ill_conditioned("the planes, moved inwards, cannot be told apart in f64")
}

/// Dual points in a unit that makes the nearest plane about 1 away.
struct Scaled {
    points: Vec<Vec3>,
    /// Lengths are multiplied by this power of two.
    scale: f64,
}

/// Components too small to matter become 0, so that all are within the range of the exact predicates.
fn normalised(points: &[Vec3]) -> Result<Scaled, OffsetError> {
    let largest = points.iter().map(Vec3::amax).fold(0.0, f64::max);
    let smallest = points.iter().map(Vec3::amax).fold(f64::INFINITY, f64::min);
    // False for NaN, too.
    let in_range = smallest > largest * 1e-30 && largest < 1e150 && smallest > 1e-150;
    if !in_range {
        return Err(ill_conditioned("a plane is too far or too near to be resolved"));
    }
    let scale = libm::scalbn(1.0, libm::ilogb(largest));
    let negligible = smallest / scale * 1e-25;
    let scaled = |x: f64| if (x / scale).abs() < negligible { 0.0 } else { x / scale };
    Ok(Scaled { points: points.iter().map(|p| p.map(scaled)).collect(), scale })
}

/// The point z with y . z = 1 for all points y of the facet: m / (m . y) for the facet's normal m.
fn vertex(points: &[Vec3], facet: &[u32]) -> Option<Vec3> {
    let at = |i: u32| points[i as usize];
    let spread = |k: &usize| (at(facet[*k]) - at(facet[0])).cross(&(at(facet[k + 1]) - at(facet[0]))).norm_squared();
    let widest = (1..facet.len() - 1).max_by(|j, k| spread(j).total_cmp(&spread(k)))?;
    let [a, b, c] = [facet[0], facet[widest], facet[widest + 1]].map(at);
    let (u, v) = (b - a, c - a);
    let normal = u.cross(&v);
    let height = normal.dot(&a);
    let normal_error = 4.0 * ROUNDING * u.norm() * v.norm();
    let height_error = normal_error * a.norm() + 4.0 * ROUNDING * normal.norm() * a.norm();
    // Relative to |z| = |m| / height.
    let error = normal_error / normal.norm() + height_error / height;
    if height > 0.0 && error < 256.0 * ROUNDING { Some(normal / height) } else { double_double_vertex(&a, &b, &c) }
}

fn double_double_vertex(a: &Vec3, b: &Vec3, c: &Vec3) -> Option<Vec3> {
    let difference = |p: &Vec3, q: &Vec3| -> Dd3 { [0, 1, 2].map(|k| Dd::difference(p[k], q[k])) };
    let normal = cross(&difference(b, a), &difference(c, a));
    let height = dot(&normal, &[a.x, a.y, a.z].map(Dd::from));
    let magnitude = (b - a).norm() * (c - a).norm();
    let lost = 1e-27 * magnitude * a.norm() > 1e-15 * height.value();
    let inverse = height.recip();
    (!lost && height.value() > 0.0).then(|| Vec3::from(normal.map(|n| (n * inverse).value())))
}

/// For every dual point the facets around it, counter-clockwise from outside; empty for points that are not extreme.
fn faces_around(facets: &Facets, points: usize) -> Vec<Vec<u32>> {
    // Around a point, the facet after this one starts where this one ends: its successor is this one's predecessor.
    let mut corners: Vec<Vec<(u32, u32, u32)>> = vec![Vec::new(); points];
    for (f, facet) in (0..).zip(facets.iter()) {
        for k in 0..facet.len() {
            let (before, after) = (facet[(k + facet.len() - 1) % facet.len()], facet[(k + 1) % facet.len()]);
            corners[facet[k] as usize].push((after, before, f));
        }
    }
    corners.into_iter().map(cycle).collect()
}

fn cycle(mut corners: Vec<(u32, u32, u32)>) -> Vec<u32> {
    corners.sort_unstable();
    let mut current = 0;
    (0..corners.len())
        .map(|_| {
            let (_, before, facet) = corners[current];
            current = corners.partition_point(|corner| corner.0 < before);
            facet
        })
        .collect()
}

/// Joins neighbouring vertices that rounding alone keeps apart; drops faces that lose their area by it.
fn merged(vertices: &[Vec3], faces: Vec<Vec<u32>>) -> (Vec<Vec3>, Vec<Vec<u32>>) {
    let extent = vertices.iter().map(Vec3::norm).fold(0.0, f64::max);
    let mut same: Vec<u32> = (0..vertices.len() as u32).collect();
    for face in &faces {
        for (k, &v) in face.iter().enumerate() {
            let w = face[(k + 1) % face.len()];
            if (vertices[v as usize] - vertices[w as usize]).norm() <= MERGED * ROUNDING * extent {
                let (v, w) = (root(&same, v), root(&same, w));
                same[v.max(w) as usize] = v.min(w);
            }
        }
    }
    let mut kept = Vec::new();
    let mut number = vec![u32::MAX; vertices.len()];
    let faces = faces.into_iter().map(|face| {
        let mut face: Vec<u32> = face.into_iter().map(|v| root(&same, v)).collect();
        face.dedup();
        if face.len() > 1 && face.first() == face.last() {
            face.pop();
        }
        face
    });
    let mut faces: Vec<Vec<u32>> = faces.filter(|face| face.len() > 2).collect();
    for v in faces.iter_mut().flatten() {
        if number[*v as usize] == u32::MAX {
            number[*v as usize] = kept.len() as u32;
            kept.push(vertices[*v as usize]);
        }
        *v = number[*v as usize];
    }
    (kept, faces)
}

fn root(same: &[u32], mut v: u32) -> u32 {
    while same[v as usize] != v {
        v = same[v as usize];
    }
    v
}

/// The certificate: planes displaced by a few roundings of the extent change the volume by no more than that times
/// area over volume. Rounding the vertices about the centre costs as much again.
fn check(local: &Polyhedron, center: &Vec3) -> Result<(), OffsetError> {
    let extent = local.vertices().iter().map(Vec3::norm).fold(0.0, f64::max);
    let slenderness = local.area() / local.volume();
    let accurate = 4.0 * ROUNDING * extent * slenderness < ACCURACY;
    if !accurate {
        return Err(ill_conditioned("what is left is too thin for its volume to be right to 1e-9"));
    }
    // A body far from the origin keeps its volume; but its vertices must still show its shape.
    let resolved = ROUNDING * center.amax() * slenderness < 1e-3;
    if !resolved {
        return Err(ill_conditioned("what is left is smaller than the spacing of f64 numbers there"));
    }
    Ok(())
}
