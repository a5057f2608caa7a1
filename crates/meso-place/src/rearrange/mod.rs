//! Rearrangement: all grains at once, overlapping where they must, moved by small rigid steps until none overlap.
//!
//! Position-based dynamics on the energy E = sum over contacts of (wanted gap - gap)^2. Every contact asks its two
//! bodies for the least rigid movement that opens it; a body moves by the sum over its contacts, divided by a power
//! of their number (Jacobi, so that threads cannot change the result), plus heavy-ball momentum, which is dropped
//! whenever the energy rises. Walls are hard. The result is certified pair by pair ([`certify`]) before anyone sees
//! it.
//!
//! Every list is indexed by *body*: a moving grain's number along a space-filling curve. `Fixed::grain` is its number in the
//! request, the only other index.
//!
//! | owner | state | changed by |
//! |---|---|---|
//! | `Bodies` | pose, velocity, turned vertices, box, path length of every body | `advance` (a sweep), `settle` (a start) |
//! | `NeighbourList` | pairs that may touch, in blocks of 64 first bodies | `cover`, when bodies moved beyond their limits |
//! | `contact_cache::Block` | per pair: known gap, axis, the contact and its impulse while it lasts | `look`, each block by one thread |
//! | `CellList` | bodies by cell, in levels of size, at their positions when it was built | rebuilt when stale |
//! | `Walls` | the container, moved inwards by the gap | never |
//! | `Settings`, `Damping` | wanted gap, momentum, patience, cost of a jam | `narrow`, `hurry`, `next`, `fewer`, `relieve` |
//!
//! The phases of a run:
//!
//! 1. `initial_placement::fill`: a position for every grain. Nothing else draws random numbers.
//! 2. `Dynamics::descend`: sweeps (one update of all bodies) until *open*, *jammed* (the energy stops falling), *late* or
//!    *stopped*. A sweep reads the contacts of the last look and writes each body's own state only.
//! 3. `start_over_or_relieve`: after a jam, drops all grains anew with other damping, or fewer grains (`subsample`), or
//!    leaves out the worst wedged and goes on (*relief*).
//! 4. `certify::keep_apart`: the only phase whose answers are promises. It starts from poses, in double precision, and
//!    shares nothing with the dynamics.
//!
//! Sums over bodies and contacts run in index order, so that threads cannot change a bit.

mod bodies;
mod cell_list;
mod certify;
mod clearance_grid;
mod contact;
mod contact_cache;
mod damping;
mod dents;
mod fibres;
mod initial_placement;
mod neighbour_list;
mod obstacle;
mod subsample;
mod turn;
mod walls;

use super::task::Task;
use super::{Placed, Pose, StopReason};
use bodies::Bodies;
use contact::{V, add_scaled, length, scale};
use contact_cache::{Gaps, PairLook};
use damping::{Damping, FALL, HOPEFUL};
use dents::DentedShapes;
use meso_concrete::watch::Stage;
use neighbour_list::NeighbourList;
use walls::Walls;

use meso_concrete::aggregate::Grain;
use meso_concrete::aggregate::Kind;

