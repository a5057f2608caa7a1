//! The moving bodies: shapes, poses and momenta, in arrays, in an order that keeps neighbours near in memory.

use super::contact::{LANES, Points, V, dot, length, scale};
use super::dents::{DentedShapes, Surfaces};
use super::fibres;
use super::turn::{outer_radius, turn, turn_on, vertex_count};
use super::walls::Walls;
use crate::task::Task;
use crate::{Pose, Turn};
use meso_collision::geometry::BodyForm;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Grain;
use meso_concrete::parallel;
use meso_concrete::specimen::Period;
use nalgebra::{Quaternion, Vector3};
use rayon::prelude::*;

/// Range of a body's vertices in the coordinate arrays.
#[derive(Clone, Copy)]
struct Span {
    start: u32,
    len: u32,
}

/// The moving state of a body.
#[derive(Clone, Copy)]
pub(super) struct State {
    /// In the specimen, mm.
    pub(super) centre: Vec3,
    pub(super) rotation: Turn,
    /// Movement of the last sweep, mm and radians.
    pub(super) velocity: V,
    pub(super) spin: V,
    /// False where the walls of a container that is no box could not all be kept in the last sweep.
    pub(super) inside: bool,
    /// By axis, the side on which a wall of the specimen's box held the body back in the last sweep: -1, 1, or 0 for
    /// none.
    pub(super) held: [i8; 3],
}

impl State {
    /// At rest.
    fn at(pose: &Pose) -> Self {
        Self {
            centre: pose.centre,
            rotation: pose.turn.unwrap_or(Turn::identity()),
            velocity: [0.0; 3],
            spin: [0.0; 3],
            inside: true,
            held: [0; 3],
        }
    }

    /// Turns by the spin, to second order.
    fn turn(&self) -> Turn {
        let [x, y, z] = scale(self.spin, 0.5);
        Turn::from_quaternion(Quaternion::new(1.0 - dot([x, y, z], [x, y, z]) / 2.0, x, y, z))
    }

    /// Moves by the velocity and turns by the spin.
    fn advance(&mut self) {
        self.centre += widened(self.velocity);
        self.rotation = Turn::from_quaternion((self.turn() * self.rotation).into_inner());
    }

    /// Bound on the displacement of any point of the body in a sweep, mm.
    pub(super) fn speed(&self, fixed: &Fixed) -> f32 {
        length(self.velocity) + length(self.spin) * fixed.outer_radius
    }

    /// Share of a push in the unit direction `d` that acts against walls which hold the body.
    #[inline(always)]
    pub(super) fn held_against(&self, d: V) -> f32 {
        let against = |k: usize| if f32::from(self.held[k]) * d[k] > 0.0 { d[k] * d[k] } else { 0.0 };
        against(0) + against(1) + against(2)
    }

    fn rests(&self) -> bool {
        self.velocity == [0.0; 3] && self.spin == [0.0; 3] && self.inside
    }
}

/// The constant properties of a body.
#[derive(Clone, Copy)]
pub(super) struct Fixed {
    /// Which grain it is.
    pub(super) grain: u32,
    pub(super) outer_radius: f32,
    /// 1 / volume^0.7, and 1 / the moment of inertia of a hollow ball of that mass. Small grains yield more than
    /// large ones, and rotations yield less than translations (255 sweeps where volume^0.5 and a solid ball took
    /// 293).
    pub(super) inverse_mass: f32,
    pub(super) inverse_inertia: f32,
    /// Radius of the ball of the same volume, mm.
    pub(super) ball_radius: f32,
}

const MASS_EXPONENT: f64 = 0.7;

impl Fixed {
    fn new(index: u32, grain: &Grain) -> Self {
        let mass = libm::pow(grain.volume(), MASS_EXPONENT) * fibres::weight(grain);
        Self {
            grain: index,
            outer_radius: outer_radius(grain) * 1.000_001,
            inverse_mass: (1.0 / mass) as f32,
            inverse_inertia: (1.0 / fibres::inertia(grain, mass)) as f32,
            ball_radius: grain.ball_radius() as f32,
        }
    }
}

/// A body moves at most this share of its radius before its pairs are searched again: a longer limit would list too
/// many.
pub(super) const MOST_MARGIN: f32 = 0.125;

