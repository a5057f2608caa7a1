//! Specimens in slabs. gmsh fills each slab in a run of its own, because its time grows faster than its input.
//!
//! Planes across the longest side divide bodies and mortar alike, as the faces of periodic boxes do; only their nodes are left
//! in the mesh. They avoid positions where a body begins, ends or has a corner.
//!
//! Bodies too close to each other or to the specimen's surface for a conforming mesh are refused before gmsh starts.

use crate::error::MeshError;
use crate::triangulation::snap;
use meso_collision::geometry::Polyhedron;
use meso_collision::gjk;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::specimen::{Container, Obstacle, Period};
use meso_concrete::stop;
use std::cmp::Ordering;

/// Triangles of bodies that one run of gmsh is given, about: 1.4 to 1.8 GB of its memory.
const MOST_TRIANGLES: f64 = 500_000.0;
/// Share of a slab's thickness in which its plane is looked for.
const WINDOW: f64 = 0.25;
/// A corner this much nearer to the plane counts as an outermost point: it leaves one short edge, not a sliver all around.
const CORNER: f64 = 20.0;

/// The planes between slabs.
pub(super) struct Slabs {
    /// The axis they are across.
    pub(super) axis: usize,
    /// Where they are, ascending, mm.
    pub(super) positions: Vec<f64>,
}

impl Slabs {
    /// As many as `asked`, or as `images`, the bodies in the box `domain`, need with elements of `size` mm; `walls` are corners
    /// of the specimen, from which planes keep clear.
    pub(super) fn new(images: &[Aggregate], walls: &[Vec3], domain: &Aabb, size: f64, asked: Option<u32>) -> Self {
        let triangles: f64 = images.iter().map(|image| triangles(image, size)).sum();
        let needed = || (triangles / MOST_TRIANGLES).ceil() as u32;
        Self::of(images, walls, domain, asked.unwrap_or_else(needed))
    }

    /// No planes.
    pub(super) fn one() -> Self {
        Self { axis: 0, positions: Vec::new() }
    }

    /// The planes of `count` slabs, fewer where a plane has no container.
    fn of(images: &[Aggregate], walls: &[Vec3], domain: &Aabb, count: u32) -> Self {
        let axis = domain.size().imax();
        let thickness = domain.size()[axis] / f64::from(count);
        let crowd = Crowd::new(images, walls, axis);
        let position = |slab: u32| {
            let middle = domain.min[axis] + f64::from(slab) * thickness;
            crowd.widest(middle - WINDOW / 2.0 * thickness, middle + WINDOW / 2.0 * thickness)
        };
        Self { axis, positions: (1..count).filter_map(position).collect() }
    }

    /// The slabs' boxes.
    pub(super) fn boxes(&self, domain: &Aabb) -> Vec<Aabb> {
        // New nodes are on the lattice, and so are the walls: to 5e-13 mm.
        let domain = Aabb { min: snap(domain.min), max: snap(domain.max) };
        let ends = [&[domain.min[self.axis]], &self.positions[..], &[domain.max[self.axis]]].concat();
        let across =
            |whole: Vec3, position: f64| Vec3::from_fn(|i, _| if i == self.axis { position } else { whole[i] });
        ends.windows(2)
            .map(|ends| Aabb { min: across(domain.min, ends[0]), max: across(domain.max, ends[1]) })
            .collect()
    }
}

/// Triangles of a body's surface, about: within 10 % at 1, 2 and 4 mm (850 bodies of 5 to 20 mm).
fn triangles(body: &Aggregate, size: f64) -> f64 {
    let fans: usize = body.body.faces().map(|face| face.len() - 2).sum();
    fans as f64 / 2.0 + 4.0 * body.body.area() / (size * size)
}

/// Where along an axis bodies have their corners, and where they begin and end.
struct Crowd {
    corners: Vec<f64>,
    ends: Vec<f64>,
}

impl Crowd {
    fn new(images: &[Aggregate], walls: &[Vec3], axis: usize) -> Self {
        let boxes = images.iter().map(|image| image.body.aabb());
        let mut ends: Vec<f64> = boxes.flat_map(|aabb| [aabb.min[axis], aabb.max[axis]]).collect();
        let bodies = images.iter().flat_map(|image| image.body.vertices());
        let mut corners: Vec<f64> = bodies.chain(walls).map(|v| v[axis]).collect();
        ends.sort_by(f64::total_cmp);
        corners.sort_by(f64::total_cmp);
        Self { corners, ends }
    }