/// Wanted gap beyond the least one (*slop*), as a share of the smallest grain's radius: it lets the last digits
/// settle.
const SLOP: f64 = 0.004;
/// The slop is halved, down to about this share, after this many sweeps in which bodies lack less than it on average.
const FINE_SWEEPS: u32 = 40;
const LEAST_SLOP: f64 = 0.0008;
/// Margin at the walls of containers that are no boxes, as a share of the slop: bodies see such walls in single
/// precision.
const ROUND_MARGIN: f64 = 0.1;
/// Share of the slop that must be open when it ends.
const ENOUGH: f64 = 0.2;
/// Movement is the sum over n contacts over n^0.4. With momentum such long steps are stable, and momentum can be less:
/// at 0.65, n^0.6 and 0.94 took 167 sweeps, n^0.4 and 0.91 120.
const RELAXATION: f64 = 0.4;
/// Beyond this many contacts the movement is damped no further.
const MOST_CONTACTS: usize = 256;
/// Momentum is dropped when the energy rises by this factor.
const RESTART: f64 = 1.1;
/// Where hulls of grains with dents would wedge, the surfaces are looked at once bodies lack less than this share of the
/// smallest radius, or after so many sweeps: until then a sweep takes a tenth of the time.
const ROUGH: f64 = 0.15;
const ROUGH_SWEEPS: u32 = 60;
/// No body moves farther in a sweep than this share of its radius, nor rotates by more radians.
const LONGEST_STEP: f32 = 0.25;
/// Every body may move at least this many slops before its pairs are searched again.
const LEAST_MARGIN: f64 = 10.0;
/// A body without contacts comes to rest when it is slower than this share of the slop a sweep.
const REST: f64 = 0.02;
/// After `LATE` of the time limit the run counts as jammed, and again after each `LATER`.
const LATE: f64 = 0.5;
const LATER: f64 = 1.0 / 16.0;
/// With a time limit, a jam restarts only if less than this share of it is spent: slower damping takes twice as long.
const EARLY: f64 = LATE / 3.0;
/// Beyond this share of the time limit, bodies that still lack much are damped quickly.
const HURRY: f64 = LATE / 2.0;

/// A run whose energy has not fallen for so many seconds is shown as jammed, whether or not it is over.
const SHOWN_S: f64 = 8.0;

/// Initial lack of the bodies, in radii of the smallest, and the share of the stage that finding positions takes.
const FIRST_LACK: f64 = 0.5;
const FILLING: f64 = 0.3;

/// Places all grains of `task`, or as many as fit, and says why.
pub(super) fn place(task: &Task) -> Placed {
    let mut outcome = Placed::empty(task, "rearrange", StopReason::Jammed);
    // After a stop during the take the caller places the grains that exist.
    if outcome.stop.is_some() || task.request.grains.is_empty() {
        return outcome;
    }
    let mut settings = Settings::new(task);
    let mut poses = match initial_placement::fill(task, |_| true) {
        Ok(poses) => poses,
        Err(reason) => {
            outcome.stop = Some(reason);
            return outcome;
        }
    };
    // Not needed before the end.
    outcome.poses = Vec::new();
    let (mut dents, hulls_crowd) = (None, dents::hulls_crowd(task));
    loop {
        // The lists of the dynamics are gone when the proof makes its own.
        let dynamics = Dynamics { hulls_crowd, ..Dynamics::new(task, poses, settings, &mut dents) };
        let (ended, reached) = dynamics.run(task, &mut outcome.work.sweeps);
        task.done(Stage::Prove, 0.1);
        let proved = certify::keep_apart(task, &reached, &mut outcome.work);
        task.done(Stage::Prove, 1.0);
        // Single precision, or points of surfaces with dents, took an overlapping pair for open: ask for a larger gap,
        // and continue.
        let widened = |dents: &mut DentedShapes| dents.widen(task.request.grains, &proved.unproved);
        if proved.left_out > 0
            && ended == SweepsEnd::Open
            && (dents.as_mut().is_some_and(widened) || settings.ask_for_more())
        {
            poses = reached;
            continue;
        }
        if let SweepsEnd::Stopped(reason) = ended {
            outcome.stop = Some(reason);
        }
        outcome.poses = proved.poses;
        return outcome;
    }
}

/// How a run of sweeps ended.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SweepsEnd {
    /// Every pair has its gap.
    Open,
    /// The overlaps do not shrink any more.
    Jammed,
    /// Opening them would take longer than the time limit allows.
    Late,
    /// A time limit or the user stopped the run.
    Stopped(StopReason),
}