/// All bodies.
pub(super) struct Bodies<'a> {
    grains: &'a [Grain],
    period: Period,
    pub(super) fixed: Vec<Fixed>,
    pub(super) state: Vec<State>,
    spans: Vec<Span>,
    /// From the centre of every fibre to its end, before it is turned, mm; zero for all else, empty without fibres.
    axes: Vec<V>,
    /// Radius of every ball, whose only vertex is its centre, or margin of a grain with dents, mm; zero for all else,
    /// empty where all are.
    rims: Vec<f32>,
    /// Surfaces of grains with dents, where more than their hulls is seen.
    surfaces: Option<Surfaces>,
    /// Turned vertices about the centre: x, then y, then z, each padded to a multiple of `LANES`.
    turned: Vec<f32>,
    /// Box of every body about its centre: lowest and highest coordinates.
    boxes: Vec<(V, V)>,
    /// Bound on the path of any point of a body since all pairs were listed, mm.
    paths: Vec<f32>,
    /// The longest path for which the pairs listed of a body are all that may be contacts, mm.
    limits: Vec<f32>,
}

/// Sweeps after which the vertices are turned from the grain's own again, before rounding shows.
const TURN_ANEW: u32 = 128;

impl<'a> Bodies<'a> {
    /// The grains (by number) at their poses, ordered along a space-filling curve.
    pub(super) fn new(task: &'a Task<'a>, mut poses: Vec<(u32, Pose)>, dents: Option<&DentedShapes>) -> Self {
        let (grains, domain, period) = (task.request.grains, task.container.aabb(), task.period);
        poses.par_sort_by_cached_key(|(grain, pose)| (morton(&pose.centre, &domain), *grain));
        let grain = |(grain, _): &(u32, Pose)| &grains[*grain as usize];
        let (mut spans, mut end) = (Vec::with_capacity(poses.len()), 0);
        for pose in &poses {
            let len = vertex_count(&grain(pose).body).next_multiple_of(LANES) as u32;
            spans.push(Span { start: end, len });
            end += 3 * len;
        }
        Self {
            grains,
            period,
            fixed: parallel::map_each(&poses, |pose| Fixed::new(pose.0, grain(pose))),
            state: parallel::map_each(&poses, |(_, pose)| State::at(pose)),
            spans,
            axes: fibres::axes(poses.iter().map(grain)),
            rims: rims(poses.iter().map(|pose| (pose.0, grain(pose))), dents),
            surfaces: dents.map(|dents| dents.surfaces(poses.iter().map(grain))),
            turned: vec![0.0; end as usize],
            boxes: vec![([0.0; 3], [0.0; 3]); poses.len()],
            paths: vec![0.0; poses.len()],
            limits: vec![0.0; poses.len()],
        }
    }

    pub(super) fn len(&self) -> usize {
        self.fixed.len()
    }

