//! How far a mesh's interfaces lie from the exact surfaces of the aggregates.

use super::{Mesh, NO_AGGREGATE, interface};
use crate::aggregate::Aggregate;
use crate::geometry::Plane;
use crate::gjk;
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
    /// Nodes where one aggregate alone meets mortar or a fibre. All others join aggregates, and lie on one of them at best.
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
        let distance = |&(id, node): &(u32, u32)| {
            let start = bodies.partition_point(|body| body.id < id);
            let images = bodies[start..].iter().take_while(|body| body.id == id);
            images.map(|body| body.distance(&mesh.points[node as usize])).fold(f64::INFINITY, f64::min)
        };
        let nodes = interface_nodes(mesh);
        let distances: Vec<f64> = nodes.par_iter().map(distance).collect();
        let joined = joined(mesh, &nodes);
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

/// Aggregates with the corners of their cells where they meet something else, each pair once.
pub(super) fn interface_nodes(mesh: &Mesh) -> Vec<(u32, u32)> {
    let mut mixed = interface::mixed_nodes(mesh);
    // Cohesive elements parted their nodes.
    mesh.cohesive.iter().for_each(|&node| mixed[node as usize] = true);
    let (mixed, corners) = (&mixed, mesh.kind.corners());
    let cells = mesh.cells.par_chunks_exact(mesh.kind.nodes()).zip(&mesh.aggregate);
    let of_aggregates = cells.filter(|(_, id)| **id != NO_AGGREGATE);
    let mut nodes: Vec<(u32, u32)> = of_aggregates
        .flat_map_iter(|(cell, &id)| {
            cell[..corners].iter().filter(|node| mixed[**node as usize]).map(move |&node| (id, node))
        })
        .collect();
    nodes.par_sort_unstable();
    nodes.dedup();
    nodes
}

/// Which of the pairs lie where several aggregates meet, cohesive elements between them or not: their nodes have one place.
fn joined(mesh: &Mesh, nodes: &[(u32, u32)]) -> Vec<bool> {
    let place = |pair: usize| -> [u64; 3] { mesh.points[nodes[pair].1 as usize].map(f64::to_bits).into() };
    let mut order: Vec<usize> = (0..nodes.len()).collect();
    order.par_sort_unstable_by_key(|&pair| place(pair));
    let mut joined = vec![false; nodes.len()];
    for same in order.chunk_by(|&a, &b| place(a) == place(b)) {
        let several = same.iter().any(|&pair| nodes[pair].0 != nodes[same[0]].0);
        same.iter().for_each(|&pair| joined[pair] = several);
    }
    joined
}

struct Body {
    id: u32,
    planes: Vec<Plane>,
    vertices: Vec<Vec3>,
    /// What rounding may lift a point of the body above a plane, mm.
    rounding: f64,
}

impl Body {
    fn new(aggregate: &Aggregate) -> Self {
        let body = &aggregate.body;
        let size = body.vertices().iter().map(Vec3::amax).fold(0.0, f64::max);
        Self {
            id: aggregate.id,
            planes: body.planes().collect(),
            vertices: body.vertices().to_vec(),
            rounding: 64.0 * f64::EPSILON * size,
        }
    }

    /// From `x` to the surface, mm: inside, the nearest plane; outside, the convex body.
    fn distance(&self, x: &Vec3) -> f64 {
        let (mut height, mut highest) = (f64::NEG_INFINITY, Vec3::zeros());
        for plane in &self.planes {
            let above = plane.normal.dot(x) - plane.offset;
            if above > height {
                (height, highest) = (above, plane.normal);
            }
        }
        if height <= 0.0 {
            return -height;
        }
        // Most points stand above the inside of a face: then its foot is the nearest, and no search is needed.
        let foot = x - highest * height;
        if self.planes.iter().all(|plane| plane.normal.dot(&foot) - plane.offset <= self.rounding) {
            return height;
        }
        gjk::distance(&[*x], &self.vertices).unwrap_or(height).max(height)
    }
}
