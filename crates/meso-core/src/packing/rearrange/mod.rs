//! Rearrangement: all grains at once, overlapping where they must, moved by small rigid steps until none overlap.
//!
//! Position-based dynamics on the energy E = sum over contacts of (wanted gap - gap)^2. Every contact asks its two
//! bodies for the least rigid movement that opens it; a body moves by the sum over its contacts, divided by a power of
//! their number (Jacobi, so that threads cannot change the result), plus heavy-ball momentum, which is dropped whenever
//! the energy rises. Walls are hard. What comes out is proved apart pair by pair before anyone sees it.

mod bodies;
mod contact;
mod drop;
mod pairs;
mod prove;

use super::place::Task;
use super::{Outcome, Pose, StopReason, take_and_place};
use bodies::{Bodies, State, Walls};
use contact::{V, add_scaled, cross, dot, scale};
use pairs::{Pair, Pairs};
use rayon::prelude::*;

use crate::math::{Rotation, Vec3};

/// Random positions tried per grain before it is dropped among the others.
const START_ATTEMPTS: u32 = 60;
/// Wanted gap beyond the least one, as a share of the smallest grain's radius: room for the last digits to settle.
const SLOP: f64 = 0.004;
/// Share of the slop that must be open when it ends.
const ENOUGH: f64 = 0.2;
/// Movement is the sum over n contacts over n^0.6: 0.5 is unstable, 1 (the mean) is slow.
const RELAXATION: f64 = 0.6;
/// Momentum is dropped when the energy rises by this factor.
const RESTART: f64 = 1.1;
/// No body goes farther in a sweep than this share of its radius, nor turns by more radians.
const LONGEST_STEP: f64 = 0.25;
/// The list of pairs is made to last about this many sweeps.
const LIST_SWEEPS: f64 = 12.0;
/// It is jammed when the energy has not fallen by a tenth in so many sweeps.
const PATIENCE: u32 = 400;
/// Pairs a thread takes at once.
const CHUNK: usize = 1024;

