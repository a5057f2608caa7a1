//! How far a mesh's interfaces lie from the exact surfaces of the aggregates.

use super::Mesh;
use super::flat_sides::FlatSides;
use super::interface::Owners;
use crate::aggregate::Aggregate;
use crate::geometry::{Plane, nearest_on_triangle};
use crate::math::Vec3;
use crate::packing::{Specimen, images_near};
use rayon::prelude::*;
use serde::Serialize;

/// Distances of the nodes between an aggregate and what it meets from that aggregate's surface; in voxels and plain
/// lattices those of the staircase.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct InterfaceDistance {
    /// Nodes measured; one where two aggregates meet counts for both. Middles of edges are left out.
    pub nodes: usize,
    /// The largest distance, mm.
    pub max_mm: f64,
    /// Root mean square of all distances, mm.
    pub rms_mm: f64,
    /// Nodes where one aggregate alone meets mortar or a fibre within the specimen. All others join aggregates with each
    /// other or with the specimen's sides, and lie on one of these at best.
    pub alone: usize,
    /// Those of them that lie off the aggregate's surface, by more than 1e-9 of the specimen.
    pub alone_off: usize,
    /// The largest distance of one of them, mm.
    pub alone_max_mm: f64,
}

/// Distances up to this share of the specimen's size are rounding.
const ROUNDING: f64 = 1e-9;

impl InterfaceDistance {
    /// Of a mesh of `aggregates` in `specimen`; a solid ITZ is measured on its outside.
    pub fn of(mesh: &Mesh, aggregates: &[Aggregate], specimen: &Specimen) -> Self {
        let mut bodies: Vec<Body> = images_near(aggregates, specimen, 0.0).iter().map(Body::new).collect();
        bodies.sort_by_key(|body| body.id);
        let distance = |&(node, id): &(u32, u32)| {
            let start = bodies.partition_point(|body| body.id < id);
            let images = bodies[start..].iter().take_while(|body| body.id == id);
            images.map(|body| body.distance(&mesh.points[node as usize])).fold(f64::INFINITY, f64::min)
        };
        let nodes = interface_nodes(mesh);
        let distances: Vec<f64> = nodes.par_iter().map(distance).collect();
        let mut joined = joined(mesh, &nodes);
        let sides = FlatSides::of(specimen);
        for ((node, _), joined) in nodes.iter().zip(&mut joined) {
            *joined |= sides.have(&mesh.points[*node as usize]);
        }
        let alone = || distances.iter().copied().zip(&joined).filter(|(_, joined)| !**joined).map(|(d, _)| d);
        let rounding = ROUNDING * specimen.aabb().size().max();
        // Summed in the nodes' order: the same on any number of threads.
        let squares: f64 = distances.iter().map(|d| d * d).sum();
        Self {
            nodes: distances.len(),
            max_mm: distances.iter().copied().fold(0.0, f64::max),
            rms_mm: (squares / distances.len().max(1) as f64).sqrt(),
            alone: alone().count(),
            alone_off: alone().filter(|distance| *distance > rounding).count(),
            alone_max_mm: alone().fold(0.0, f64::max),
        }
    }
}

/// Corners of cells where an aggregate meets something else, with its id, each pair once, in order.
fn interface_nodes(mesh: &Mesh) -> Vec<(u32, u32)> {
    let owners = Owners::of(mesh);
    // Cohesive elements parted their nodes.
    let mut parted = vec![false; if mesh.cohesive.is_empty() { 0 } else { mesh.points.len() }];
    mesh.cohesive.iter().for_each(|&node| parted[node as usize] = true);
    owners.aggregates(|node| owners.are_several(node) || parted.get(node as usize) == Some(&true))
}

/// Which of the pairs lie where several aggregates meet, cohesive elements between them or not.
fn joined(mesh: &Mesh, nodes: &[(u32, u32)]) -> Vec<bool> {
    if mesh.cohesive.is_empty() {
        let of_node = nodes.chunk_by(|a, b| a.0 == b.0);
        return of_node.flat_map(|same| std::iter::repeat_n(same.len() > 1, same.len())).collect();
    }
    // Parted nodes have one place.
    let place = |pair: usize| -> [u64; 3] { mesh.points[nodes[pair].0 as usize].map(f64::to_bits).into() };
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.par_sort_unstable_by_key(|&pair| place(pair));
    let mut joined = vec![false; nodes.len()];
    for same in order.chunk_by(|&a, &b| place(a) == place(b)) {
        let several = same.iter().any(|&pair| nodes[pair].1 != nodes[same[0]].1);
        same.iter().for_each(|&pair| joined[pair] = several);
    }
    joined
}

