//! Rearrangement: all grains at once, overlapping where they must, moved by small rigid steps until none overlap.
//!
//! Position-based dynamics on the energy E = sum over contacts of (wanted gap - gap)^2. Every contact asks its two
//! bodies for the least rigid movement that opens it; a body moves by the sum over its contacts, divided by a power of
//! their number (Jacobi, so that threads cannot change the result), plus heavy-ball momentum, which is dropped whenever
//! the energy rises. Walls are hard. What comes out is proved apart pair by pair before anyone sees it.

mod bodies;
mod contact;
mod drop;
mod obstacle;
mod pairs;
mod prove;

use super::place::Task;
use super::{Outcome, Pose, StopReason, Work};
use bodies::{Bodies, State, Walls};
use contact::{V, add_scaled, cross, dot, scale};
use pairs::{Pair, Pairs};
use rayon::prelude::*;

use crate::aggregate::take::Grain;
use crate::math::{Rotation, Vec3};
use crate::wide::widest;

/// Wanted gap beyond the least one, as a share of the smallest grain's radius: room for the last digits to settle.
const SLOP: f64 = 0.004;
/// Margin at walls that are no box, as a share of the slop: single precision sees their far ends.
const ROUND_MARGIN: f64 = 0.1;
/// Share of the slop that must be open when it ends.
const ENOUGH: f64 = 0.2;
/// Movement is the sum over n contacts over n^0.4. With momentum such long steps are stable, and momentum can be less:
/// at 0.65, n^0.6 and 0.94 took 167 sweeps, n^0.4 and 0.91 120.
const RELAXATION: f64 = 0.4;
/// Beyond so many contacts the movement is damped no further.
const MOST_CONTACTS: usize = 256;
/// Momentum is dropped when the energy rises by this factor.
const RESTART: f64 = 1.1;
/// No body goes farther in a sweep than this share of its radius, nor turns by more radians.
const LONGEST_STEP: f64 = 0.25;
/// The list of pairs is made to last about this many sweeps.
const LIST_SWEEPS: f64 = 6.0;
/// The list reaches at most so many slops beyond a contact: a longer one costs more than making it anew.
const MOST_SKIN: f64 = 80.0;
/// It is jammed when the energy has not fallen by a tenth in so many sweeps.
const PATIENCE: u32 = 150;
/// Pairs a thread takes at once.
const CHUNK: usize = 1024;

/// A jam is relieved by leaving out the worst wedged grains, up to this share of the volume at a time.
const RELIEF: f64 = 0.02;

/// Places all grains of `task`, or as many as go, and says why.
pub(super) fn place(task: &Task) -> Outcome {
    let mut outcome = Outcome {
        poses: vec![None; task.request.grains.len()],
        work: Work::default(),
        stop: task.stopped(0.0),
        dead_end: StopReason::Jammed,
        strategy: "rearrange",
        itz_limited: Vec::new(),
        largest_mm3: Vec::new(),
    };
    // A stop during the take has left grains out; nothing placed of them would be what was asked.
    if outcome.stop.is_some() || outcome.poses.is_empty() {
        return outcome;
    }
    let mut settings = Settings::new(task);
    let mut poses = (0..).zip(drop::fill(task)).collect();
    loop {
        // The lists of the dynamics are gone when the proof makes its own.
        let (ended, reached) = Dynamics::new(task, poses, settings).run(task, &mut outcome.work.sweeps);
        let proved = prove::keep_apart(task, &reached, &mut outcome.work);
        // Single precision took a pair for open that is not: ask for more room, and go on.
        if proved.left_out > 0 && ended == Ended::Open && settings.ask_for_more() {
            poses = reached;
            continue;
        }
        if let Ended::Told(reason) = ended {
            outcome.stop = Some(reason);
        }
        outcome.poses = proved.poses;
        return outcome;
    }
}

/// How a run of sweeps ended.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ended {
    /// Every pair has its gap.
    Open,
    /// The overlaps do not shrink any more.
    Jammed,
    /// The task said stop.
    Told(StopReason),
}

/// How far apart the bodies are moved.
#[derive(Clone, Copy)]
struct Settings {
    /// mm.
    least_gap: f64,
    /// Wanted beyond `least_gap`, mm.
    slop: f64,
    /// Of this, what must be open when it ends, mm.
    enough: f64,
    momentum: f64,
}

