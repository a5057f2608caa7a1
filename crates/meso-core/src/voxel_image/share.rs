//! The share of every voxel that bodies take, exact to rounding: voxels that a surface crosses are clipped by its planes.
//!
//! Along a row of voxels a body's planes cut out two intervals: of those that it meets, and of those that it holds
//! whole. Between the two a voxel is clipped by the planes that cross it: up to four of them clip five tetrahedra, which
//! is five times faster; more of them clip the voxel's faces, since tetrahedra would multiply.

use super::options::ShareOf;
use crate::aggregate::{Aggregate, Kind};
use crate::geometry::Plane;
use crate::math::{Aabb, Vec3};
use crate::mesh::location::PointGrid;
use rayon::prelude::*;
use std::ops::Range;

/// Convex bodies whose shares are added up, or subtracted.
pub(super) struct Shares {
    grid: PointGrid,
    bodies: Vec<Body>,
    by_layer: Vec<Vec<u32>>,
}

struct Body {
    planes: Vec<Plane>,
    aabb: Aabb,
    /// 1, or -1 of the core that a shell lacks.
    sign: f32,
}

impl Shares {
    pub(super) fn new(grid: PointGrid, of: ShareOf, aggregates: &[Aggregate]) -> Self {
        let bodies: Vec<Body> = aggregates.par_iter().flat_map_iter(|aggregate| parts(aggregate, of)).collect();
        let mut by_layer = vec![Vec::new(); grid.counts[2]];
        for (index, body) in bodies.iter().enumerate() {
            touched(&grid, 2, &body.aabb).for_each(|k| by_layer[k].push(index as u32));
        }
        Self { grid, bodies, by_layer }
    }

    /// Adds what all bodies take of the voxels of layer `k`.
    pub(super) fn add(&self, k: usize, layer: &mut [f32]) {
        let z = self.grid.coordinate(2, k);
        for &index in &self.by_layer[k] {
            let body = &self.bodies[index as usize];
            for j in touched(&self.grid, 1, &body.aabb) {
                let row = &mut layer[j * self.grid.counts[0]..][..self.grid.counts[0]];
                self.add_row(body, self.grid.coordinate(1, j), z, row);
            }
        }
    }

    fn add_row(&self, body: &Body, y: f64, z: f64, row: &mut [f32]) {
        let h = self.grid.spacing.x;
        let [met, held] = body.intervals(y, z, h);
        let met = self.grid.range(0, met[0].max(body.aabb.min.x - h), met[1].min(body.aabb.max.x + h));
        let held = self.grid.range(0, held[0], held[1]);
        for i in met {
            let share = if held.contains(&i) {
                1.0
            } else {
                body.share(&Vec3::new(self.grid.coordinate(0, i), y, z), h) as f32
            };
            row[i] += body.sign * share;
        }
    }
}

/// The convex parts of an aggregate that count.
fn parts(aggregate: &Aggregate, of: ShareOf) -> Vec<Body> {
    let part = |offset: f64, sign: f32| {
        let planes = aggregate.body.planes().map(|plane| Plane { offset: plane.offset - offset, ..plane });
        Body { planes: planes.collect(), aabb: aggregate.body.aabb(), sign }
    };
    let shell = aggregate.itz_thickness_mm;
    match (of, aggregate.kind) {
        (ShareOf::Aggregate, Kind::Aggregate) | (ShareOf::Void, Kind::Void) | (ShareOf::Fibre, Kind::Fibre) => {
            vec![part(0.0, 1.0)]
        }
        (ShareOf::Core, Kind::Aggregate) => vec![part(shell, 1.0)],
        (ShareOf::Itz, Kind::Aggregate) => vec![part(0.0, 1.0), part(shell, -1.0)],
        _ => Vec::new(),
    }
}

/// The voxels along an axis that a body's box reaches into.
fn touched(grid: &PointGrid, axis: usize, aabb: &Aabb) -> Range<usize> {
    let half = grid.spacing[axis] / 2.0;
    grid.range(axis, aabb.min[axis] - half, aabb.max[axis] + half)
}