/// How far apart the bodies are moved.
#[derive(Clone, Copy)]
struct Settings {
    /// mm.
    least_gap: f64,
    /// Wanted beyond `least_gap`, mm.
    slop: f64,
    /// Radius of the smallest grain's ball, mm.
    radius: f64,
    /// Part of the slop that must be open at the end, mm.
    enough: f64,
    damping: Damping,
}

impl Settings {
    fn new(task: &Task) -> Self {
        let radius = task.request.grains.iter().map(Grain::ball_radius).fold(f64::INFINITY, f64::min);
        let slop = SLOP * radius;
        Self {
            least_gap: task.request.placement.min_gap_mm,
            slop,
            radius,
            enough: ENOUGH * slop,
            damping: Damping::new(task, radius),
        }
    }

    fn ask_for_more(&mut self) -> bool {
        self.enough *= 2.0;
        self.enough < self.slop
    }

    /// Asks for smaller gaps where only the last digits are left: the slop that all bodies want could jam a packing
    /// that fits.
    fn narrow(&mut self) {
        if self.slop > LEAST_SLOP * self.radius {
            self.slop /= 2.0;
            self.enough /= 2.0;
        }
    }

    fn gaps(&self) -> Gaps {
        Gaps { want: (self.least_gap + self.slop) as f32, enough: (self.least_gap + self.enough) as f32 }
    }
}

struct Dynamics<'a> {
    bodies: Bodies<'a>,
    neighbours: NeighbourList,
    walls: Walls<'a>,
    settings: Settings,
    /// Absent until the hulls of grains with dents jam.
    dents: &'a mut Option<DentedShapes>,
    /// Hulls of grains with dents only open the largest overlaps.
    hulls_crowd: bool,
    /// Share of the summed movement that is done, by the number of contacts.
    relaxations: Vec<f32>,
    sweep: u32,
    /// Root mean square of the bodies' residual overlaps at the last look, over the radius of the smallest grain.
    lack: f64,
    /// Share of the time limit after which it is late.
    late: f64,
}

impl<'a> Dynamics<'a> {
    fn new(
        task: &'a Task<'a>,
        poses: Vec<(u32, Pose)>,
        settings: Settings,
        dents: &'a mut Option<DentedShapes>,
    ) -> Self {
        Self {
            bodies: Bodies::new(task, poses, dents.as_ref()),
            neighbours: NeighbourList::none(),
            walls: Walls::new(task, if task.container.is_box() { 0.01 } else { ROUND_MARGIN } * settings.slop),
            settings,
            dents,
            hulls_crowd: false,
            relaxations: relaxations(),
            sweep: 0,
            lack: f64::INFINITY,
            late: LATE,
        }
    }

    /// Moves the bodies until every pair is open or the run is stopped; leaves out the worst wedged where nothing
    /// else helps.
    fn run(mut self, task: &'a Task<'a>, sweeps: &mut u64) -> (SweepsEnd, Vec<(u32, Pose)>) {
        loop {
            let ended = self.descend(task);
            match ended {
                SweepsEnd::Jammed | SweepsEnd::Late if self.look_into_dents(task) => {}
                SweepsEnd::Jammed => {
                    task.done(Stage::Jam, 0.0);
                    self.start_over_or_relieve(task);
                }
                SweepsEnd::Late => {
                    self.relieve(task);
                    self.late += LATER;
                }
                SweepsEnd::Open | SweepsEnd::Stopped(_) => {
                    *sweeps += u64::from(self.sweep);
                    let in_time = ended != SweepsEnd::Open || self.late == LATE;
                    return (
                        if in_time { ended } else { SweepsEnd::Stopped(StopReason::TimeLimit) },
                        self.bodies.poses(),
                    );
                }
            }
        }
    }

