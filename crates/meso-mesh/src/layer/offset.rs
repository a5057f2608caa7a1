//! The moves of a body's nodes when its layer opens: onto its inward offset.
//!
//! 1. Along rays from a centre ([`RadialOffset`]): x' = c + s (x - c) with s = (way to the offset) / (way to the surface) on the ray
//!    from the centre c. Surface nodes land exactly on the offset's planes, and since rays stay rays, nothing turns inside out near
//!    edges and corners, where moves along normals do cross (measured: three times as many nodes then stop short). The centre is
//!    the centroid. For nodes on a face of a periodic box it is the deepest point on that face: then the rays lie in the face, and
//!    the nodes of the surface land on the cut of the offset with it.
//! 2. Where faces do not look away from the centroid ([`use_fallback_directions`]): they stand where a lattice closed a gap, so
//!    that a body reaches out to its neighbour. Their nodes go along the direction that enters all the faces around the node as steeply as can be, far
//!    enough for the whole thickness below the least steep of them (at most 1.5 times the thickness). So do all nodes of bodies
//!    with dents, whose rays may meet several faces.
//! 3. In conforming meshes, onto the offsets of the very faces that meet at the node ([`project`]). A ray may leave the offset through the plane beside:
//!    then a triangle at an edge ends up across the offset's edge and cuts it off (0.036 mm rms over the layer's inner side in a
//!    30 mm cube at 2 mm). The projection is the point nearest to the ray's that lies on the offsets of all the node's own faces:
//!    on the plane of one, the line of two, the point of three. More have no common point in general, since there the offset has
//!    small edges of its own; the squares of the residuals are least then (0.006 mm rms in all).