impl Body {
    /// The centres, by x, of the voxels in a row that the planes leave partly inside, and wholly.
    fn intervals(&self, y: f64, z: f64, h: f64) -> [[f64; 2]; 2] {
        let mut intervals = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
        for Plane { normal, offset } in &self.planes {
            let reach = offset - normal.y * y - normal.z * z;
            let half = normal.abs().sum() * h / 2.0;
            for ([low, high], reach) in intervals.iter_mut().zip([reach + half, reach - half]) {
                if normal.x > 0.0 {
                    *high = high.min(reach / normal.x);
                } else if normal.x < 0.0 {
                    *low = low.max(reach / normal.x);
                } else if reach < 0.0 {
                    *high = f64::NEG_INFINITY;
                }
            }
        }
        intervals
    }

    /// Share of the voxel about `centre`, by clipping it with the planes that cross it.
    fn share(&self, centre: &Vec3, h: f64) -> f64 {
        let mut few = [Plane { normal: Vec3::zeros(), offset: 0.0 }; FEW];
        let mut count = 0;
        for plane in self.in_voxels(centre, h) {
            let half = plane.normal.abs().sum() / 2.0;
            if plane.offset <= -half {
                return 0.0;
            }
            if plane.offset < half {
                if let Some(place) = few.get_mut(count) {
                    *place = plane;
                }
                count += 1;
            }
        }
        match few.get(..count) {
            Some(few) => TETRAHEDRA.iter().map(|corners| clipped(&corners.map(corner), few)).sum::<f64>() / 6.0,
            None => part_of_cube(self.in_voxels(centre, h)),
        }
    }

    /// The planes in units of voxels, from the centre of one.
    fn in_voxels(&self, centre: &Vec3, h: f64) -> impl Iterator<Item = Plane> {
        self.planes
            .iter()
            .map(move |&Plane { normal, offset }| Plane { normal, offset: (offset - normal.dot(centre)) / h })
    }
}

/// Planes that clip tetrahedra.
const FEW: usize = 4;

/// Five tetrahedra that fill a cube, by the cube's corners: bit i of a corner's number is its side along axis i.
const TETRAHEDRA: [[usize; 4]; 5] = [[0, 1, 2, 4], [3, 2, 1, 7], [5, 4, 7, 1], [6, 7, 4, 2], [1, 2, 4, 7]];

fn corner(number: usize) -> Vec3 {
    Vec3::from_fn(|axis, _| (number >> axis & 1) as f64 - 0.5)
}

/// Six times the volume of the part of a tetrahedron below all planes.
fn clipped(tet: &[Vec3; 4], planes: &[Plane]) -> f64 {
    let Some((plane, rest)) = planes.split_first() else {
        return (tet[1] - tet[0]).dot(&(tet[2] - tet[0]).cross(&(tet[3] - tet[0]))).abs();
    };
    let mut by_height = tet.map(|v| (plane.normal.dot(&v) - plane.offset, v));
    by_height.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let [a, b, c, d] = by_height.map(|(_, v)| v);
    let cut = |i: usize, j: usize| {
        let ((low, from), (high, to)) = (by_height[i], by_height[j]);
        from + (to - from) * (low / (low - high))
    };
    match by_height.iter().filter(|(height, _)| *height <= 0.0).count() {
        0 => 0.0,
        1 => clipped(&[a, cut(0, 1), cut(0, 2), cut(0, 3)], rest),
        // A prism between the two triangles about a and b.
        2 => {
            let ([ac, ad], [bc, bd]) = ([cut(0, 2), cut(0, 3)], [cut(1, 2), cut(1, 3)]);
            [[a, ac, ad, b], [ac, ad, b, bc], [ad, b, bc, bd]].iter().map(|part| clipped(part, rest)).sum()
        }
        // All but the corner above.
        3 => clipped(&[a, b, c, d], rest) - clipped(&[d, cut(0, 3), cut(1, 3), cut(2, 3)], rest),
        _ => clipped(&[a, b, c, d], rest),
    }
}

