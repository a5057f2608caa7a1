//! The body whose planes are y_i . x = 1, from the hull of the points y_i.

use super::{ACCURACY, OffsetError, ROUNDING, ill_conditioned};
use crate::geometry::exact::double_double::{Dd, Dd3, cross, dot};
use crate::geometry::exact::integer;
use crate::geometry::hull::{Loops, facets_and_dual, pairs};
use crate::geometry::measure::facet_kernels::{AHEAD, LANES};
use crate::geometry::{Polyhedron, convex_hull};
use crate::math::Vec3;
use crate::simd::{Wide, widest};

/// Vertices closer than this many roundings of the body's extent are one.
const MERGED: f64 = 16.0;

/// The intersection of the half-spaces y . x <= 1, about its centre.
pub(super) struct Dual {
    /// In units of [`Dual::unit`]; some of them may be one but for rounding.
    vertices: Vec<Vec3>,
    faces: Loops,
    scale: f64,
}

impl Dual {
    /// From the points y.
    pub(super) fn of(points: &[Vec3]) -> Result<Self, OffsetError> {
        let scaled = normalised(points)?;
        let [facets, faces] = facets_and_dual(&scaled.points)?;
        let vertices = widest(Vertices { points: &scaled.points, facets: &facets }).ok_or_else(flat)?;
        Ok(Self { vertices, faces, scale: scaled.scale })
    }

    pub(super) fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// The length of 1 in these coordinates.
    pub(super) fn unit(&self) -> f64 {
        1.0 / self.scale
    }

    /// The solid, where its volume is right to [`ACCURACY`].
    pub(super) fn body(&self) -> Option<Polyhedron> {
        let Some(joined) = self.joined() else {
            let whole = Polyhedron::from_lists(self.vertices.as_slice().into(), &self.faces.corners, &self.faces.ends);
            return is_accurate(&whole, 0.0).then_some(whole);
        };
        if is_surface(&joined.faces) {
            let body = Polyhedron::from_lists(joined.vertices.into(), &joined.faces.corners, &joined.faces.ends);
            if is_accurate(&body, joined.moved) {
                return Some(body);
            }
        }
        // Faces narrower than rounding may close upon themselves when their corners are joined: then the corners
        // decide.
        convex_hull(&self.vertices).ok().filter(|hull| is_accurate(hull, 0.0))
    }
}

fn flat() -> OffsetError {
    ill_conditioned("the planes, moved inwards, cannot be distinguished in f64")
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
    // A power of two as well: products with it are quotients by the other, to the last bit.
    let inverse = 1.0 / scale;
    let negligible = smallest * inverse * 1e-25;
    let scaled = |x: f64| if (x * inverse).abs() < negligible { 0.0 } else { x * inverse };
    Ok(Scaled { points: points.iter().map(|p| p.map(scaled)).collect(), scale })
}

/// For every facet the point z with y . z = 1 for all its points y: m / (m . y) for its normal m.
struct Vertices<'a> {
    points: &'a [Vec3],
    facets: &'a Loops,
}

impl Wide for Vertices<'_> {
    type Output = Option<Vec<Vec3>>;

    #[inline(always)]
    fn run(self) -> Option<Vec<Vec3>> {
        let Self { points, facets } = self;
        let mut vertices = Vec::with_capacity(facets.len());
        // Eights of facets, by corner, axis and lane.
        let mut eights = [[[[0.0; LANES]; 3]; 3]; AHEAD];
        for first in (0..facets.len()).step_by(AHEAD * LANES) {
            let many = first..facets.len().min(first + AHEAD * LANES);
            for f in many.clone() {
                let (eight, lane) = (&mut eights[(f - first) / LANES], f % LANES);
                for (corner, i) in eight.iter_mut().zip(widest_triangle(points, facets.face(f))) {
                    let point = &points[i as usize];
                    (corner[0][lane], corner[1][lane], corner[2][lane]) = (point.x, point.y, point.z);
                }
            }
            for (eight, start) in eights.iter().zip(many.clone().step_by(LANES)) {
                let (found, certain) = float_vertices(eight);
                for lane in 0..LANES.min(many.end - start) {
                    vertices.push(match certain[lane] {
                        1 => Vec3::new(found[0][lane], found[1][lane], found[2][lane]),
                        _ => close_vertex(points, facets.face(start + lane))?,
                    });
                }
            }
        }
        Some(vertices)
    }
}

/// Sums over the fan of a facet's triangles.
#[inline(always)]
fn widest_triangle(points: &[Vec3], facet: &[u32]) -> [u32; 3] {
    if let &[a, b, c] = facet {
        return [a, b, c];
    }
    let at = |i: u32| points[i as usize];
    let spread = |k: &usize| (at(facet[*k]) - at(facet[0])).cross(&(at(facet[k + 1]) - at(facet[0]))).norm_squared();
    let widest = (1..facet.len() - 1).max_by(|j, k| spread(j).total_cmp(&spread(k))).unwrap_or(1);
    [facet[0], facet[widest], facet[widest + 1]]
}