impl Settings {
    fn new(task: &Task) -> Self {
        let smallest = task.request.grains.iter().map(Grain::ball_radius).fold(f64::INFINITY, f64::min);
        let slop = SLOP * smallest;
        Self {
            least_gap: task.request.placement.min_gap_mm,
            slop,
            enough: ENOUGH * slop,
            momentum: momentum(task.request.fraction),
        }
    }

    fn ask_for_more(&mut self) -> bool {
        self.enough *= 2.0;
        self.enough < self.slop
    }

    /// The gap that makes a pair no contact.
    fn want(&self) -> f32 {
        (self.least_gap + self.slop) as f32
    }
}

struct Dynamics<'a> {
    bodies: Bodies<'a>,
    pairs: Pairs,
    walls: Walls<'a>,
    settings: Settings,
    /// Share of the summed movement that is done, by the number of contacts.
    relaxations: Vec<f32>,
    sweep: u32,
}

/// What one look at all pairs found.
#[derive(Clone, Copy, Default)]
struct Look {
    energy: f64,
    open_below: u32,
}

impl<'a> Dynamics<'a> {
    fn new(task: &'a Task<'a>, poses: Vec<(u32, Pose)>, settings: Settings) -> Self {
        let request = &task.request;
        Self {
            bodies: Bodies::new(request.grains, poses, &task.room.aabb(), task.period),
            pairs: Pairs::none(),
            walls: Walls::new(task, if task.room.is_box() { 0.01 } else { ROUND_MARGIN } * settings.slop),
            settings,
            relaxations: relaxations(),
            sweep: 0,
        }
    }

    /// Moves the bodies until every pair is open, or the task says stop; where nothing helps any more, leaves out the
    /// worst wedged.
    fn run(mut self, task: &Task<'a>, sweeps: &mut u64) -> (Ended, Vec<(u32, Pose)>) {
        loop {
            let ended = self.descend(task);
            if ended == Ended::Jammed {
                self.relieve(task);
                continue;
            }
            *sweeps += u64::from(self.sweep);
            return (ended, self.bodies.poses());
        }
    }

    /// Sweeps until every pair is open, nothing helps any more, or the task says stop.
    fn descend(&mut self, task: &Task) -> Ended {
        self.bodies.advance(&self.walls, |_, _, _| {});
        let (mut best, mut best_sweep, mut last) = (f64::INFINITY, self.sweep, f64::INFINITY);
        loop {
            self.renew_pairs();
            let look = self.look();
            if look.open_below == 0 {
                return Ended::Open;
            }
            if look.energy < 0.9 * best {
                (best, best_sweep) = (look.energy, self.sweep);
            }
            if self.sweep - best_sweep > PATIENCE {
                return Ended::Jammed;
            }
            if let Some(reason) = task.stopped(0.0) {
                return Ended::Told(reason);
            }
            let momentum = if look.energy > RESTART * last { 0.0 } else { self.settings.momentum };
            last = look.energy;
            self.step(momentum);
            self.sweep += 1;
        }
    }

    /// Leaves out the grains with the most overlap for their volume.
    fn relieve(&mut self, task: &Task<'a>) {
        let grains = task.request.grains;
        let want = self.settings.want();
        let mut worst: Vec<(f64, u32)> = (0..self.bodies.len() as u32)
            .map(|body| {
                let pairs = self.pairs.as_first(body).chain(self.pairs.as_second(body));
                let energy: f64 = pairs.map(|pair| f64::from((want - pair.contact.gap).max(0.0)).powi(2)).sum();
                let grain = self.bodies.fixed[body as usize].grain;
                let inside = self.bodies.state[body as usize].inside;
                (if inside { energy / grains[grain as usize].volume } else { f64::INFINITY }, grain)
            })
            .collect();
        worst.sort_unstable_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
        let mut poses = self.bodies.poses();
        let mut budget = RELIEF * poses.iter().map(|&(grain, _)| grains[grain as usize].volume).sum::<f64>();
        let mut left_out = vec![false; grains.len()];
        for (_, grain) in worst {
            left_out[grain as usize] = true;
            budget -= grains[grain as usize].volume;
            if budget <= 0.0 {
                break;
            }
        }
        poses.retain(|&(grain, _)| !left_out[grain as usize]);
        self.bodies = Bodies::new(grains, poses, &task.room.aabb(), task.period);
        self.pairs = Pairs::none();
    }