/// Places all grains of `task`, or says why it could not and leaves out what overlaps.
pub(super) fn place(task: &Task) -> Outcome {
    let mut outcome = take_and_place::place(task, START_ATTEMPTS);
    outcome.strategy = "rearrange";
    if outcome.stop.is_some() || outcome.poses.iter().all(Option::is_some) {
        return outcome;
    }
    outcome.dead_end = StopReason::Jammed;
    let poses = drop::fill(task, &outcome.poses);
    let mut dynamics = Dynamics::new(task, &poses);
    loop {
        outcome.stop = dynamics.run(task);
        let proved = prove::keep_apart(task, &dynamics.bodies.poses(), &mut outcome.work);
        // Single precision took a pair for open that is not: ask for more room, and go on.
        if proved.left_out > 0 && dynamics.ended == Ended::Open && dynamics.ask_for_more() {
            continue;
        }
        outcome.poses = proved.poses;
        outcome.work.sweeps = u64::from(dynamics.sweep);
        return outcome;
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Ended {
    /// Every pair has its gap.
    Open,
    /// No way on, or told to stop.
    Stuck,
}

struct Dynamics {
    bodies: Bodies,
    pairs: Pairs,
    walls: Walls,
    /// mm.
    least_gap: f64,
    slop: f64,
    enough: f64,
    momentum: f64,
    sweep: u32,
    ended: Ended,
}

/// What one look at all pairs found.
#[derive(Clone, Copy, Default)]
struct Look {
    energy: f64,
    open_below: u32,
}

impl Dynamics {
    fn new(task: &Task, poses: &[Pose]) -> Self {
        let request = &task.request;
        let bodies = Bodies::new(request.grains, poses, request.specimen);
        let smallest = bodies.fixed.iter().map(|fixed| fixed.ball_radius).fold(f32::INFINITY, f32::min);
        let slop = SLOP * f64::from(smallest);
        let aabb = request.specimen.aabb();
        let inset = Vec3::repeat(request.placement.wall_gap_mm + 0.01 * slop);
        Self {
            bodies,
            pairs: Pairs::none(),
            walls: Walls { low: aabb.min + inset, high: aabb.max - inset },
            least_gap: request.placement.min_gap_mm,
            slop,
            enough: ENOUGH * slop,
            momentum: momentum(request.fraction),
            sweep: 0,
            ended: Ended::Stuck,
        }
    }

    /// Moves the bodies until every pair is open, nothing helps any more, or the task says stop.
    fn run(&mut self, task: &Task) -> Option<StopReason> {
        self.bodies.advance(&self.walls, |_, _| {});
        let (mut best, mut best_sweep, mut last) = (f64::INFINITY, self.sweep, f64::INFINITY);
        loop {
            self.renew_pairs();
            let look = self.look();
            if look.open_below == 0 {
                self.ended = Ended::Open;
                return None;
            }
            if look.energy < 0.9 * best {
                (best, best_sweep) = (look.energy, self.sweep);
            }
            if self.sweep - best_sweep > PATIENCE {
                return None;
            }
            if let Some(reason) = task.stopped(0.0) {
                return Some(reason);
            }
            let momentum = if look.energy > RESTART * last { 0.0 } else { self.momentum };
            last = look.energy;
            self.step(momentum);
            self.sweep += 1;
        }
    }

    fn ask_for_more(&mut self) -> bool {
        self.enough *= 2.0;
        self.ended = Ended::Stuck;
        self.enough < self.slop
    }

    fn renew_pairs(&mut self) {
        if !self.pairs.stale(&self.bodies) {
            return;
        }
        let fastest = self
            .bodies
            .state
            .iter()
            .zip(&self.bodies.fixed)
            .map(|(state, fixed)| state.velocity.norm() + state.spin.norm() * f64::from(fixed.outer_radius))
            .fold(0.0, f64::max);
        let skin = (LIST_SWEEPS * fastest).clamp(10.0 * self.slop, 100.0 * self.slop);
        self.pairs.rebuild(&self.bodies, self.least_gap + self.slop, skin);
    }

    /// Brings every pair's contact up to date.
    fn look(&mut self) -> Look {
        let (bodies, want) = (&self.bodies, (self.least_gap + self.slop) as f32);
        let enough = (self.least_gap + self.enough) as f32;
        let looks: Vec<Look> = self
            .pairs
            .all
            .par_chunks_mut(CHUNK)
            .map(|pairs| {
                let mut look = Look::default();
                for pair in pairs {
                    let short = update(bodies, pair, want);
                    look.energy += f64::from(short) * f64::from(short);
                    look.open_below += u32::from(short > want - enough);
                }
                look
            })
            .collect();
        looks.iter().fold(Look::default(), |sum, look| Look {
            energy: sum.energy + look.energy,
            open_below: sum.open_below + look.open_below,
        })
    }

    fn step(&mut self, momentum: f64) {
        let Self { bodies, pairs, walls, least_gap, slop, .. } = self;
        let want = (*least_gap + *slop) as f32;
        let fixed = bodies.fixed.clone();
        bodies.advance(walls, |body, state| {
            let own = fixed[body as usize];
            let (push, twist, contacts) = pushes(pairs, &fixed, body, want);
            let share = relaxation(contacts);
            let far = LONGEST_STEP * f64::from(own.ball_radius);
            state.velocity = clip(state.velocity * momentum + to_vec3(push) * share, far);
            state.spin = clip(state.spin * momentum + to_vec3(twist) * share, LONGEST_STEP);
            advance(state);
        });
    }
}

/// Momentum by density: little where grains are free, much where they wedge (measured: benches/results).
fn momentum(fraction: f64) -> f64 {
    (0.75 + (fraction - 0.5) / 0.15 * 0.2).clamp(0.7, 0.95)
}

/// How much of the wanted gap a pair lacks; 0 where it lacks none.
fn update(bodies: &Bodies, pair: &mut Pair, want: f32) -> f32 {
    let (a, b) = (pair.a, pair.b);
    let paths = bodies.state[a as usize].path + bodies.state[b as usize].path;
    if pair.clear - paths > f64::from(want) {
        pair.contact.gap = want;
        return 0.0;
    }
    let (p, q, x) = (bodies.points(a), bodies.points(b), bodies.offset(a, b));
    pair.contact.gap = contact::gap_along(&p, &q, x, pair.contact.normal);
    if pair.contact.gap < want {
        pair.contact.refresh(&p, &q, x);
    }
    pair.clear = f64::from(pair.contact.gap) + paths;
    (want - pair.contact.gap).max(0.0)
}

/// Sum of the movements and turns that the contacts of `body` ask for, and their number.
fn pushes(pairs: &Pairs, fixed: &[bodies::Fixed], body: u32, want: f32) -> (V, V, usize) {
    let (mut push, mut twist, mut count) = ([0.0; 3], [0.0; 3], 0);
    for pair in pairs.as_first(body).filter(|pair| pair.contact.gap < want) {
        let impulse = impulse(pair, fixed, want);
        let own = fixed[body as usize];
        push = add_scaled(push, pair.contact.normal, -impulse * own.inverse_mass);
        twist = add_scaled(twist, cross(pair.contact.on_a, pair.contact.normal), -impulse * own.inverse_inertia);
        count += 1;
    }
    for pair in pairs.as_second(body).filter(|pair| pair.contact.gap < want) {
        let impulse = impulse(pair, fixed, want);
        let own = fixed[body as usize];
        push = add_scaled(push, pair.contact.normal, impulse * own.inverse_mass);
        twist = add_scaled(twist, cross(pair.contact.on_b, pair.contact.normal), impulse * own.inverse_inertia);
        count += 1;
    }
    (push, twist, count)
}

/// The impulse along the normal that would open the pair by what it lacks.
fn impulse(pair: &Pair, fixed: &[bodies::Fixed], want: f32) -> f32 {
    let (a, b) = (fixed[pair.a as usize], fixed[pair.b as usize]);
    let (lever_a, lever_b) =
        (cross(pair.contact.on_a, pair.contact.normal), cross(pair.contact.on_b, pair.contact.normal));
    let ease = a.inverse_mass
        + b.inverse_mass
        + dot(lever_a, lever_a) * a.inverse_inertia
        + dot(lever_b, lever_b) * b.inverse_inertia;
    (want - pair.contact.gap) / ease
}

fn relaxation(contacts: usize) -> f64 {
    libm::pow(contacts.max(1) as f64, -RELAXATION)
}

fn clip(v: Vec3, longest: f64) -> Vec3 {
    let length = v.norm();
    if length > longest { v * (longest / length) } else { v }
}

/// Moves by the velocity and turns by the spin (to second order, then made a rotation again).
fn advance(state: &mut State) {
    state.centre += state.velocity;
    let half = state.spin * 0.5;
    let turn = nalgebra::Quaternion::new(1.0 - half.norm_squared() / 2.0, half.x, half.y, half.z);
    state.rotation = Rotation::from_quaternion(turn * state.rotation.quaternion());
}

fn to_vec3(v: V) -> Vec3 {
    let v = scale(v, 1.0);
    Vec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}