    /// Turned vertices of a body about its centre.
    #[inline(always)]
    pub(super) fn points(&self, body: u32) -> Points<'_> {
        let Span { start, len } = self.spans[body as usize];
        let (start, len) = (start as usize, len as usize);
        let all = &self.turned[start..start + 3 * len];
        Points { x: &all[..len], y: &all[len..2 * len], z: &all[2 * len..] }
    }

    /// The surfaces of two bodies, where both have dents and more than their hulls is seen.
    #[inline(always)]
    pub(super) fn surfaces(&self, a: u32, b: u32) -> Option<&Surfaces> {
        self.surfaces.as_ref().filter(|surfaces| surfaces.both(a, b))
    }

    /// Radius of a ball, whose points are its centre alone, or margin of a grain with dents, mm; 0 for all else.
    #[inline(always)]
    pub(super) fn rim(&self, body: u32) -> f32 {
        self.rims.get(body as usize).copied().unwrap_or(0.0)
    }

    /// Centre of the nearest image of `j` seen from the centre of `i`.
    #[inline(always)]
    pub(super) fn offset(&self, i: u32, j: u32) -> V {
        let d = self.period.nearest(&(self.state[j as usize].centre - self.state[i as usize].centre));
        [d.x as f32, d.y as f32, d.z as f32]
    }

    /// Vector from the middle of `i` to the middle of `j`, whose centres are `x` apart; the middle of a fibre is the
    /// nearest point of its axis.
    #[inline(always)]
    pub(super) fn middle_offset(&self, i: u32, j: u32, x: V) -> V {
        if self.axes.is_empty() { x } else { fibres::between_axes(self.axis(i), self.axis(j), x) }
    }

    fn axis(&self, body: u32) -> V {
        let axis = self.axes[body as usize];
        if axis == [0.0; 3] { axis } else { (self.state[body as usize].rotation * Vector3::from(axis)).into() }
    }

    /// A lower bound of the gap between two bodies, by their boxes, mm.
    #[inline(always)]
    pub(super) fn box_gap(&self, i: u32, j: u32) -> f32 {
        let x = self.offset(i, j);
        let ((low_i, high_i), (low_j, high_j)) = (self.boxes[i as usize], self.boxes[j as usize]);
        let along = |k: usize| (x[k] + low_j[k] - high_i[k]).max(low_i[k] - x[k] - high_j[k]);
        along(0).max(along(1)).max(along(2))
    }

    /// Bound on the body's path since all pairs were listed, mm.
    #[inline(always)]
    pub(super) fn path(&self, body: u32) -> f32 {
        self.paths[body as usize]
    }

    /// Such bounds for all bodies.
    pub(super) fn paths(&self) -> &[f32] {
        &self.paths
    }

    /// How far the body may still move before its pairs must be searched again, mm.
    #[inline(always)]
    pub(super) fn margin(&self, body: u32) -> f32 {
        self.limits[body as usize] - self.paths[body as usize]
    }

    /// The bodies that may be near others that the list of pairs does not name.
    pub(super) fn beyond_limits(&self) -> Vec<u32> {
        self.filter(|body| self.margin(body) < 0.0)
    }

    /// The bodies for which `keep` holds.
    pub(super) fn filter(&self, keep: impl Fn(u32) -> bool + Sync) -> Vec<u32> {
        parallel::filter(self.len(), |body| keep(body as u32))
    }

    /// Limit for about `sweeps` sweeps at the body's speed, but at least `least` mm.
    fn limit(&self, body: u32, sweeps: f32, least: f32) -> f32 {
        let (state, fixed) = (&self.state[body as usize], &self.fixed[body as usize]);
        self.path(body) + (sweeps * state.speed(fixed)).max(least).min(MOST_MARGIN * fixed.ball_radius)
    }

    /// Sets new limits for `bodies`.
    pub(super) fn go_on(&mut self, bodies: &[u32], sweeps: f32, least: f32) {
        let limits = parallel::map_short(bodies.len(), |k| self.limit(bodies[k], sweeps, least));
        bodies.iter().zip(limits).for_each(|(&body, limit)| self.limits[body as usize] = limit);
    }

    /// Resets all paths; returns the old ones.
    pub(super) fn start_again(&mut self) -> Vec<f32> {
        let fresh = vec![0.0; self.len()];
        std::mem::replace(&mut self.paths, fresh)
    }

    /// Turns all vertices from the grains' own, and puts the bodies inside `walls`.
    pub(super) fn settle(&mut self, walls: &Walls) {
        let (grains, fixed, rims) = (self.grains, &self.fixed, &self.rims);
        moving(&mut self.state, &mut self.turned, &self.spans, &mut self.boxes, &mut self.paths, |body, moving| {
            let shape = &grains[fixed[body].grain as usize].body;
            *moving.own_box = turn(shape, moving.turned, &moving.state.rotation);
            moving.confine(walls, &fixed[body], rims.get(body));
        });
    }

    /// Calls `step` on every body's state, to set its velocity and spin; then moves it by them and puts it back inside
    /// `walls`.
    pub(super) fn advance(&mut self, sweep: u32, walls: &Walls, step: impl Fn(u32, &Fixed, &mut State) + Sync) {
        let (grains, fixed, rims) = (self.grains, &self.fixed, &self.rims);
        let is_due = sweep.is_multiple_of(TURN_ANEW);
        moving(&mut self.state, &mut self.turned, &self.spans, &mut self.boxes, &mut self.paths, |body, moving| {
            step(body as u32, &fixed[body], moving.state);
            if moving.state.rests() {
                return;
            }
            let turn_by = moving.state.turn();
            moving.state.advance();
            *moving.own_box = if is_due {
                let shape = &grains[fixed[body].grain as usize].body;
                turn(shape, moving.turned, &moving.state.rotation)
            } else {
                turn_on(moving.turned, &turn_by)
            };
            moving.confine(walls, &fixed[body], rims.get(body));
        });
    }

    /// `bodies` with their centres, and with the images whose centres lie within `margin` mm of the box.
    pub(super) fn with_images(&self, bodies: &[u32], margin: f64) -> Vec<(u32, V)> {
        let narrow = |centre: Vec3| centre.map(|x| x as f32).into();
        let placed = |k: usize| (bodies[k], self.state[bodies[k] as usize].centre);
        if self.period.is_none() {
            return parallel::map_short(bodies.len(), |k| {
                let (body, centre) = placed(k);
                (body, narrow(centre))
            });
        }
        let box_size = Vec3::from_fn(|i, _| self.period.along(i).unwrap_or(0.0));
        let domain = Aabb { min: Vec3::repeat(-margin), max: box_size.add_scalar(margin) };
        parallel::flat_map(bodies.len(), |k| {
            let (body, centre) = placed(k);
            let shifts = self.period.shifts(&Aabb { min: centre, max: centre }, &domain);
            shifts.into_iter().map(move |shift| (body, narrow(centre + shift)))
        })
    }

    /// Brings the centres back into a box that repeats itself.
    pub(super) fn wrap(&mut self) {
        if !self.period.is_none() {
            self.state.iter_mut().for_each(|state| state.centre = self.period.wrap(&state.centre));
        }
    }

    /// Every grain's number and pose.
    pub(super) fn poses(&self) -> Vec<(u32, Pose)> {
        let pose = |state: &State| Pose { turn: Some(state.rotation), centre: state.centre };
        self.fixed.iter().zip(&self.state).map(|(fixed, state)| (fixed.grain, pose(state))).collect()
    }
}