/// The points by axis, and 1 for each that is certain.
#[inline(always)]
fn float_vertices([a, b, c]: &[[[f64; LANES]; 3]; 3]) -> ([[f64; LANES]; 3], [u64; LANES]) {
    let (mut points, mut certain) = ([[0.0; LANES]; 3], [0; LANES]);
    let at = |corner: &[[f64; LANES]; 3], lane: usize| Vec3::new(corner[0][lane], corner[1][lane], corner[2][lane]);
    for lane in 0..LANES {
        let (a, b, c) = (at(a, lane), at(b, lane), at(c, lane));
        let (u, v) = (b - a, c - a);
        let normal = u.cross(&v);
        let height = normal.dot(&a);
        let normal_error = 4.0 * ROUNDING * u.norm() * v.norm();
        let height_error = normal_error * a.norm() + 4.0 * ROUNDING * normal.norm() * a.norm();
        // Relative to |z| = |m| / height.
        let error = normal_error / normal.norm() + height_error / height;
        [points[0][lane], points[1][lane], points[2][lane]] = (normal / height).into();
        certain[lane] = u64::from((height > 0.0) & (error < 256.0 * ROUNDING));
    }
    (points, certain)
}

/// Finds the vertex of one facet, to more digits.
#[cold]
fn close_vertex(points: &[Vec3], facet: &[u32]) -> Option<Vec3> {
    let corners = widest_triangle(points, facet).map(|i| points[i as usize]);
    let [a, b, c] = &corners;
    double_double_vertex(a, b, c).or_else(|| exact_vertex(&corners))
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

/// Finds the vertex in integers, for planes that are one but for rounding.
fn exact_vertex(corners: &[Vec3; 3]) -> Option<Vec3> {
    let unit = integer::unit_exponent(corners.iter().flat_map(|p| [p.x, p.y, p.z]));
    let [a, b, c] = corners.map(|p| integer::to_integers(&p, unit));
    let normal = integer::cross(&integer::minus(&b, &a), &integer::minus(&c, &a));
    let height = integer::dot(&normal, &a);
    let inside = height.sign() == num_bigint::Sign::Plus;
    inside.then(|| Vec3::from(normal.map(|n| integer::quotient(&n, &height, -unit))))
}

/// True where the faces close a surface: every edge is passed once in each direction.
fn is_surface(faces: &Loops) -> bool {
    let mut edges: Vec<[u32; 2]> = Vec::with_capacity(faces.corners.len());
    for face in faces.iter() {
        edges.extend(pairs(face).map(|(a, b)| [a, b]));
    }
    edges.sort_unstable();
    let once = edges.windows(2).all(|pair| pair[0] != pair[1]);
    faces.len() >= 4 && once && edges.iter().all(|[a, b]| edges.binary_search(&[*b, *a]).is_ok())
}

/// A body whose vertices were joined.
struct MergedBody {
    vertices: Vec<Vec3>,
    faces: Loops,
    /// The farthest that a vertex went.
    moved: f64,
}

impl Dual {
    /// Joins neighbouring vertices that rounding alone keeps apart; `None` where there are none.
    fn joined(&self) -> Option<MergedBody> {
        let Self { vertices, faces, .. } = self;
        let reach = MERGED * ROUNDING * extent(vertices);
        let squared = |&(v, w): &(u32, u32)| (vertices[v as usize] - vertices[w as usize]).norm_squared();
        // No root, and no branch that depends on the edge: nearly all bodies have no edge this short.
        let mut may_be_near = false;
        for face in faces.iter() {
            pairs(face).for_each(|edge| may_be_near |= squared(&edge) <= 1.01 * reach * reach);
        }
        if !may_be_near {
            return None;
        }
        // Each edge belongs to two faces.
        let is_near = |edge: &(u32, u32)| edge.0 < edge.1 && squared(edge).sqrt() <= reach;
        let near: Vec<(u32, u32)> = faces.iter().flat_map(pairs).filter(is_near).collect();
        if near.is_empty() {
            return None;
        }
        let mut same: Vec<u32> = (0..vertices.len() as u32).collect();
        for (v, w) in near {
            let (v, w) = (root(&same, v), root(&same, w));
            same[v.max(w) as usize] = v.min(w);
        }
        let went = |v: usize| (vertices[v] - vertices[root(&same, v as u32) as usize]).norm();
        let moved = (0..vertices.len()).map(went).fold(0.0, f64::max);
        let (vertices, faces) = without_doubles(vertices, faces, &same);
        Some(MergedBody { vertices, faces, moved })
    }
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
/// area over volume. Rounding the vertices about the centre costs as much again, and so do vertices that were `moved`.
fn is_accurate(local: &Polyhedron, moved: f64) -> bool {
    let extent = extent(local.vertices());
    let displaced = (4.0 * ROUNDING * extent).max(moved);
    // A convex body has less area than a sphere around it, which spares most bodies the sum; rounding is given a half.
    let most = 1.5 * 4.0 * std::f64::consts::PI * extent * extent;
    // False for NaN, too.
    displaced * most / local.volume() < ACCURACY || displaced * local.area() / local.volume() < ACCURACY
}

/// The farthest vertex's distance from the origin.
fn extent(vertices: &[Vec3]) -> f64 {
    vertices.iter().map(Vec3::norm_squared).fold(0.0, f64::max).sqrt()
}
