//! The solid ITZ: a layer of tetrahedra of its exact thickness, split off the inside of every aggregate.
//!
//! Meshing a thin shell directly makes slivers by the hundred thousand. Instead all of an aggregate's cells shrink towards
//! its centroid c, every ray from c by the share that maps the outer surface onto the inward offset: x' = c + s (x - c),
//! s = (way to the offset) / (way to the surface). Surface nodes land exactly on the offset's planes, and since rays stay
//! rays, nothing turns inside out near edges and corners, where moves along normals would cross. Between each interface
//! triangle and its image stands a prism, cut into three tetrahedra. A flat tetrahedron that the map would turn over all
//! the same has its nodes go less far, and the report counts them.

use super::interface::{self, InterfaceFace};
use super::separate::{Copies, separate};
use super::{Mesh, NO_AGGREGATE, Phase};
use crate::aggregate::Aggregate;
use crate::geometry::Plane;
use crate::math::Vec3;
use rayon::prelude::*;
use std::collections::HashMap;

/// Share of its way that a node keeps at each step back.
const STEP_BACK: f64 = 0.7;
/// Steps back before the layer is taken as it is.
const STEPS: usize = 20;
/// A layer takes at most this share of the depth of an aggregate's centroid below its surface.
const DEEPEST: f64 = 0.8;

/// What a layer had to do without.
pub(super) struct Thinned {
    /// Aggregates too small for their thickness.
    pub(super) aggregates: usize,
    /// Nodes that stopped short of their image.
    pub(super) nodes: usize,
}

/// Splits a layer of `thickness(aggregate)` mm off the inside of every aggregate.
pub(super) fn add(mesh: &mut Mesh, aggregates: &[Aggregate], thickness: impl Fn(&Aggregate) -> f64) -> Thinned {
    let shrinks: HashMap<u32, Shrink> =
        aggregates.iter().filter(|a| thickness(a) > 0.0).map(|a| (a.id, Shrink::new(a, thickness(a)))).collect();
    let faces = facing_out(mesh, &shrinks);
    let copies = separate(mesh, &faces, false);
    let owner = owners(mesh);
    for face in &faces {
        let prism = prism(mesh, face, &copies);
        mesh.cells.extend(prism.as_flattened());
        mesh.phase.extend([Phase::Itz; 3]);
        mesh.aggregate.extend([mesh.aggregate[face.cell as usize]; 3]);
    }
    let image = |(point, id): (&Vec3, &u32)| shrinks.get(id).map_or(*point, |shrink| shrink.apply(point));
    let images: Vec<Vec3> = mesh.points.par_iter().zip(&owner).map(image).collect();
    let nodes = go(mesh, images);
    let thinner = |a: &&Aggregate| shrinks.get(&a.id).is_some_and(|s| s.thickness < thickness(a));
    Thinned { aggregates: aggregates.iter().filter(thinner).count(), nodes }
}

/// The interface faces of the aggregates that get a layer. One that does not face away from its aggregate's centroid has
/// no prism; the mortar cell behind it, which lies inside the aggregate's hull, goes to the aggregate.
fn facing_out(mesh: &mut Mesh, shrinks: &HashMap<u32, Shrink>) -> Vec<InterfaceFace> {
    loop {
        let mut faces = interface::faces(mesh);
        faces.retain(|face| shrinks.contains_key(&mesh.aggregate[face.cell as usize]));
        let inwards = |face: &&InterfaceFace| {
            let centre = shrinks[&mesh.aggregate[face.cell as usize]].centre;
            let [a, b, c] = [0, 1, 2].map(|i| mesh.points[face.nodes[i] as usize] - centre);
            mesh.aggregate[face.behind as usize] == NO_AGGREGATE && a.cross(&b).dot(&c) <= 0.0
        };
        let claimed: Vec<InterfaceFace> = faces.iter().filter(inwards).copied().collect();
        if claimed.is_empty() {
            return faces;
        }
        for face in claimed {
            mesh.aggregate[face.behind as usize] = mesh.aggregate[face.cell as usize];
            mesh.phase[face.behind as usize] = Phase::Aggregate;
        }
    }
}