    fn renew_pairs(&mut self) {
        if !self.pairs.stale(&self.bodies) {
            return;
        }
        self.bodies.wrap();
        let fastest = self
            .bodies
            .state
            .iter()
            .zip(&self.bodies.fixed)
            .map(|(state, fixed)| state.velocity.norm() + state.spin.norm() * f64::from(fixed.outer_radius))
            .fold(0.0, f64::max);
        let slop = self.settings.slop;
        let skin = (LIST_SWEEPS * fastest).clamp(10.0 * slop, MOST_SKIN * slop);
        self.pairs.rebuild(&self.bodies, f64::from(self.settings.want()), skin);
    }

    /// Brings every pair's contact up to date.
    fn look(&mut self) -> Look {
        let (bodies, want) = (&self.bodies, self.settings.want());
        let enough = (self.settings.least_gap + self.settings.enough) as f32;
        let looks: Vec<Look> =
            self.pairs.all.par_chunks_mut(CHUNK).map(|pairs| widest(|| look_at(bodies, pairs, want, enough))).collect();
        let outside = bodies.state.iter().filter(|state| !state.inside).count() as u32;
        let start = Look { energy: 0.0, open_below: outside };
        looks.iter().fold(start, |sum, look| Look {
            energy: sum.energy + look.energy,
            open_below: sum.open_below + look.open_below,
        })
    }

    fn step(&mut self, momentum: f64) {
        let Self { bodies, pairs, walls, settings, relaxations, .. } = self;
        let want = settings.want();
        bodies.advance(walls, |body, fixed, state| {
            let (push, twist, contacts) = pushes(pairs, fixed, body, want);
            let share = relaxations[contacts.min(MOST_CONTACTS)];
            let far = LONGEST_STEP * f64::from(fixed[body as usize].ball_radius);
            state.velocity = clip(state.velocity * momentum + to_vec3(scale(push, share)), far);
            state.spin = clip(state.spin * momentum + to_vec3(scale(twist, share)), LONGEST_STEP);
            advance(state);
        });
    }
}

/// Momentum by density: little where grains are free, much where they wedge. Sweeps in the 150 mm cube: 0.50: 29 with 0.7,
/// 38 with 0.8; 0.60: 70 with 0.85, 168 with 0.8; 0.68: 242 with 0.94, 712 with 0.92.
fn momentum(fraction: f64) -> f64 {
    (0.7 + (fraction - 0.5) * 1.4).clamp(0.6, 0.945)
}

#[inline(always)]
fn look_at(bodies: &Bodies, pairs: &mut [Pair], want: f32, enough: f32) -> Look {
    let mut look = Look::default();
    for pair in pairs {
        let short = update(bodies, pair, want);
        look.energy += f64::from(short) * f64::from(short);
        look.open_below += u32::from(short > want - enough);
    }
    look
}

/// How much of the wanted gap a pair lacks; 0 where it lacks none.
#[inline(always)]
fn update(bodies: &Bodies, pair: &mut Pair, want: f32) -> f32 {
    let (a, b) = (pair.a, pair.b);
    let paths = bodies.state[a as usize].path + bodies.state[b as usize].path;
    if pair.clear - paths > f64::from(want) {
        pair.contact.gap = want;
        return 0.0;
    }
    let was_clear = pair.contact.gap >= want;
    if was_clear && !bodies.boxes_within(a, b, want) {
        return 0.0;
    }
    let (p, q, x) = (bodies.points(a), bodies.points(b), bodies.offset(a, b));
    // A pair that was in contact most likely still is: its query, started from the old features, finds the gap, too.
    if was_clear {
        pair.contact.gap = contact::gap_along(&p, &q, x, pair.contact.normal);
    }
    if !was_clear || pair.contact.gap < want {
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

/// Share of the summed movement that is done, by the number of contacts; one for each number up to [`MOST_CONTACTS`].
fn relaxations() -> Vec<f32> {
    (0..=MOST_CONTACTS).map(|contacts| libm::pow(contacts.max(1) as f64, -RELAXATION) as f32).collect()
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
    Vec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}