/// The corners of a cube's faces, counter-clockwise from outside.
const FACES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Volume of the part of the unit cube below all planes, by its faces.
fn part_of_cube(planes: impl Iterator<Item = Plane>) -> f64 {
    let mut faces: Vec<Vec<Vec3>> = FACES.iter().map(|face| face.map(corner).to_vec()).collect();
    for plane in planes {
        let height = |v: &Vec3| plane.normal.dot(v) - plane.offset;
        if faces.iter().flatten().all(|v| height(v) <= 0.0) {
            continue;
        }
        let mut rim = Vec::new();
        faces.iter_mut().for_each(|face| *face = below(face, height, &mut rim));
        faces.retain(|face| face.len() > 2);
        sort_around(&plane.normal, &mut rim);
        faces.push(rim);
    }
    let pyramid =
        |face: &Vec<Vec3>| (2..face.len()).map(|k| face[0].dot(&face[k - 1].cross(&face[k]))).sum::<f64>() / 6.0;
    faces.iter().map(pyramid).sum()
}

/// The part of a polygon that is not above a plane; where its edges cross this is added to `rim`, too.
fn below(face: &[Vec3], height: impl Fn(&Vec3) -> f64, rim: &mut Vec<Vec3>) -> Vec<Vec3> {
    let mut part = Vec::with_capacity(face.len() + 1);
    for (k, from) in face.iter().enumerate() {
        let to = &face[(k + 1) % face.len()];
        let (start, end) = (height(from), height(to));
        if start <= 0.0 {
            part.push(*from);
        }
        if (start <= 0.0) != (end <= 0.0) {
            let cut = from + (to - from) * (start / (start - end));
            part.push(cut);
            rim.push(cut);
        }
    }
    part
}

/// Puts the corners of a convex polygon in counter-clockwise order about its normal.
fn sort_around(normal: &Vec3, corners: &mut [Vec3]) {
    let centre = corners.iter().sum::<Vec3>() / corners.len().max(1) as f64;
    let across = normal.cross(&Vec3::ith(normal.iamin(), 1.0));
    let along = normal.cross(&across);
    let angle = |v: &Vec3| libm::atan2((v - centre).dot(&along), (v - centre).dot(&across));
    corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Polyhedron, clipped as part_in_box, convex_hull};

    /// A body of 24 corners.
    fn body() -> Polyhedron {
        let point = |i: i32| {
            let (a, b) = (f64::from(i) * 2.4, f64::from(i) / 12.0 - 0.95);
            let r = (1.0 - b * b).max(0.0).sqrt();
            Vec3::new(4.1 + 3.0 * r * libm::cos(a), 4.3 + 2.5 * r * libm::sin(a), 3.9 + 2.0 * b)
        };
        convex_hull(&(0..24).map(point).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn a_body_inside_one_voxel_takes_its_own_share() {
        let body = body();
        let own = Body { planes: body.planes().collect(), aabb: body.aabb(), sign: 1.0 };
        assert!((own.share(&Vec3::repeat(4.0), 9.0) * 729.0 / body.volume() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn shares_are_those_of_the_exact_clip_and_add_up_to_the_volume() {
        let body = body();
        let aabb = body.aabb();
        let own = Body { planes: body.planes().collect(), aabb, sign: 1.0 };
        for h in [0.7, 2.0] {
            let (mut sum, mut crossed) = (0.0, 0);
            for number in 0..14_usize.pow(3) {
                let low = Vec3::new((number % 14) as f64, (number / 14 % 14) as f64, (number / 196) as f64) * h;
                let voxel = Aabb { min: low, max: low.add_scalar(h) };
                let exact = if aabb.intersects(&voxel) { part_in_box(&body, &voxel) } else { None };
                let exact = exact.map_or(0.0, |part| part.volume() / h.powi(3));
                let share = own.share(&low.add_scalar(h / 2.0), h);
                assert!((share - exact).abs() < 1e-9, "{share} for {exact} at {low}");
                sum += share;
                crossed += usize::from(share > 0.0 && share < 1.0);
            }
            assert!((sum * h.powi(3) / body.volume() - 1.0).abs() < 1e-10);
            assert!(crossed > 20, "{crossed}");
        }
    }
}