    /// Sweeps until every pair is open, nothing helps any more, or the run is stopped.
    fn descend(&mut self, task: &Task) -> SweepsEnd {
        self.bodies.settle(&self.walls);
        let (mut best, mut best_sweep, mut last) = (f64::INFINITY, self.sweep, f64::INFINITY);
        let (mut fine_since, mut fell_s) = (None, task.seconds());
        loop {
            self.renew_neighbours();
            let look = self.look();
            if look.open_below == 0 {
                return SweepsEnd::Open;
            }
            if look.energy < FALL * best {
                (best, best_sweep, fell_s) = (look.energy, self.sweep, task.seconds());
            }
            if task.seconds() - fell_s > SHOWN_S {
                task.done(Stage::Jam, 0.0);
            }
            let is_rough = self.lack > ROUGH && self.sweep < ROUGH_SWEEPS;
            let sees_dents = self.hulls_crowd && self.dents.is_none() && !is_rough;
            if sees_dents || self.sweep - best_sweep > self.settings.damping.patience() {
                return SweepsEnd::Jammed;
            }
            task.done(Stage::Place, self.share());
            if let Some(reason) = task.stopped(0.0) {
                return SweepsEnd::Stopped(reason);
            }
            let spent = task.spent();
            if spent > self.late {
                return SweepsEnd::Late;
            }
            if spent > HURRY && self.lack > HOPEFUL {
                self.settings.damping.hurry();
            }
            let is_fine = self.lack * self.settings.radius < self.settings.slop;
            if is_fine && self.sweep - *fine_since.get_or_insert(self.sweep) > FINE_SWEEPS {
                self.settings.narrow();
                fine_since = None;
            }
            let momentum = if look.energy > RESTART * last { 0.0 } else { self.settings.damping.momentum() };
            last = look.energy;
            self.step(momentum);
            self.sweep += 1;
        }
    }

    /// Continues with the surfaces of grains with dents after their hulls have jammed; false where that is done.
    fn look_into_dents(&mut self, task: &'a Task<'a>) -> bool {
        if self.dents.is_some() {
            return false;
        }
        *self.dents = DentedShapes::of(task.request.grains);
        if self.dents.is_none() {
            return false;
        }
        self.settings = Settings::new(task);
        let poses = self.bodies.poses();
        self.begin(task, poses);
        true
    }

    /// Restarts, slower or with fewer grains, where that may help and time allows.
    fn start_over_or_relieve(&mut self, task: &'a Task<'a>) {
        if task.spent() >= EARLY {
            return self.relieve(task);
        }
        let moving = self.grains();
        if let Some(slower) = self.settings.damping.next(self.lack) {
            return self.start_over(task, slower, &moving);
        }
        let fewer = self.settings.damping.fewer(self.lack);
        let fewer = fewer.map(|(excess, damping)| (subsample::thinned(task.request.grains, &moving, excess), damping));
        match fewer {
            Some((kept, damping)) if kept.len() < moving.len() => self.start_over(task, damping, &kept),
            _ => self.relieve(task),
        }
    }

    /// Restarts with these grains.
    fn start_over(&mut self, task: &'a Task<'a>, damping: Damping, grains: &[u32]) {
        // A stop in the meantime is noticed by the next look.
        if let Ok(poses) = initial_placement::fill(task, |number| grains.binary_search(&(number as u32)).is_ok()) {
            self.settings = Settings { damping, ..Settings::new(task) };
            self.begin(task, poses);
        }
    }

    /// The numbers of the moving grains, ascending.
    fn grains(&self) -> Vec<u32> {
        let mut grains: Vec<u32> = self.bodies.fixed.iter().map(|body| body.grain).collect();
        grains.sort_unstable();
        grains
    }

    /// Continues with these bodies, at rest.
    fn begin(&mut self, task: &'a Task<'a>, poses: Vec<(u32, Pose)>) {
        self.neighbours = NeighbourList::none();
        self.bodies = Bodies::new(task, poses, self.dents.as_ref());
    }

