//! The moving bodies: shapes, poses and momenta, in arrays, in an order that keeps neighbours near in memory.

use super::contact::{LANES, Points, V, highest};
use super::obstacle;
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
    /// False where the walls, which are no box, could not all be kept in the last sweep.
    pub(super) inside: bool,
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
pub(super) struct Bodies<'a> {
    grains: &'a [Grain],
    period: Period,
    pub(super) fixed: Vec<Fixed>,
    pub(super) state: Vec<State>,
    spans: Vec<Span>,
    /// Turned vertices about the centre: x, then y, then z, each padded to a multiple of `LANES`.
    turned: Vec<f32>,
    /// Box of every body about its centre: lowest and highest coordinates.
    boxes: Vec<(V, V)>,
}

impl<'a> Bodies<'a> {
    /// The grains (by number) at their poses, ordered along a space-filling curve.
    pub(super) fn new(grains: &'a [Grain], mut poses: Vec<(u32, Pose)>, domain: &Aabb, period: Period) -> Self {
        poses.sort_by_cached_key(|(grain, pose)| (morton(&pose.centre, domain), *grain));
        let mut bodies = Self {
            grains,
            period,
            fixed: Vec::new(),
            state: Vec::new(),
            spans: Vec::new(),
            turned: Vec::new(),
            boxes: vec![([0.0; 3], [0.0; 3]); poses.len()],
        };
        let mut end = 0;
        for (grain, pose) in &poses {
            end += bodies.push(*grain, &grains[*grain as usize], pose, end);
        }
        bodies.turned = vec![0.0; end as usize];
        bodies
    }

    /// Returns how many coordinates the body takes from `start` on.
    fn push(&mut self, index: u32, grain: &Grain, pose: &Pose, start: u32) -> u32 {
        let mass = libm::pow(grain.volume, MASS_EXPONENT);
        let ball_radius = grain.ball_radius();
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
            inside: true,
            path: 0.0,
        });
        let len = grain.body.vertices().len().next_multiple_of(LANES) as u32;
        self.spans.push(Span { start, len });
        3 * len
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
    pub(super) fn advance(&mut self, walls: &Walls, step: impl Fn(u32, &[Fixed], &mut State) + Sync) {
        let Self { grains, state, spans, turned, fixed, boxes, .. } = self;
        let blocks = split(turned, spans);
        let moving = state.par_iter_mut().zip(blocks).zip(boxes).enumerate().with_min_len(256);
        moving.for_each(|(body, ((state, turned), own_box))| {
            let before = state.centre;
            step(body as u32, fixed, state);
            let vertices = grains[fixed[body].grain as usize].body.vertices();
            *own_box = widest(|| turn(vertices, turned, &state.rotation));
            (state.centre, state.inside) =
                walls.confine(state.centre, own_box, turned, f64::from(fixed[body].outer_radius));
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

    /// Every grain's number and pose.
    pub(super) fn poses(&self) -> Vec<(u32, Pose)> {
        let pose = |state: &State| Pose { rotation: Some(state.rotation), centre: state.centre };
        self.fixed.iter().zip(&self.state).map(|(fixed, state)| (fixed.grain, pose(state))).collect()
    }
}

/// The room bodies stay in.
pub(super) struct Walls<'a> {
    room: &'a dyn Room,
    /// The least distance to its surface, mm, and how much of that is there for rounding.
    gap: f64,
    margin: f64,
    /// The walls of its bounding box, already moved inwards by that; infinitely far where it has none.
    low: Vec3,
    high: Vec3,
}

/// Steps in which a body is brought back inside walls that are no box; it is looked at again in the next sweep.
const MOST_STEPS: usize = 20;
/// A step shorter than this share of the gap's margin ends it.
const SETTLED: f64 = 0.1;

impl<'a> Walls<'a> {
    /// With a `margin` (mm) beyond the gap asked for, so that rounding does not take a body out.
    pub(super) fn new(task: &'a Task, margin: f64) -> Self {
        let gap = task.request.placement.wall_gap_mm + margin;
        let Aabb { min: low, max: high } = task.period.mixed(&Aabb::everywhere(), &task.room.aabb().grown(-gap));
        Self { room: &*task.room, gap, margin, low, high }
    }

    /// The centre of a body, of its box and `turned` vertices about it, moved inside; false where that is not
    /// done yet.
    fn confine(&self, centre: Vec3, own_box: &(V, V), turned: &[f32], radius: f64) -> (Vec3, bool) {
        let mut centre = self.boxed_in(centre, own_box);
        if self.room.is_box() || self.room.depth(&centre) >= radius + self.gap {
            return (centre, true);
        }
        let (x, yz) = turned.split_at(turned.len() / 3);
        let (y, z) = yz.split_at(x.len());
        let point = |i: usize| Vec3::new(f64::from(x[i]), f64::from(y[i]), f64::from(z[i]));
        let body: Vec<Vec3> = (0..x.len()).map(point).collect();
        let own = Points { x, y, z };
        for _ in 0..MOST_STEPS {
            let inside = self.room.confine(&body, &centre, self.gap);
            let inside = self.boxed_in(self.clear_of_obstacles(&own, inside, own_box), own_box);
            let step = (inside - centre).norm();
            centre = inside;
            if step < SETTLED * self.margin {
                return (centre, true);
            }
        }
        (centre, false)
    }

    /// The centre after every obstacle near has pushed the body away in turn.
    fn clear_of_obstacles(&self, own: &Points, mut centre: Vec3, (low, high): &(V, V)) -> Vec3 {
        let corner = |v: &V| Vec3::from_fn(|i, _| f64::from(v[i])) + centre;
        let near = Aabb { min: corner(low), max: corner(high) }.grown(self.gap);
        let mut obstacles = self.room.obstacles(&near);
        // The nearest first: a wall of several triangles pushes along itself where a farther one of them is asked first.
        obstacles.sort_by_cached_key(|obstacle| obstacle::distance(obstacle.points, &centre).to_bits());
        for obstacle in &obstacles {
            centre += obstacle::push(own, &centre, obstacle, self.gap);
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

/// Turns `vertices` by `rotation` into `turned`, with copies of the first to the end; returns the box of the result.
#[inline(always)]
fn turn(vertices: &[Vec3], turned: &mut [f32], rotation: &Rotation) -> (V, V) {
    let matrix = rotation.to_rotation_matrix().into_inner().map(|entry| entry as f32);
    let (mut low, mut high) = ([[f32::INFINITY; LANES]; 3], [[f32::NEG_INFINITY; LANES]; 3]);
    let len = turned.len() / 3;
    for (block, chunk) in vertices.chunks(LANES).enumerate() {
        let vertex = |lane: usize| chunk.get(lane).unwrap_or(&vertices[0]);
        let shape: [[f32; LANES]; 3] = [0, 1, 2].map(|axis| std::array::from_fn(|lane| vertex(lane)[axis] as f32));
        for row in 0..3 {
            let out = &mut turned[row * len + block * LANES..][..LANES];
            let (low, high) = (&mut low[row], &mut high[row]);
            for (lane, out) in out.iter_mut().enumerate() {
                let [x, y, z] = [shape[0][lane], shape[1][lane], shape[2][lane]];
                let v = matrix[(row, 0)] * x + matrix[(row, 1)] * y + matrix[(row, 2)] * z;
                *out = v;
                low[lane] = if v < low[lane] { v } else { low[lane] };
                high[lane] = if v > high[lane] { v } else { high[lane] };
            }
        }
    }
    (low.map(|lanes| -highest(lanes.map(|v| -v))), high.map(highest))
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
