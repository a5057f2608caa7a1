//! The body whose planes are y_i . x = 1, from the hull of the points y_i.

use super::{ACCURACY, OffsetError, ill_conditioned};
use crate::geometry::Polyhedron;
use crate::geometry::double_double::{Dd, Dd3, cross, dot};
use crate::geometry::hull::Facets;
use crate::math::Vec3;

/// Half an ulp of 1.
const ROUNDING: f64 = f64::EPSILON / 2.0;
/// Vertices closer than this many roundings of the body's extent are one.
const MERGED: f64 = 16.0;

/// Faces as loops of vertex indices, one after the other.
#[derive(Default)]
struct Loops {
    corners: Vec<u32>,
    /// One past the last corner of each face.
    ends: Vec<u32>,
}

/// The intersection of the half-spaces y . (x - center) <= 1.
pub(super) fn intersect(points: &[Vec3], center: &Vec3) -> Result<Polyhedron, OffsetError> {
    let scaled = normalised(points)?;
    let facets = Facets::of(&scaled.points)?;
    let mut vertices = Vec::with_capacity(2 * points.len());
    for facet in facets.iter() {
        vertices.push(vertex(&scaled.points, facet).ok_or_else(flat)?);
    }
    let (vertices, faces) = merged(vertices, loops_around(&facets, points.len()));
    let local = Polyhedron::from_lists(vertices.into(), &faces.corners, &faces.ends);
    if faces.ends.len() < 4 {
        return Err(flat());
    }
    check(&local, &(center * scaled.scale))?;
    let length = 1.0 / scaled.scale;
    let volume = local.volume() * length * length * length;
    Ok(local.mapped_to_volume(|v| center + v * length, volume))
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

/// For every dual point the loop of facets around it, counter-clockwise from outside; none for points inside.
fn loops_around(facets: &Facets, points: usize) -> Loops {
    let mut starts = vec![0_u32; points + 1];
    facets.iter().flatten().for_each(|&p| starts[p as usize + 1] += 1);
    for p in 0..points {
        starts[p + 1] += starts[p];
    }
    let mut next = starts.clone();
    // Successor and predecessor of the point in a facet, and the facet.
    let mut around = vec![(0, 0, 0); starts[points] as usize];
    for (f, facet) in (0..).zip(facets.iter()) {
        for (k, &p) in facet.iter().enumerate() {
            let (before, after) = (facet[(k + facet.len() - 1) % facet.len()], facet[(k + 1) % facet.len()]);
            around[next[p as usize] as usize] = (after, before, f);
            next[p as usize] += 1;
        }
    }
    let mut loops = Loops::default();
    for p in (0..points).filter(|&p| starts[p] < starts[p + 1]) {
        push_loop(&mut loops, &mut around[starts[p] as usize..starts[p + 1] as usize]);
    }
    loops
}

/// Around a point, the facet after this one starts where this one ends: its successor is this one's predecessor.
fn push_loop(loops: &mut Loops, around: &mut [(u32, u32, u32)]) {
    around.sort_unstable();
    let mut current = 0;
    for _ in 0..around.len() {
        let (_, before, facet) = around[current];
        loops.corners.push(facet);
        current = around.partition_point(|corner| corner.0 < before);
    }
    loops.ends.push(loops.corners.len() as u32);
}

impl Loops {
    fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(&start, &end)| &self.corners[start as usize..end as usize])
    }
}

/// Joins neighbouring vertices that rounding alone keeps apart; drops faces that lose their area by it.
fn merged(vertices: Vec<Vec3>, faces: Loops) -> (Vec<Vec3>, Loops) {
    let extent = vertices.iter().map(Vec3::norm).fold(0.0, f64::max);
    let mut same: Vec<u32> = (0..vertices.len() as u32).collect();
    let mut any = false;
    for face in faces.iter() {
        for (k, &v) in face.iter().enumerate() {
            let w = face[(k + 1) % face.len()];
            if (vertices[v as usize] - vertices[w as usize]).norm() <= MERGED * ROUNDING * extent {
                let (v, w) = (root(&same, v), root(&same, w));
                same[v.max(w) as usize] = v.min(w);
                any = true;
            }
        }
    }
    if any { without_doubles(&vertices, &faces, &same) } else { (vertices, faces) }
}

/// The faces over the first of each set of joined vertices.
fn without_doubles(vertices: &[Vec3], faces: &Loops, same: &[u32]) -> (Vec<Vec3>, Loops) {
    let (mut kept, mut loops) = (Vec::new(), Loops::default());
    let mut number = vec![u32::MAX; vertices.len()];
    for face in faces.iter() {
        let mut face: Vec<u32> = face.iter().map(|&v| root(same, v)).collect();
        face.dedup();
        if face.len() > 1 && face.first() == face.last() {
            face.pop();
        }
        if face.len() < 3 {
            continue;
        }
        for v in face {
            if number[v as usize] == u32::MAX {
                number[v as usize] = kept.len() as u32;
                kept.push(vertices[v as usize]);
            }
            loops.corners.push(number[v as usize]);
        }
        loops.ends.push(loops.corners.len() as u32);
    }
    (kept, loops)
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
