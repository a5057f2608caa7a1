//! Distance of a mesh's interfaces from the exact surfaces.

use crate::body_images::BodyImages;
use crate::cells::{FlatSides, Mesh, Owners};
use meso_collision::geometry::BodySurface;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::specimen::Specimen;
use meso_concrete::stop;
use rayon::prelude::*;
use serde::Serialize;

/// How far the nodes where aggregates meet other materials lie from the exact surfaces; in voxels and plain lattices it is
/// the staircase that is measured. Nodes that cohesive elements separate are one; middles of edges are left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct InterfaceDistance {
    /// Nodes where an aggregate meets something else.
    pub nodes: usize,
    /// Interface nodes that lie on the surface of no aggregate that meets there, nor on a flat side of the specimen, by more
    /// than 1e-9 of the specimen.
    pub off: usize,
    /// Root mean square of all nodes' distances, mm: each to the nearest of these surfaces.
    pub rms_mm: f64,
    /// The largest of these distances, mm.
    pub max_mm: f64,
    /// Nodes that close a gap: several aggregates meet there, or one and a flat side of the specimen that does not cut it.
    pub joined: usize,
    /// Root mean square of the gaps at these nodes, mm: from the node to the farthest of the aggregates that meet there.
    pub joined_rms_mm: f64,
    /// The largest of these distances, mm.
    pub joined_max_mm: f64,
}

/// Distances up to this share of the specimen's size are rounding.
const ROUNDING: f64 = 1e-9;

impl InterfaceDistance {
    /// Measures a mesh of `aggregates` in `specimen`; a solid ITZ counts by its outside.
    pub fn of(mesh: &Mesh, aggregates: &[Aggregate], specimen: &Specimen) -> Self {
        let bodies = BodyImages::of(&(aggregates, specimen).into());
        let surfaces: Vec<_> = bodies.all.iter().map(|body| BodySurface::new(&body.body)).collect();
        let distance = |&(node, body): &(u32, u32)| {
            stop::point();
            let images =
                surfaces[bodies.places(body)].iter().map(|surface| surface.distance(&mesh.points[node as usize]));
            images.fold(f64::INFINITY, f64::min)
        };
        let mut pairs = interface_nodes(mesh);
        let position = |node: u32| -> [u64; 3] { mesh.points[node as usize].map(f64::to_bits).into() };
        if !mesh.cohesive.is_empty() {
            pairs.par_sort_unstable_by_key(|&(node, id)| (position(node), id));
        }
        let distances = parallel::map_short(pairs.len(), |pair| distance(&pairs[pair]));
        let sides = FlatSides::of(specimen);
        let rounding = ROUNDING * specimen.aabb().size().max();
        // One after the other: the same sums on any number of threads.
        let mut found = Self::default();
        let mut start = 0;
        for meet in pairs.chunk_by(|a, b| a.0 == b.0 || position(a.0) == position(b.0)) {
            let across = sides.across(&mesh.points[meet[0].0 as usize]);
            let at_side = across != 0 && meet.iter().any(|(_, body)| across & !bodies.caps(*body) != 0);
            found.see(&distances[start..start + meet.len()], meet[0].1 != meet[meet.len() - 1].1, at_side, rounding);
            start += meet.len();
        }
        let root = |squares: f64, count: usize| (squares / count.max(1) as f64).sqrt();
        found.rms_mm = root(found.rms_mm, found.nodes);
        found.joined_rms_mm = root(found.joined_rms_mm, found.joined);
        found
    }

    /// Adds a node by its distances from the aggregates that meet there, `several` or one; roots are not drawn yet.
    fn see(&mut self, distances: &[f64], several: bool, at_side: bool, rounding: f64) {
        let nearest = if at_side { 0.0 } else { distances.iter().copied().fold(f64::INFINITY, f64::min) };
        self.nodes += 1;
        self.off += usize::from(nearest > rounding);
        self.rms_mm += nearest * nearest;
        self.max_mm = self.max_mm.max(nearest);
        if several || at_side {
            let farthest = distances.iter().copied().fold(0.0, f64::max);
            self.joined += 1;
            self.joined_rms_mm += farthest * farthest;
            self.joined_max_mm = self.joined_max_mm.max(farthest);
        }
    }
}

/// Corners of cells where an aggregate meets something else, with its id, each pair once, in order.
fn interface_nodes(mesh: &Mesh) -> Vec<(u32, u32)> {
    let owners = Owners::of(mesh.by_owner());
    // Cohesive elements parted their nodes.
    let mut parted = vec![false; if mesh.cohesive.is_empty() { 0 } else { mesh.points.len() }];
    mesh.cohesive.iter().for_each(|&node| parted[node as usize] = true);
    owners.bodies(|node| owners.are_several(node) || parted.get(node as usize) == Some(&true))
}
