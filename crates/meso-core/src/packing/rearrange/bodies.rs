//! The moving bodies: shapes, poses and momenta, in arrays, in an order that keeps neighbours near in memory.

use super::contact::{LANES, Points, V};
use crate::aggregate::take::Grain;
use crate::math::{Aabb, Rotation, Vec3};
use crate::packing::place::Task;
use crate::packing::{Period, Pose, Room};
use crate::wide::widest;
use rayon::prelude::*;

/// Where the vertices of a body stand in the coordinate arrays.
#[derive(Clone, Copy)]
struct Span {
    start: u32,
    len: u32,
}

/// What of a body moves.
#[derive(Clone, Copy)]
pub(super) struct State {
    /// In the specimen, mm.
    pub(super) centre: Vec3,
    pub(super) rotation: Rotation,
    /// Movement of the last sweep, mm and radians.
    pub(super) velocity: Vec3,
    pub(super) spin: Vec3,
    /// Length of the path any point of the body has moved at the most since the start, mm.
    pub(super) path: f64,
}

/// What of a body stays.
#[derive(Clone, Copy)]
pub(super) struct Fixed {
    /// Which grain it is.
    pub(super) grain: u32,
    pub(super) outer_radius: f32,
    /// 1 / volume^0.7 and 1 / the moment of inertia of a hollow ball of that mass: small grains give way more than
    /// large ones, and turning less than moving (255 sweeps where volume^0.5 and a solid ball took 293).
    pub(super) inverse_mass: f32,
    pub(super) inverse_inertia: f32,
    /// Radius of the ball of the same volume, mm.
    pub(super) ball_radius: f32,
}

const MASS_EXPONENT: f64 = 0.7;

/// All bodies.
pub(super) struct Bodies {
    period: Period,
    pub(super) fixed: Vec<Fixed>,
    pub(super) state: Vec<State>,
    spans: Vec<Span>,
    /// Vertices about the centre: x, y, z blocks of `LANES` one after the other, as taken and as turned.
    shape: Vec<f32>,
    turned: Vec<f32>,
    /// Box of every body about its centre: lowest and highest coordinates.
    boxes: Vec<(V, V)>,
}

impl Bodies {
    /// The grains (by number) at their poses, ordered along a space-filling curve.
    pub(super) fn new(grains: &[Grain], mut poses: Vec<(u32, Pose)>, domain: &Aabb, period: Period) -> Self {
        poses.sort_by_cached_key(|(grain, pose)| (morton(&pose.centre, domain), *grain));
        let mut bodies = Self {
            period,
            fixed: Vec::new(),
            state: Vec::new(),
            spans: Vec::new(),
            shape: Vec::new(),
            turned: Vec::new(),
            boxes: vec![([0.0; 3], [0.0; 3]); poses.len()],
        };
        for (grain, pose) in &poses {
            bodies.push(*grain, &grains[*grain as usize], pose);
        }
        bodies.turned = bodies.shape.clone();
        bodies
    }

    fn push(&mut self, index: u32, grain: &Grain, pose: &Pose) {
        let mass = libm::pow(grain.volume, MASS_EXPONENT);
        let ball_radius = libm::cbrt(grain.volume * 0.75 / std::f64::consts::PI);
        self.fixed.push(Fixed {
            grain: index,
            outer_radius: grain.outer_radius as f32 * 1.000_001,
            inverse_mass: (1.0 / mass) as f32,
            inverse_inertia: (1.0 / (0.8 * mass * ball_radius * ball_radius)) as f32,
            ball_radius: ball_radius as f32,
        });
        self.state.push(State {
            centre: pose.centre,
            rotation: pose.rotation.unwrap_or(Rotation::identity()),
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
            path: 0.0,
        });
        let vertices = grain.body.vertices();
        let padded = vertices.len().next_multiple_of(LANES);
        self.spans.push(Span { start: self.shape.len() as u32, len: padded as u32 });
        for axis in 0..3 {
            let coordinates = vertices.iter().map(|v| v[axis] as f32);
            self.shape.extend(coordinates.chain(std::iter::repeat(vertices[0][axis] as f32)).take(padded));
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

    /// Centre of the nearest image of `j` seen from the centre of `i`.
    #[inline(always)]
    pub(super) fn offset(&self, i: u32, j: u32) -> V {
        let d = self.period.nearest(&(self.state[j as usize].centre - self.state[i as usize].centre));
        [d.x as f32, d.y as f32, d.z as f32]
    }

    /// True when the boxes of two bodies are less than `limit` mm apart in every coordinate.
    #[inline(always)]
    pub(super) fn boxes_within(&self, i: u32, j: u32, limit: f32) -> bool {
        let x = self.offset(i, j);
        let ((low_i, high_i), (low_j, high_j)) = (self.boxes[i as usize], self.boxes[j as usize]);
        (0..3).all(|k| x[k] + low_j[k] <= high_i[k] + limit && x[k] + high_j[k] >= low_i[k] - limit)
    }

    /// Calls `step` on every body's state, then turns its vertices and puts it back inside `walls`.
    pub(super) fn advance(&mut self, walls: &Walls, step: impl Fn(u32, &mut State) + Sync) {
        let Self { state, spans, shape, turned, fixed, boxes, .. } = self;
        let blocks = split(turned, spans);
        let moving = state.par_iter_mut().zip(blocks).zip(boxes).enumerate().with_min_len(256);
        moving.for_each(|(body, ((state, turned), own_box))| {
            let before = state.centre;
            step(body as u32, state);
            let start = spans[body].start as usize;
            *own_box = widest(|| turn(&shape[start..start + turned.len()], turned, &state.rotation));
            state.centre = walls.confine(state.centre, own_box, turned, f64::from(fixed[body].outer_radius));
            let moved = (state.centre - before).norm() + state.spin.norm() * f64::from(fixed[body].outer_radius);
            state.path += moved * 1.000_001;
        });
    }

    /// `bodies` with their centres, and with the images whose centres lie within `margin` mm of the box.
    pub(super) fn with_images(&self, bodies: impl Iterator<Item = u32>, margin: f64) -> Vec<(u32, Vec3)> {
        let placed = bodies.map(|body| (body, self.state[body as usize].centre));
        if self.period.is_none() {
            return placed.collect();
        }
        let box_size = Vec3::from_fn(|i, _| self.period.along(i).unwrap_or(0.0));
        let domain = Aabb { min: Vec3::repeat(-margin), max: box_size.add_scalar(margin) };
        let images = placed.flat_map(|(body, centre)| {
            let shifts = self.period.shifts(&Aabb { min: centre, max: centre }, &domain);
            shifts.into_iter().map(move |shift| (body, centre + shift))
        });
        images.collect()
    }

    /// Brings the centres back into a box that repeats itself.
    pub(super) fn wrap(&mut self) {
        if !self.period.is_none() {
            self.state.iter_mut().for_each(|state| state.centre = self.period.wrap(&state.centre));
        }
    }

    /// The pose of every grain of `grains`; `None` for those that are not here.
    pub(super) fn poses(&self, grains: usize) -> Vec<Option<Pose>> {
        let mut poses = vec![None; grains];
        for (fixed, state) in self.fixed.iter().zip(&self.state) {
            poses[fixed.grain as usize] = Some(Pose { rotation: Some(state.rotation), centre: state.centre });
        }
        poses
    }
}

/// The room bodies stay in.
pub(super) struct Walls<'a> {
    room: &'a dyn Room,
    /// The least distance to its surface, mm.
    gap: f64,
    /// The walls of its bounding box, already moved inwards by that; infinitely far where it has none.
    low: Vec3,
    high: Vec3,
}

/// Steps in which a body is brought back inside walls that are no box; it is looked at again in the next sweep.
const MOST_STEPS: usize = 20;

impl<'a> Walls<'a> {
    pub(super) fn new(task: &'a Task, gap: f64) -> Self {
        let aabb = task.room.aabb();
        let wall =
            |axis: usize, place: f64, beyond: f64| if task.period.along(axis).is_some() { beyond } else { place };
        Self {
            room: &*task.room,
            gap,
            low: Vec3::from_fn(|i, _| wall(i, aabb.min[i] + gap, f64::NEG_INFINITY)),
            high: Vec3::from_fn(|i, _| wall(i, aabb.max[i] - gap, f64::INFINITY)),
        }
    }