/// A body while it moves.
struct Moving<'a> {
    state: &'a mut State,
    turned: &'a mut [f32],
    own_box: &'a mut (V, V),
    path: &'a mut f32,
}

impl Moving<'_> {
    /// Puts the body inside `walls`, and notes how far it has gone in this sweep. A ball has a `rim` around its points.
    fn confine(self, walls: &Walls, fixed: &Fixed, rim: Option<&f32>) {
        let Self { state, turned, own_box, path } = self;
        let rim = rim.copied().unwrap_or(0.0);
        if rim > 0.0 {
            *own_box = (own_box.0.map(|low| low - rim), own_box.1.map(|high| high + rim));
        }
        let free = state.centre;
        state.held = walls.holds(&free, own_box);
        (state.centre, state.inside) = walls.confine(free, own_box, (turned, rim), f64::from(fixed.outer_radius));
        let moved = (state.centre - free + widened(state.velocity)).norm() as f32;
        *path += (moved + length(state.spin) * fixed.outer_radius) * 1.000_01;
    }
}

/// Radii of balls and margins of grains with dents, zero for all else; empty where all are.
fn rims<'a>(grains: impl Iterator<Item = (u32, &'a Grain)>, dents: Option<&DentedShapes>) -> Vec<f32> {
    let radius = |(number, grain): (u32, &Grain)| match grain.body.form() {
        BodyForm::Round(round) => round.radius().unwrap_or(0.0) as f32,
        BodyForm::Hull | BodyForm::Surface => dents.map_or(0.0, |dents| dents.margin(number)),
    };
    let rims: Vec<f32> = grains.map(radius).collect();
    if rims.iter().any(|rim| *rim > 0.0) { rims } else { Vec::new() }
}

/// Bodies a thread moves at once.
pub(super) const CHUNK: usize = 256;

/// Calls `each` with every body's number and moving state.
fn moving(
    state: &mut [State],
    mut turned: &mut [f32],
    spans: &[Span],
    boxes: &mut [(V, V)],
    paths: &mut [f32],
    each: impl Fn(usize, Moving) + Sync,
) {
    let mut chunks = Vec::with_capacity(spans.len().div_ceil(CHUNK));
    let bodies = state.chunks_mut(CHUNK).zip(boxes.chunks_mut(CHUNK)).zip(paths.chunks_mut(CHUNK));
    for (((states, boxes), paths), spans) in bodies.zip(spans.chunks(CHUNK)) {
        let (own, rest) = turned.split_at_mut(spans.iter().map(|span| 3 * span.len as usize).sum());
        chunks.push((states, boxes, paths, own, spans));
        turned = rest;
    }
    parallel::each_mut(&mut chunks, |number, (states, boxes, paths, turned, spans)| {
        let mut turned = &mut **turned;
        let bodies = states.iter_mut().zip(&mut **boxes).zip(&mut **paths).zip(&**spans);
        for (k, (((state, own_box), path), span)) in bodies.enumerate() {
            let (own, rest) = turned.split_at_mut(3 * span.len as usize);
            turned = rest;
            each(number * CHUNK + k, Moving { state, turned: own, own_box, path });
        }
    });
}

/// Position along the Morton curve over the specimen's box, 21 bits a coordinate.
fn morton(point: &Vec3, aabb: &Aabb) -> u64 {
    let size = aabb.size().max();
    (0..3).fold(0, |code, i| {
        code | spread_bits((((point[i] - aabb.min[i]) / size).clamp(0.0, 1.0) * 2_097_151.0) as u64) << i
    })
}

fn spread_bits(mut v: u64) -> u64 {
    v = (v | v << 32) & 0x001f_0000_0000_ffff;
    v = (v | v << 16) & 0x001f_0000_ff00_00ff;
    v = (v | v << 8) & 0x100f_00f0_0f00_f00f;
    v = (v | v << 4) & 0x10c3_0c30_c30c_30c3;
    (v | v << 2) & 0x1249_2492_4924_9249
}

pub(super) fn widened(v: V) -> Vec3 {
    Vec3::from_fn(|i, _| f64::from(v[i]))
}
