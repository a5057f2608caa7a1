//! The map of an aggregate onto its inward offset, along rays from its centroid.
//!
//! x' = c + s (x - c) with s = (way to the offset) / (way to the surface) on the ray from the centroid c: surface nodes
//! land exactly on the offset's planes, and since rays stay rays, nothing turns inside out near edges and corners, where
//! moves along normals do cross (measured: three times as many nodes then stop short of their image).

use crate::aggregate::Aggregate;
use crate::geometry::Plane;
use crate::math::Vec3;

/// A layer takes at most this share of the depth of an aggregate's centroid below its surface.
const DEEPEST: f64 = 0.8;

/// The map of one aggregate.
pub(super) struct Shrink {
    pub(super) centre: Vec3,
    /// Outward normals, and the centre's distance to every face plane, mm.
    pub(super) planes: Vec<(Vec3, f64)>,
    /// mm.
    pub(super) thickness: f64,
}

impl Shrink {
    pub(super) fn new(aggregate: &Aggregate, thickness: f64) -> Self {
        let centre = aggregate.body.centroid();
        let depth = |p: Plane| (p.normal, p.offset - p.normal.dot(&centre));
        let planes: Vec<(Vec3, f64)> = aggregate.body.planes().map(depth).collect();
        let shallowest = planes.iter().map(|p| p.1).fold(f64::INFINITY, f64::min);
        Self { centre, planes, thickness: thickness.min(DEEPEST * shallowest) }
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