    /// The centre of a body, of its box and `turned` vertices about it, moved inside.
    fn confine(&self, centre: Vec3, own_box: &(V, V), turned: &[f32], radius: f64) -> Vec3 {
        let mut centre = self.boxed_in(centre, own_box);
        if self.room.is_box() || self.room.depth(&centre) >= radius + self.gap {
            return centre;
        }
        let (x, yz) = turned.split_at(turned.len() / 3);
        let (y, z) = yz.split_at(x.len());
        let point = |i: usize| Vec3::new(f64::from(x[i]), f64::from(y[i]), f64::from(z[i]));
        let body: Vec<Vec3> = (0..x.len()).map(point).collect();
        for _ in 0..MOST_STEPS {
            let inside = self.boxed_in(self.room.confine(&body, &centre, self.gap), own_box);
            if inside == centre {
                break;
            }
            centre = inside;
        }
        centre
    }

    fn boxed_in(&self, centre: Vec3, (low, high): &(V, V)) -> Vec3 {
        Vec3::from_fn(|i, _| centre[i].max(self.low[i] - f64::from(low[i])).min(self.high[i] - f64::from(high[i])))
    }
}

/// One mutable block of vertices per body.
fn split<'a>(mut all: &'a mut [f32], spans: &[Span]) -> Vec<&'a mut [f32]> {
    let mut blocks = Vec::with_capacity(spans.len());
    for span in spans {
        let (block, rest) = all.split_at_mut(3 * span.len as usize);
        blocks.push(block);
        all = rest;
    }
    blocks
}

#[inline(always)]
/// Turns `shape` by `rotation` into `turned`; returns the box of the result.
fn turn(shape: &[f32], turned: &mut [f32], rotation: &Rotation) -> (V, V) {
    let len = shape.len() / 3;
    let matrix = rotation.to_rotation_matrix();
    let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
    let (x, rest) = shape.split_at(len);
    let (y, z) = rest.split_at(len);
    for (row, out) in turned.chunks_exact_mut(len).enumerate() {
        let [p, q, r] = [0, 1, 2].map(|column| matrix[(row, column)] as f32);
        let (mut least, mut most) = ([f32::INFINITY; LANES], [f32::NEG_INFINITY; LANES]);
        let chunks = x.chunks_exact(LANES).zip(y.chunks_exact(LANES)).zip(z.chunks_exact(LANES));
        for (out, ((x, y), z)) in out.chunks_exact_mut(LANES).zip(chunks) {
            for lane in 0..LANES {
                let v = p * x[lane] + q * y[lane] + r * z[lane];
                out[lane] = v;
                least[lane] = if v < least[lane] { v } else { least[lane] };
                most[lane] = if v > most[lane] { v } else { most[lane] };
            }
        }
        low[row] = least.iter().fold(f32::INFINITY, |m, &v| m.min(v));
        high[row] = most.iter().fold(f32::NEG_INFINITY, |m, &v| m.max(v));
    }
    (low, high)
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