/// A convex body by its surface.
struct Body {
    id: u32,
    /// The triangles of its faces.
    triangles: Vec<[Vec3; 3]>,
    /// The plane of each triangle.
    planes: Vec<Plane>,
}

impl Body {
    fn new(aggregate: &Aggregate) -> Self {
        let body = &aggregate.body;
        let corners = |t: [u32; 3]| t.map(|i| body.vertices()[i as usize]);
        let pieces =
            body.faces().zip(body.planes()).flat_map(|(face, plane)| face.triangles().map(move |t| (t, plane)));
        let (triangles, planes) = pieces.map(|(t, plane)| (corners(t), plane)).unzip();
        Self { id: aggregate.id, triangles, planes }
    }

    /// From `x` to the surface, mm: inside, the nearest plane; outside, the nearest of the triangles that face `x`.
    fn distance(&self, x: &Vec3) -> f64 {
        let height = |plane: &Plane| plane.normal.dot(x) - plane.offset;
        let (mut highest, mut most) = (0, f64::NEG_INFINITY);
        for (triangle, plane) in self.planes.iter().enumerate() {
            let above = height(plane);
            if above > most {
                (highest, most) = (triangle, above);
            }
        }
        if most <= 0.0 {
            return -most;
        }
        let to = |triangle: usize| (nearest_on_triangle(&self.triangles[triangle], x) - x).norm();
        let mut least = to(highest);
        // Above the inside of the highest triangle, as most points are, nothing is nearer than it.
        if least <= most * (1.0 + 1e-12) {
            return least;
        }
        for (triangle, plane) in self.planes.iter().enumerate() {
            if (0.0..least).contains(&height(plane)) {
                least = least.min(to(triangle));
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::aggregate::Kind;
    use crate::geometry::convex_hull;
    use crate::gjk;

    /// A body with faces of three, four and six corners, some at blunt angles.
    fn body() -> Vec<Vec3> {
        let (cos, sin) = (0.5, 0.75_f64.sqrt());
        let ring = [(1.0, 0.0), (cos, sin), (-cos, sin), (-1.0, 0.0), (-cos, -sin), (cos, -sin)];
        let layers = [(3.0, -2.0), (4.0, 0.0), (3.0, 1.0)];
        let mut points: Vec<Vec3> =
            layers.iter().flat_map(|(r, z)| ring.map(|(x, y)| Vec3::new(r * x + 7.0, r * y + 7.0, z + 7.0))).collect();
        points.push(Vec3::new(7.5, 6.8, 8.6));
        points
    }

    #[test]
    fn distances_are_those_of_gjk_outside_and_of_the_planes_inside() {
        let hull = convex_hull(&body()).unwrap();
        let aggregate = Aggregate { id: 0, class: 0, itz_thickness_mm: 0.1, body: hull.clone(), kind: Kind::Aggregate };
        let body = Body::new(&aggregate);
        let (mut above, mut beside) = (0, 0);
        for at in 0..17_usize.pow(3) {
            let x = Vec3::new((at % 17) as f64, (at / 17 % 17) as f64, (at / 289) as f64) * 0.83;
            let height = hull.planes().map(|p| p.normal.dot(&x) - p.offset).fold(f64::NEG_INFINITY, f64::max);
            let exact = gjk::distance(&[x], hull.vertices()).unwrap();
            let expected = if height <= 0.0 { -height } else { exact };
            assert!((body.distance(&x) - expected).abs() < 1e-12, "{x:?}");
            above += usize::from(height > 0.0 && exact < height + 1e-12);
            beside += usize::from(height > 0.0 && exact > height + 1e-12);
        }
        assert!(above > 500 && beside > 2000, "{above} {beside}");
    }
}
