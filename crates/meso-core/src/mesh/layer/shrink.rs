//! The map of an aggregate onto its inward offset, along rays from a centre.
//!
//! x' = c + s (x - c) with s = (way to the offset) / (way to the surface) on the ray from the centre c: surface nodes
//! land exactly on the offset's planes, and since rays stay rays, nothing turns inside out near edges and corners, where
//! moves along normals do cross (measured: three times as many nodes then stop short of their image).
//!
//! The centre is the centroid. For nodes on a face of a periodic box it is the deepest point on that face: then the rays
//! lie in the face, and the nodes of the surface land on the cut of the offset with it.

use super::bodies::Bodies;
use super::flat::Flat;
use super::ties::Ties;
use crate::aggregate::Aggregate;
use crate::geometry::Plane;
use crate::math::{Aabb, Vec3};
use crate::mesh::NO_AGGREGATE;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};

/// A layer takes at most this share of the depth of an aggregate's centre below its surface.
const DEEPEST: f64 = 0.8;
/// Steps of the search for the deepest point, each of which leaves two thirds: 6e-5 of the aggregate's width is left.
const STEPS: usize = 24;

/// The map of one aggregate, or of its cut with faces of the box.
pub(super) struct Shrink {
    pub(super) centre: Vec3,
    /// Outward normals, and the centre's distance to every face plane, mm.
    pub(super) planes: Vec<(Vec3, f64)>,
    /// mm.
    pub(super) thickness: f64,
    /// The faces of a periodic box that the aggregate reaches across.
    across: Flat,
}

impl Shrink {
    /// `None` where the aggregate hardly reaches `flat`: there is no way in.
    fn new(aggregate: &Aggregate, thickness: f64, flat: Flat, walls: &Aabb, periodic: [bool; 3]) -> Option<Self> {
        let planes: Vec<Plane> = aggregate.body.planes().collect();
        let aabb = aggregate.body.aabb();
        let centre = match flat {
            Flat::SPACE => aggregate.body.centroid(),
            flat => {
                let free: Vec<usize> = (0..3).filter(|&axis| !flat.holds(axis)).collect();
                deepest(&planes, flat.put(&aabb.min, walls), &free, &aabb).0
            }
        };
        let depths = planes.iter().map(|p| (p.normal, p.offset - p.normal.dot(&centre)));
        let planes: Vec<(Vec3, f64)> = depths.collect();
        let shallowest = planes.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        let beyond = [0, 1, 2].map(|axis| (aabb.min[axis] < walls.min[axis], aabb.max[axis] > walls.max[axis]));
        let sides = (0..3).fold(0, |bits, axis| {
            bits | u8::from(beyond[axis].0) << (2 * axis) | u8::from(beyond[axis].1) << (2 * axis + 1)
        });
        let thickness = thickness.min(DEEPEST * shallowest);
        (shallowest > 0.0).then_some(Self { centre, planes, thickness, across: Flat::of(sides, periodic) })
    }

    /// The image of a node.
    pub(super) fn apply(&self, x: &Vec3) -> Vec3 {
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

/// The maps of all bodies that have a layer.
pub(super) struct Shrinks(HashMap<(u32, Flat), Shrink>);

impl Shrinks {
    /// Layers of `thickness(body)` mm; nodes that have no way in are pinned.
    pub(super) fn new(
        bodies: &Bodies,
        thickness: impl Fn(u32) -> f64 + Sync,
        owner: &[u32],
        ties: &mut Ties,
        periodic: [bool; 3],
    ) -> Self {
        let on_faces = (0..).zip(owner).map(|(node, body)| (*body, ties.flat(node)));
        let mut wanted: Vec<(u32, Flat)> = on_faces.filter(|(_, flat)| *flat != Flat::SPACE).collect();
        wanted.extend((0..bodies.count()).map(|body| (body, Flat::SPACE)));
        wanted.retain(|(body, _)| *body != NO_AGGREGATE && thickness(*body) > 0.0);
        wanted.sort_unstable();
        wanted.dedup();
        let shrink = |&(body, flat): &(u32, Flat)| {
            let shrink = Shrink::new(bodies.get(body), thickness(body), flat, ties.faces.walls(), periodic)?;
            Some(((body, flat), shrink))
        };
        let shrinks = Self(wanted.par_iter().filter_map(shrink).collect());
        for (node, &body) in (0..).zip(owner) {
            if ties.flat(node) != Flat::SPACE && shrinks.get(body, ties.flat(node)).is_none() {
                ties.pin(node);
            }
        }
        shrinks
    }

    /// That of `body` for nodes on `flat`.
    pub(super) fn get(&self, body: u32, flat: Flat) -> Option<&Shrink> {
        self.0.get(&(body, flat))
    }

    /// Aggregates too small for their thickness, with all their images.
    pub(super) fn thinner(&self, bodies: &Bodies, thickness: impl Fn(u32) -> f64) -> usize {
        let thinner =
            |body: &u32| self.get(*body, Flat::SPACE).is_some_and(|shrink| shrink.thickness < thickness(*body));
        let ids: BTreeSet<u32> = (0..bodies.count()).filter(thinner).map(|body| bodies.get(body).id).collect();
        ids.len()
    }

    /// The images of all nodes along their rays.
    pub(super) fn images(&self, points: &[Vec3], owner: &[u32], ties: &Ties) -> Vec<Vec3> {
        let image = |node: u32, x: &Vec3| match self.get(owner[node as usize], ties.flat(node)) {
            Some(shrink) if !ties.is_pinned(node) => shrink.across.hold_off(x, &shrink.apply(x), ties.faces.walls()),
            _ => *x,
        };
        let mut images: Vec<Vec3> = points.par_iter().enumerate().map(|(node, x)| image(node as u32, x)).collect();
        ties.spread(&mut images);
        images
    }
}

/// The point that lies deepest below all `planes`, from `at` along the axes `free` and within `aabb`, and its depth, mm.
/// Depth is concave, so each axis is searched by thirds.
fn deepest(planes: &[Plane], at: Vec3, free: &[usize], aabb: &Aabb) -> (Vec3, f64) {
    let Some((&axis, rest)) = free.split_first() else {
        return (at, planes.iter().map(|p| p.offset - p.normal.dot(&at)).fold(f64::INFINITY, f64::min));
    };
    let on = |x: f64| deepest(planes, Vec3::from_fn(|i, _| if i == axis { x } else { at[i] }), rest, aabb);
    let (mut low, mut high) = (aabb.min[axis], aabb.max[axis]);
    for _ in 0..STEPS {
        let third = (high - low) / 3.0;
        if on(low + third).1 < on(high - third).1 { low += third } else { high -= third }
    }
    on((low + high) / 2.0)
}