use super::periodic::{Bodies, Flat, PeriodicConstraint};
use super::{by_node, has_some};
use crate::cells::{Copies, InterfaceFace, NO_BODY, side_bits};
use crate::tet::TetMesh;
use meso_collision::dents::Skin;
use meso_collision::geometry::{BodyForm, Plane};
use meso_collision::math::{Aabb, Mat3, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::stop;
use std::collections::{BTreeSet, HashMap};

/// A layer takes at most this share of the depth of an aggregate's centre below its surface.
const DEEPEST: f64 = 0.8;
/// Steps of the search for the deepest point, each of which leaves two thirds: 6e-5 of the aggregate's width is left.
const DEEPEST_STEPS: usize = 24;

/// Steps of a node along a cap, and the least square of the slope of the skin there: they cut each other at 30 degrees or more.
const CAP_STEPS: usize = 6;
const LEAST_SLOPE: f64 = 0.25;

/// The map of one aggregate, or of its cut with faces of the box.
pub(super) struct RadialOffset {
    pub(super) centre: Vec3,
    /// Outward normals, and the centre's distance to every face plane where the layer begins, mm.
    pub(super) planes: Vec<(Vec3, f64)>,
    /// mm.
    pub(super) thickness: f64,
    /// Depth below the body's surface at which the layer begins, mm.
    begin: f64,
    /// The faces of a periodic box that the aggregate reaches across.
    across: Flat,
    /// A ray from the centre meets one face: not so where the body has dents.
    pub(super) has_rays: bool,
    /// The layer is thick beside an element, and the body no sphere or ellipsoid: see [`settle`](super::triangles::settle).
    pub(super) settles: bool,
    /// It is for nodes in a cap.
    in_cap: bool,
    /// The skin of a body with dents whose layer settles, or for nodes in its caps.
    skin: Option<Skin>,
}

impl RadialOffset {
    /// `None` where the aggregate hardly reaches `flat`: no direction is inward.
    fn new(
        aggregate: &Aggregate,
        [begin, end]: [f64; 2],
        thick: f64,
        flat: Flat,
        walls: &Aabb,
        periodic: [bool; 3],
    ) -> Option<Self> {
        let planes: Vec<Plane> = aggregate.body.bounding_planes();
        let aabb = aggregate.body.aabb();
        let has_rays = aggregate.body.form() != BodyForm::Surface;
        let centre = match flat {
            _ if !has_rays => aggregate.body.centroid(),
            Flat::SPACE => aggregate.body.centroid(),
            flat => {
                let free: Vec<usize> = (0..3).filter(|&axis| !flat.holds(axis)).collect();
                deepest(&planes, flat.put(&aabb.min, walls), &free, &aabb).0
            }
        };
        let below = |p: &Plane| (p.normal, p.offset - p.normal.dot(&centre) - begin);
        let planes: Vec<(Vec3, f64)> = planes.iter().map(below).collect();
        let depths = planes.iter().filter(|_| has_rays).map(|p| p.1);
        let shallowest = depths.fold(f64::INFINITY, f64::min);
        let sides =
            side_bits(|axis| [aabb.min[axis] + begin < walls.min[axis], aabb.max[axis] - begin > walls.max[axis]]);
        let thickness = (end - begin).min(DEEPEST * shallowest);
        let settles = thickness > thick && !matches!(aggregate.body.form(), BodyForm::Round(_));
        let in_cap = flat.is_in(aggregate.body.caps());
        let skin = (!has_rays && (settles || in_cap)).then(|| aggregate.body.skin(begin + thickness));
        let across = Flat::of(sides, periodic);
        (shallowest > 0.0).then_some(Self { centre, planes, thickness, begin, across, has_rays, settles, in_cap, skin })
    }

    /// The target of a node along its ray; where the body has dents, the node itself.
    pub(super) fn apply(&self, x: &Vec3) -> Vec3 {
        if !self.has_rays {
            return *x;
        }
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

    /// The step from `x` to where its nearest face is as far above it as the layer is thick.
    pub(super) fn step_to_depth(&self, x: &Vec3) -> Vec3 {
        let (inward, depth) = self.way_in(x);
        inward * (self.thickness - depth)
    }

    /// Where a node at `x` in a cap, whose target may be `target`, is deeper than now by the thickness, within the planes of
    /// `flat`; the target itself for other nodes, and where the layer settles.
    pub(super) fn along_cap(&self, x: &Vec3, target: Vec3, flat: Flat) -> Vec3 {
        if !self.in_cap || self.settles {
            return target;
        }
        let depth = self.way_in(x).1 + self.thickness;
        let step = |at: Vec3, _| {
            let (inward, now) = self.way_in(&at);
            let slope = flat.along(&inward);
            at + slope * ((depth - now) / slope.norm_squared().max(LEAST_SLOPE))
        };
        (0..CAP_STEPS).fold(target, step)
    }

    /// The unit vector away from the face nearest to `x` into the body, and the depth in the layer below it.
    fn way_in(&self, x: &Vec3) -> (Vec3, f64) {
        match &self.skin {
            Some(skin) => {
                let (nearest, distance) = skin.nearest(x).unwrap_or_default();
                let sign = if skin.surface().contains(x) { 1.0 } else { -1.0 };
                let from_surface = (x - nearest).try_normalize(ON * self.thickness).unwrap_or_default();
                (from_surface * sign, distance * sign - self.begin)
            }
            None => {
                let depths =
                    self.planes.iter().map(|(normal, depth)| (-normal, depth - normal.dot(&(x - self.centre))));
                depths.min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
            }
        }
    }

    /// The planes of the faces that hold the node at `x`.
    fn faces_at(&self, x: &Vec3) -> Vec<(Vec3, f64)> {
        let from_centre = x - self.centre;
        let near = |plane: &&(Vec3, f64)| (plane.0.dot(&from_centre) - plane.1).abs() <= ON * plane.1;
        self.planes.iter().filter(near).copied().collect()
    }
}

/// The maps of all bodies that have a layer.
pub(super) struct RadialOffsets(HashMap<(u32, Flat), RadialOffset>);

impl RadialOffsets {
    /// Layers of bodies `between` two depths, which settle above `thick` mm; nodes without an inward direction are pinned.
    pub(super) fn new(
        bodies: &Bodies,
        between: impl Fn(u32) -> [f64; 2] + Sync,
        thick: f64,
        owner: &[u32],
        constraint: &mut PeriodicConstraint,
        periodic: [bool; 3],
    ) -> Self {
        let on_faces = (0..).zip(owner).map(|(node, body)| (*body, constraint.flat(node)));
        let mut wanted: Vec<(u32, Flat)> = on_faces.filter(|(_, flat)| *flat != Flat::SPACE).collect();
        wanted.extend((0..bodies.count()).map(|body| (body, Flat::SPACE)));
        wanted.retain(|(body, _)| *body != NO_BODY && has_some(between(*body)));
        wanted.sort_unstable();
        wanted.dedup();
        let offset = |&(body, flat): &(u32, Flat)| {
            stop::point();
            let offset =
                RadialOffset::new(bodies.get(body), between(body), thick, flat, constraint.faces.walls(), periodic)?;
            Some(((body, flat), offset))
        };
        let offsets = Self(parallel::flat_map(wanted.len(), |i| offset(&wanted[i])).into_iter().collect());
        for (node, &body) in (0..).zip(owner) {
            if constraint.flat(node) != Flat::SPACE && offsets.get(body, constraint.flat(node)).is_none() {
                constraint.pin(node);
            }
        }
        offsets
    }

    /// The map of `body` for nodes on `flat`.
    pub(super) fn get(&self, body: u32, flat: Flat) -> Option<&RadialOffset> {
        self.0.get(&(body, flat))
    }

    /// The thickest layer that settles, mm; 0 without one.
    pub(super) fn thickest_to_settle(&self) -> f64 {
        self.0.values().filter(|offset| offset.settles).map(|offset| offset.thickness).fold(0.0, f64::max)
    }

    /// Aggregates too small for their thickness, with all their periodic images.
    pub(super) fn thinner(&self, bodies: &Bodies, between: impl Fn(u32) -> [f64; 2]) -> usize {
        let asked = |[begin, end]: [f64; 2]| end - begin;
        let thinner =
            |body: &u32| self.get(*body, Flat::SPACE).is_some_and(|offset| offset.thickness < asked(between(*body)));
        let ids: BTreeSet<u32> = (0..bodies.count()).filter(thinner).map(|body| bodies.get(body).id).collect();
        ids.len()
    }

    /// The targets of all nodes along their rays.
    pub(super) fn targets(&self, points: &[Vec3], owner: &[u32], constraint: &PeriodicConstraint) -> Vec<Vec3> {
        let target = |node: usize| self.target(node as u32, &points[node], owner[node], constraint);
        let mut targets = parallel::map_short(points.len(), target);
        constraint.spread(&mut targets);
        targets
    }

    /// The target of a node at `x` of a body along its ray.
    fn target(&self, node: u32, x: &Vec3, body: u32, constraint: &PeriodicConstraint) -> Vec3 {
        match self.get(body, constraint.flat(node)) {
            Some(radial) if !constraint.is_pinned(node) => {
                radial.across.hold_off(x, &radial.apply(x), constraint.faces.walls())
            }
            _ => *x,
        }
    }

    /// Puts all targets of the convex bodies whose layers settle, and have one of the nodes `stuck`, back onto their rays;
    /// whether there are any.
    pub(super) fn back_onto_rays(
        &self,
        stuck: &[u32],
        points: &[Vec3],
        owner: &[u32],
        constraint: &PeriodicConstraint,
        targets: &mut [Vec3],
    ) -> bool {
        let has_rays =
            |body: &u32| self.get(*body, Flat::SPACE).is_some_and(|radial| radial.settles && radial.has_rays);
        let bodies: BTreeSet<u32> = stuck.iter().map(|&node| owner[node as usize]).filter(has_rays).collect();
        for (node, body) in (0..).zip(owner).filter(|(_, body)| bodies.contains(body)) {
            targets[node as usize] = self.target(node, &points[node as usize], *body, constraint);
        }
        constraint.spread(targets);
        !bodies.is_empty()
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
    for _ in 0..DEEPEST_STEPS {
        let third = (high - low) / 3.0;
        if on(low + third).1 < on(high - third).1 { low += third } else { high -= third }
    }
    on((low + high) / 2.0)
}

/// A face looks away from the centroid when the cosine between its normal and the ray is above this.
const AWAY: f64 = 0.02;

/// Gives the nodes of faces that do not look away from their aggregate's centroid other targets.
pub(super) fn use_fallback_directions(
    mesh: &TetMesh,
    faces: &[InterfaceFace],
    copies: &Copies,
    offsets: &RadialOffsets,
    constraint: &PeriodicConstraint,
    targets: &mut [Vec3],
) {
    let p = |node: u32| mesh.points[node as usize];
    let mut normals: Vec<(u32, Vec3)> = Vec::with_capacity(3 * faces.len());
    let mut falls_back = vec![false; targets.len()];
    for face in faces {
        let body = mesh.owner[face.cell as usize];
        let [a, b, c, _] = face.nodes;
        let normal = (p(b) - p(a)).cross(&(p(c) - p(a))).normalize();
        let middle = (p(a) + p(b) + p(c)) / 3.0;
        for copy in [a, b, c].map(|node| copies.of(body, node)) {
            let flat = constraint.flat(copy);
            let Some(radial) = offsets.get(body, flat) else { continue };
            let (slope, ray) = (flat.along(&normal), flat.along(&(middle - radial.centre)));
            let lead = constraint.lead(copy);
            normals.push((lead, slope));
            falls_back[lead as usize] |= !radial.has_rays || slope.dot(&ray) < AWAY * ray.norm();
        }
    }
    normals.retain(|(copy, _)| falls_back[*copy as usize] && !constraint.is_pinned(*copy));
    by_node(&mut normals);
    for group in normals.chunk_by(|a, b| a.0 == b.0) {
        let copy = group[0].0;
        let around: Vec<Vec3> = group.iter().map(|(_, normal)| *normal).collect();
        let radial = offsets.get(copies.body(copy), constraint.flat(copy));
        if let (Some(radial), Some((inward, cosine))) = (radial, direction_into_all(&around)) {
            targets[copy as usize] = p(copy) + inward * (radial.thickness / cosine.max(LEAST_STEEP));
        }
    }
    constraint.spread(targets);
}

/// Steps of the search.
const DIRECTION_STEPS: usize = 60;
/// A displacement grows up to this cosine to the least steep face. Faces may look at each other where a gap is closed: nodes
/// that went farther there dragged their neighbours along (error of layers of 1 mm: 8.6 % at 1/4, 3.8 % at 2/3).
const LEAST_STEEP: f64 = 2.0 / 3.0;
/// Least cosine of a direction to all faces that counts as inward.
const STEEP: f64 = 0.05;

/// The unit vector whose least cosine to the inward `normals` (given outward) is greatest, and that cosine: exact for one
/// and two faces, within a few percent for more; `None` where no direction is inward to all.
fn direction_into_all(normals: &[Vec3]) -> Option<(Vec3, f64)> {
    let least = |inward: &Vec3| {
        let cosines = normals.iter().map(|normal| (-normal.dot(inward), *normal));
        cosines.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    };
    let mut inward = -normals.iter().sum::<Vec3>().try_normalize(1e-9)?;
    let mut best = (inward, least(&inward).0);
    let steps = if normals.len() > 2 { DIRECTION_STEPS } else { 0 };
    for step in 0..steps {
        inward = (inward - least(&inward).1 * (1.0 / (2 + step) as f64)).try_normalize(1e-9)?;
        let cosine = least(&inward).0;
        if cosine > best.1 {
            best = (inward, cosine);
        }
    }
    (best.1 > STEEP).then_some(best)
}

/// Points this far from a plane count as on it, in depths of the centre.
const ON: f64 = 1e-9;
/// Damps a step where the faces hardly decide on it: planes 2 degrees apart and less.
const DAMPING: f64 = 1e-3;
/// Steps until the damping no longer counts: each leaves half of a gap between planes 2 degrees apart, less of others.
const PROJECTION_STEPS: usize = 30;

/// Projects the targets of the copies of interface nodes onto the offsets of their own faces; copies that lie on no face of
/// their body keep their targets.
pub(super) fn project(
    mesh: &TetMesh,
    copies: &Copies,
    offsets: &RadialOffsets,
    constraint: &PeriodicConstraint,
    targets: &mut [Vec3],
) {
    let all: Vec<_> =
        copies.iter().filter(|(.., copy)| constraint.leads(*copy) && !constraint.is_pinned(*copy)).collect();
    let projected = |&(body, node, copy): &(u32, u32, u32)| {
        stop::point();
        let flat = constraint.flat(copy);
        let radial = offsets.get(body, flat)?;
        Some((copy, on_own_faces(radial, flat, &mesh.points[node as usize], &targets[copy as usize])?))
    };
    let projected = parallel::flat_map(all.len(), |i| projected(&all[i]));
    projected.into_iter().for_each(|(copy, projection)| targets[copy as usize] = projection);
    constraint.spread(targets);
}

/// The projection within `flat` for the node at `x`, whose target along its ray is `target`; none where no face holds the node.
fn on_own_faces(radial: &RadialOffset, flat: Flat, x: &Vec3, target: &Vec3) -> Option<Vec3> {
    let own = radial.faces_at(x);
    let slopes: Vec<Vec3> = own.iter().map(|plane| flat.along(&plane.0)).collect();
    let damped = slopes.iter().map(|slope| slope * slope.transpose()).sum::<Mat3>() + Mat3::identity() * DAMPING;
    let inverse = damped.try_inverse().filter(|_| !own.is_empty())?;
    let mut position = target - radial.centre;
    for _ in 0..PROJECTION_STEPS {
        let lack = |plane: &(Vec3, f64)| plane.1 - radial.thickness - plane.0.dot(&position);
        position += inverse * slopes.iter().zip(&own).map(|(slope, plane)| slope * lack(plane)).sum::<Vec3>();
    }
    Some(radial.centre + position)
}