    /// The position between two corners from `low` to `high` that has the most container.
    fn widest(&self, low: f64, high: f64) -> Option<f64> {
        let within = self.corners.partition_point(|x| *x < low)..self.corners.partition_point(|x| *x < high);
        let stops: Vec<f64> = [&[low], &self.corners[within], &[high]].concat();
        let middles = stops.windows(2).map(|pair| snap(Vec3::repeat(f64::midpoint(pair[0], pair[1]))).x);
        let rated = middles.map(|position| (self.clearance(position), position));
        rated
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|(clearance, _)| *clearance > NARROWEST_MM)
            .map(|(_, position)| position)
    }

    fn clearance(&self, position: f64) -> f64 {
        nearest(&self.ends, position).min(CORNER * nearest(&self.corners, position))
    }
}

/// Distance from `position` to the nearest of `sorted`.
fn nearest(sorted: &[f64], position: f64) -> f64 {
    let next = sorted.partition_point(|x| *x < position);
    let around = sorted[next.saturating_sub(1)..].iter().take(2);
    around.map(|x| (x - position).abs()).fold(f64::INFINITY, f64::min)
}

/// Gaps up to this make tetrahedra that no analysis can use, and gmsh's boundary recovery uncertain, mm.
pub(super) const NARROWEST_MM: f64 = 1e-3;

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
        (periodic.flat_map(off).fold(f64::INFINITY, f64::min), aggregate.id, None)
    };
    refuse(parallel::map_each(aggregates, gap).into_iter().min_by(closer))
}

/// A gap, mm, and the ids on both sides of it; of the specimen's surface there is none.
type Gap = (f64, u32, Option<u32>);

fn closer(a: &Gap, b: &Gap) -> Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}

fn refuse(closest: Option<Gap>) -> Result<(), MeshError> {
    match closest {
        Some((gap_mm, aggregate, other)) if gap_mm <= NARROWEST_MM => {
            Err(MeshError::NearTouching { gap_mm, aggregate, other })
        }
        _ => Ok(()),
    }
}

/// Names the closest pair with a gap of at most [`NARROWEST_MM`], the specimen's surface taken for a body; its triangles
/// may lie `chord` mm inside it.
pub(super) fn refuse_near_touching(
    aggregates: &[Aggregate],
    container: &dyn Container,
    chord: f64,
) -> Result<(), MeshError> {
    let boxes: Vec<Aabb> = aggregates.iter().map(|a| a.body.aabb()).collect();
    let mut order: Vec<usize> = (0..aggregates.len()).collect();
    order.sort_by(|&a, &b| boxes[a].min.x.total_cmp(&boxes[b].min.x));
    let after = |position: usize| {
        let (order, boxes) = (&order, &boxes);
        let first = order[position];
        let reach = boxes[first].max.x + NARROWEST_MM;
        let ahead = order[position + 1..].iter().take_while(move |&&b| boxes[b].min.x <= reach);
        ahead.filter(move |&&b| near(&boxes[first], &boxes[b])).map(move |&b| (first, b))
    };
    let gap = |(a, b): (usize, usize)| {
        stop::point();
        let bodies = [a, b].map(|i| aggregates[i].body.vertices());
        // Bodies that no distance can be told of are as good as touching.
        (gjk::distance(bodies[0], bodies[1]).unwrap_or(0.0), aggregates[a].id, Some(aggregates[b].id))
    };
    let pairs = parallel::map(order.len(), |position| after(position).map(gap).min_by(closer));
    let walls = parallel::map_each(aggregates, |a| (wall_gap(&a.body, container) - chord, a.id, None));
    refuse(pairs.into_iter().flatten().chain(walls).min_by(closer))
}

fn near(a: &Aabb, b: &Aabb) -> bool {
    (0..3).all(|i| a.min[i] <= b.max[i] + NARROWEST_MM && b.min[i] <= a.max[i] + NARROWEST_MM)
}

/// Distance of `body` from the surface of `container`, mm; where the container is not convex and it is beyond [`NARROWEST_MM`], infinite.
fn wall_gap(body: &Polyhedron, container: &dyn Container) -> f64 {
    stop::point();
    if container.is_convex() {
        return body.vertices().iter().map(|vertex| container.depth(vertex)).fold(f64::INFINITY, f64::min);
    }
    let around = container.obstacles(&body.aabb().grown(NARROWEST_MM));
    let gap = |obstacle: &Obstacle| gjk::distance(body.vertices(), obstacle.points).unwrap_or(0.0);
    around.iter().map(gap).fold(f64::INFINITY, f64::min)
}
