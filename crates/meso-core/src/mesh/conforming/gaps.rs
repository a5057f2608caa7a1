//! Aggregates too close to each other or to the specimen's surface for a conforming mesh, found before gmsh starts.

use crate::aggregate::Aggregate;
use crate::geometry::Polyhedron;
use crate::gjk;
use crate::math::Aabb;
use crate::mesh::MeshError;
use crate::packing::{Container, Obstacle, Period};
use rayon::prelude::*;

/// Gaps up to this make tetrahedra that no analysis can use, and gmsh's boundary recovery uncertain, mm.
pub(super) const NARROWEST_MM: f64 = 1e-3;

/// Gaps that leave gmsh room, mm: seven packings of 30 mm and those of 60 and 150 mm at 0.50 were meshed with them.
pub const ROOM_MM: f64 = 0.05;

/// Names an aggregate whose outermost point along an axis is within [`NARROWEST_MM`] of a face across which the box repeats
/// itself: what the face cuts off, or the mortar there, would be as thin.
pub(super) fn refuse_grazed(aggregates: &[Aggregate], period: &Period) -> Result<(), MeshError> {
    let gap = |aggregate: &Aggregate| {
        let aabb = aggregate.body.aabb();
        let off = |axis: usize| {
            let length = period.along(axis).unwrap_or(f64::INFINITY);
            [aabb.min[axis], aabb.max[axis]].map(|x| (x - (x / length).round() * length).abs())
        };
        let periodic = (0..3).filter(|&axis| period.along(axis).is_some());
        (periodic.flat_map(off).fold(f64::INFINITY, f64::min), aggregate.id)
    };
    let closest = aggregates.par_iter().map(gap).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    match closest {
        Some((gap_mm, aggregate)) if gap_mm <= NARROWEST_MM => {
            Err(MeshError::NearTouching { gap_mm, aggregate, other: None })
        }
        _ => Ok(()),
    }
}

/// Names the closest pair with a gap of at most [`NARROWEST_MM`], the specimen's surface taken for a body; its triangles
/// may lie `chord` mm inside it.
pub(super) fn refuse_near_touching(
    aggregates: &[Aggregate],
    room: &dyn Container,
    chord: f64,
) -> Result<(), MeshError> {
    let boxes: Vec<Aabb> = aggregates.iter().map(|a| a.body.aabb()).collect();
    let mut order: Vec<usize> = (0..aggregates.len()).collect();
    order.sort_by(|&a, &b| boxes[a].min.x.total_cmp(&boxes[b].min.x));
    let after = |place: usize| {
        let (order, boxes) = (&order, &boxes);
        let first = order[place];
        let reach = boxes[first].max.x + NARROWEST_MM;
        let ahead = order[place + 1..].iter().take_while(move |&&b| boxes[b].min.x <= reach);
        ahead.filter(move |&&b| near(&boxes[first], &boxes[b])).map(move |&b| (first, b))
    };
    let gap = |(a, b): (usize, usize)| {
        let bodies = [a, b].map(|i| aggregates[i].body.vertices());
        // Bodies that no distance can be told of are as good as touching.
        (gjk::distance(bodies[0], bodies[1]).unwrap_or(0.0), aggregates[a].id, Some(aggregates[b].id))
    };
    let pairs = (0..order.len()).into_par_iter().flat_map_iter(after).map(gap);
    let walls = aggregates.par_iter().map(|a| (wall_gap(&a.body, room) - chord, a.id, None));
    let closest = pairs.chain(walls).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    match closest {
        Some((gap_mm, aggregate, other)) if gap_mm <= NARROWEST_MM => {
            Err(MeshError::NearTouching { gap_mm, aggregate, other })
        }
        _ => Ok(()),
    }
}

fn near(a: &Aabb, b: &Aabb) -> bool {
    (0..3).all(|i| a.min[i] <= b.max[i] + NARROWEST_MM && b.min[i] <= a.max[i] + NARROWEST_MM)
}

/// Distance of `body` from the surface of `room`, mm; where the room is not convex and it is beyond [`NARROWEST_MM`], infinite.
fn wall_gap(body: &Polyhedron, room: &dyn Container) -> f64 {
    if room.is_convex() {
        return body.vertices().iter().map(|vertex| room.depth(vertex)).fold(f64::INFINITY, f64::min);
    }
    let around = room.obstacles(&body.aabb().grown(NARROWEST_MM));
    let gap = |obstacle: &Obstacle| gjk::distance(body.vertices(), obstacle.points).unwrap_or(0.0);
    around.iter().map(gap).fold(f64::INFINITY, f64::min)
}