/// Moves all nodes to their images, those of tetrahedra that would turn over less far; returns their number.
fn go(mesh: &mut Mesh, images: Vec<Vec3>) -> usize {
    let from = std::mem::replace(&mut mesh.points, images);
    let mut short = vec![false; from.len()];
    for _ in 0..STEPS {
        let over = |cell: &&[u32]| volume([0, 1, 2, 3].map(|i| mesh.points[cell[i] as usize])) <= 0.0;
        let mut stuck: Vec<u32> = mesh.cells.par_chunks_exact(4).filter(over).flatten().copied().collect();
        if stuck.is_empty() {
            break;
        }
        stuck.sort_unstable();
        stuck.dedup();
        for node in stuck {
            let (start, now) = (from[node as usize], mesh.points[node as usize]);
            mesh.points[node as usize] = start + (now - start) * STEP_BACK;
            short[node as usize] |= start != now;
        }
    }
    short.iter().filter(|short| **short).count()
}

fn volume([a, b, c, d]: [Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
}

/// The aggregate whose cells a node has, [`NO_AGGREGATE`] for nodes of the mortar and of interfaces.
fn owners(mesh: &Mesh) -> Vec<u32> {
    let mut owner = vec![NO_AGGREGATE; mesh.points.len()];
    for (cell, &aggregate) in mesh.cells().zip(&mesh.aggregate).filter(|(_, aggregate)| **aggregate != NO_AGGREGATE) {
        cell.iter().for_each(|&node| owner[node as usize] = aggregate);
    }
    owner
}

/// The map of an aggregate onto its inward offset.
struct Shrink {
    centre: Vec3,
    /// Outward normals, and the centre's distance to every face plane, mm.
    planes: Vec<(Vec3, f64)>,
    /// mm.
    thickness: f64,
}

impl Shrink {
    fn new(aggregate: &Aggregate, thickness: f64) -> Self {
        let centre = aggregate.body.centroid();
        let depth = |p: Plane| (p.normal, p.offset - p.normal.dot(&centre));
        let planes: Vec<(Vec3, f64)> = aggregate.body.planes().map(depth).collect();
        let shallowest = planes.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        Self { centre, planes, thickness: thickness.min(DEEPEST * shallowest) }
    }

    fn apply(&self, x: &Vec3) -> Vec3 {
        let ray = x - self.centre;
        let (mut surface, mut offset) = (f64::INFINITY, f64::INFINITY);
        for (normal, depth) in &self.planes {
            let speed = normal.dot(&ray);
            if speed > 0.0 {
                surface = surface.min(depth / speed);
                offset = offset.min((depth - self.thickness) / speed);
            }
        }
        // The centre itself has no ray, and stays.
        if surface.is_finite() { self.centre + ray * (offset / surface) } else { *x }
    }
}

/// The prism between an interface triangle and its image; diagonals start at the lowest node, so neighbours match.
fn prism(mesh: &Mesh, face: &InterfaceFace, copies: &Copies) -> [[u32; 4]; 3] {
    let aggregate = mesh.aggregate[face.cell as usize];
    let [a, b, c, _] = face.nodes;
    let mut rails = [a, b, c].map(|node| [copies.of(aggregate, node), node]);
    let turns = [(a, b), (b, c), (a, c)].iter().filter(|(first, second)| first > second).count();
    rails.sort_unstable_by_key(|rail| rail[1]);
    let [[a, d], [b, e], [c, f]] = rails;
    let tetrahedra = [[a, b, c, f], [a, e, b, f], [a, d, e, f]];
    // Positive when the rails are in an even order, since the face is counter-clockwise from outside.
    if turns % 2 == 0 { tetrahedra } else { tetrahedra.map(|[a, b, c, d]| [b, a, c, d]) }
}