    /// Leaves out the grains with the most overlap for their volume.
    fn relieve(&mut self, task: &'a Task<'a>) {
        let grains = task.request.grains;
        let want = self.settings.gaps().want;
        let mut worst: Vec<(f64, u32)> = (0..self.bodies.len() as u32)
            .map(|body| {
                let contacts = self.neighbours.contacts(body);
                let energy: f64 = contacts.map(|(touch, _)| f64::from(want - touch.contact.gap).powi(2)).sum();
                let grain = self.bodies.fixed[body as usize].grain;
                let inside = self.bodies.state[body as usize].inside;
                (if inside { energy / grains[grain as usize].volume() } else { f64::INFINITY }, grain)
            })
            .collect();
        worst.sort_unstable_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
        let mut poses = self.bodies.poses();
        let share = self.settings.damping.relieve(self.lack);
        // Every kind gives up the same share: fibres are so thin that otherwise all of them would go first.
        let volume = |grain: u32| grains[grain as usize].volume();
        let kind = |grain: u32| grains[grain as usize].kind as usize;
        let mut budgets = [0.0; 1 + Kind::FURTHER.len()];
        poses.iter().for_each(|&(grain, _)| budgets[kind(grain)] += volume(grain));
        budgets.iter_mut().for_each(|budget| *budget *= share);
        let mut left_out = vec![false; grains.len()];
        for (_, grain) in worst {
            if budgets[kind(grain)] > 0.0 {
                left_out[grain as usize] = true;
                budgets[kind(grain)] -= volume(grain);
            }
        }
        poses.retain(|&(grain, _)| !left_out[grain as usize]);
        self.begin(task, poses);
    }

    fn renew_neighbours(&mut self) {
        let least = LEAST_MARGIN * self.settings.slop;
        self.neighbours.cover(&mut self.bodies, self.settings.gaps().want, least as f32);
    }

    /// Brings every pair's contact up to date.
    fn look(&mut self) -> PairLook {
        let look = self.neighbours.look(&self.bodies, self.settings.gaps());
        self.lack = libm::sqrt(look.energy / self.bodies.len() as f64) / self.settings.radius;
        let outside = self.bodies.state.iter().filter(|state| !state.inside).count() as u32;
        PairLook { open_below: look.open_below + outside, ..look }
    }

    /// How far the overlaps have fallen, on a logarithmic scale: the residual overlap begins near a tenth of a radius
    /// and ends near the slop. The start has taken [`FILLING`] of the stage.
    fn share(&self) -> f64 {
        let end = SLOP / 8.0;
        let fallen = libm::log(FIRST_LACK / self.lack.clamp(end, FIRST_LACK)) / libm::log(FIRST_LACK / end);
        FILLING + (1.0 - FILLING) * fallen
    }

    fn step(&mut self, momentum: f64) {
        let Self { bodies, neighbours, walls, settings, relaxations, .. } = self;
        let (momentum, rest) = (momentum as f32, (REST * settings.slop) as f32);
        bodies.advance(self.sweep, walls, |body, fixed, state| {
            let push = neighbours.push(fixed, body);
            let share = relaxations[push.contacts.min(MOST_CONTACTS)];
            let far = LONGEST_STEP * fixed.ball_radius;
            state.velocity = clip(add_scaled(scale(state.velocity, momentum), push.shift, share), far);
            state.spin = clip(add_scaled(scale(state.spin, momentum), push.twist, share), LONGEST_STEP);
            if push.contacts == 0 && state.speed(fixed) < rest {
                (state.velocity, state.spin) = ([0.0; 3], [0.0; 3]);
            }
        });
    }
}

/// Share of the summed movement that is done, by the number of contacts; one for each number up to [`MOST_CONTACTS`].
fn relaxations() -> Vec<f32> {
    (0..=MOST_CONTACTS).map(|contacts| libm::pow(contacts.max(1) as f64, -RELAXATION) as f32).collect()
}

fn clip(v: V, longest: f32) -> V {
    let length = length(v);
    if length > longest { scale(v, longest / length) } else { v }
}
