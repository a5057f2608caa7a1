//! How far the centres of voxels are from the nearest surface of a body.

use crate::aggregate::Aggregate;
use crate::geometry::BoxTree;
use crate::math::{Aabb, Vec3};
use crate::mesh::fidelity::Body;
use crate::mesh::location::{Label, Scan};
use crate::stop;
use rayon::prelude::*;
use std::cell::Cell;

/// The bodies by their surfaces, and a tree of their boxes.
pub(super) struct Surfaces {
    bodies: Vec<Body>,
    boxes: Vec<Aabb>,
    tree: BoxTree,
}

impl Surfaces {
    pub(super) fn new(aggregates: &[Aggregate]) -> Self {
        let boxes: Vec<Aabb> = aggregates.iter().map(|aggregate| aggregate.body.aabb()).collect();
        Self { bodies: aggregates.par_iter().map(Body::new).collect(), tree: BoxTree::new(&boxes), boxes }
    }

    /// Distances of the voxels of layer `k`, mm, negative inside a body. The bodies of `scan` are these, in their order.
    pub(super) fn measure(&self, scan: &Scan, k: usize, layer: &mut [f32]) {
        let mut labels = vec![Label::MORTAR; layer.len()];
        scan.label_layer(k, &mut labels);
        for ((number, value), label) in layer.iter_mut().enumerate().zip(labels) {
            stop::point();
            let point = scan.grid().point(number, k);
            *value = match label.body() {
                Some(body) => scan.bodies()[body as usize].height(&point).min(0.0) as f32,
                None => self.nearest(&point) as f32,
            };
        }
    }

    /// From a point outside all bodies to the nearest one.
    fn nearest(&self, point: &Vec3) -> f64 {
        let best = Cell::new(f64::INFINITY);
        let distance = |item: u32| {
            if self.boxes[item as usize].distance(point) > best.get() {
                return f64::INFINITY;
            }
            let distance = self.bodies[item as usize].distance(point);
            best.set(best.get().min(distance));
            distance
        };
        self.tree.nearest(point, distance).map_or(f64::INFINITY, |(_, distance)| distance)
    }
}
