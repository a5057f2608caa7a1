//! The *place*: puts aggregates into a specimen without overlap, and reports the fraction reached.
//!
//! [`place()`] takes a [`Request`]: grains and a [`Placement`]. It returns their poses; [`report()`] compares the packing
//! with its [`PackingTarget`].

// No environment, clock, file, print or mathematics of the platform: the list is in `crates/clippy.toml`.
#![cfg_attr(not(test), deny(clippy::disallowed_methods, clippy::disallowed_types, clippy::disallowed_macros))]

mod cell_grid;
mod face_shift;
mod place;
mod reachable;
mod rearrange;
mod report;
mod take_and_place;
mod task;

pub use face_shift::keep_off_faces;
use meso_collision::geometry::{BodyForm, CompactPolyhedron, HullBuilder, HullError, Polyhedron, Round, Triangles};
use meso_collision::math::{Rotation, Vec3};
use meso_collision::posed::Posed;
use meso_concrete::aggregate::grain::{self, Grain};
use meso_concrete::aggregate::{Grading, Inclusions, Kind, OwnPhase, Shape};
use meso_concrete::specimen::{Largest, Specimen};
use meso_concrete::watch::Watch;
use nalgebra::UnitQuaternion;
pub use place::place;
pub use report::report;
pub use report::{
    ClassReport, CoreReport, LabelReport, OwnPhaseReport, PhaseReport, ReducedGrain, Report, Seconds, ShellReport,
    SpecimenReport, StopReason, Work,
};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// How aggregates are placed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Placement {
    /// Which strategy places.
    pub strategy: Strategy,
    /// Random positions tried per aggregate; absent: up to 50,000.
    pub attempts: Option<u32>,
    /// Volume generated beyond the target, as a share of it (the paper's 2 to 3 %).
    pub surplus: f64,
    /// Smallest distance between two aggregates, mm; 0 means: proved apart.
    pub min_gap_mm: f64,
    /// Smallest distance between an aggregate and the specimen's surface, mm. At periodic faces it is the distance of
    /// the aggregates' outermost points, as far as a translation of the whole packing can give it.
    pub wall_gap_mm: f64,
    /// Stop after this many seconds with the best packing found.
    pub time_limit_s: Option<f64>,
}

/// Attempts per aggregate where the spec gives none; after these the aggregate is left out.
pub(crate) const DEFAULT_ATTEMPTS: u32 = 50_000;

/// The placement strategies, siblings behind one interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Strategy {
    /// The one that reaches the target.
    Auto,
    /// The paper's: random positions, largest first (Sec. 2.2).
    TakeAndPlace,
    /// All aggregates at once, moved until none overlap.
    Rearrange,
}

impl Default for Placement {
    fn default() -> Self {
        Self {
            strategy: Strategy::Auto,
            attempts: None,
            surplus: 0.025,
            min_gap_mm: 0.0,
            wall_gap_mm: 0.0,
            time_limit_s: None,
        }
    }
}

/// Target of a packing; the report compares the result with it.
#[derive(Clone, Copy)]
pub struct PackingTarget<'a> {
    /// The specimen to fill.
    pub specimen: &'a Specimen,
    /// Volume of the aggregates over the specimen's, 0 to 1.
    pub fraction: f64,
    /// Shares of the size classes.
    pub grading: &'a Grading,
    /// The shapes of the aggregates.
    pub shape: &'a Shape,
    /// Voids and fibres asked for.
    pub inclusions: Inclusions<'a>,
    /// Phases of the aggregates' own.
    pub phases: &'a [OwnPhase],
    /// Seed of the positions.
    pub seed: u64,
}

/// The grains to place, and how.
#[derive(Clone, Copy)]
pub struct Request<'a> {
    /// Target of the placement.
    pub target: PackingTarget<'a>,
    /// Upper bounds on a body in the specimen, its distance to the walls kept.
    pub largest: Largest,
    /// The grains in the order they are placed.
    pub grains: &'a [Grain],
    /// Options of the placement.
    pub placement: &'a Placement,
    /// Where to report, and whom to ask.
    pub watch: &'a dyn Watch,
    /// `watch.seconds()` at which the run began: the time limit counts from there.
    pub started: f64,
}

/// A rotation. Single precision suffices, because the proof uses the body turned by this very rotation.
type Turn = UnitQuaternion<f32>;

/// Where a grain ended: turned about its own origin, then moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// `None` where the grain kept the orientation it was taken with.
    turn: Option<Turn>,
    /// In the specimen, mm.
    pub centre: Vec3,
}

impl Pose {
    fn at(centre: Vec3) -> Self {
        Self { turn: None, centre }
    }

    /// How the grain is turned; `None` where it kept the orientation it was taken with.
    pub fn rotation(&self) -> Option<Rotation> {
        self.turn.map(|turn| Rotation::new_normalize(turn.cast().into_inner()))
    }

    /// Vertices about the centre: turned and rounded to the lattice, or as they are. A ball is never turned.
    pub fn turned(&self, body: &CompactPolyhedron) -> Vec<Vec3> {
        let is_ball = || matches!(body.form(), BodyForm::Round(round) if round.radius().is_some());
        match self.rotation() {
            Some(rotation) if !is_ball() => grain::turned(body.vertices(), &rotation.to_rotation_matrix().into_inner()),
            _ => body.vertices().collect(),
        }
    }

    /// The grain's surface in the specimen: see [`HullBuilder::moved`].
    ///
    /// # Errors
    /// Where the turned vertices span no volume.
    pub fn apply(&self, body: &CompactPolyhedron) -> Result<Polyhedron, HullError> {
        let mut vertices = self.turned(body);
        vertices.iter_mut().for_each(|vertex| *vertex += self.centre);
        if self.turn.is_none() { Ok(body.with_vertices(vertices)) } else { HullBuilder::moved(body, &vertices) }
    }
}

/// A grain's body, turned about its centre and moved by `offset`; on the lattice that is exact.
struct Moved<'a> {
    body: &'a CompactPolyhedron,
    pose: &'a Pose,
    offset: &'a Vec3,
}

impl Posed for Moved<'_> {
    fn form(&self) -> BodyForm {
        match self.body.form() {
            BodyForm::Round(_) => BodyForm::Round(Round::of_ends(&self.pose.turned(self.body)).moved(self.offset)),
            form @ (BodyForm::Hull | BodyForm::Surface) => form,
        }
    }

    fn vertices(&self) -> Cow<'_, [Vec3]> {
        Cow::Owned(self.pose.turned(self.body).iter().map(|vertex| vertex + self.offset).collect())
    }

    fn surface(&self) -> Cow<'_, Triangles> {
        Cow::Owned(self.body.with_vertices(self.vertices().into_owned()).surface())
    }
}

/// The result of a strategy.
pub struct Placed {
    /// The pose of every grain; `None` where it found none.
    pub poses: Vec<Option<Pose>>,
    /// Counters of the work done.
    pub work: Work,
    /// Why it ended early, if it did.
    pub stop: Option<StopReason>,
    /// Why grains are missing, if it did not end early.
    pub dead_end: StopReason,
    /// The strategy's name.
    pub strategy: &'static str,
    /// Grains that fit nowhere in the specimen.
    pub too_large: usize,
}

impl Placed {
    /// Nothing placed so far; `stop` where `task` is not to begin at all.
    fn empty(task: &task::Task, strategy: &'static str, dead_end: StopReason) -> Self {
        Self {
            poses: vec![None; task.request.grains.len()],
            work: Work::default(),
            stop: task.stopped(0.0),
            dead_end,
            strategy,
            too_large: task.request.grains.iter().filter(|grain| !task.admits(grain)).count(),
        }
    }
}

/// Figures of the grains that the report needs when they are freed.
pub struct GrainTally {
    /// False where a stop came before all grains were generated.
    pub complete: bool,
    /// Aggregates among the grains.
    pub aggregates: usize,
    /// Placed aggregates whose drawn ITZ was thinner than asked, by their number among the placed ones.
    pub itz_limited: Vec<u32>,
    /// Placed aggregates with parts thinner than two of their ITZ, likewise.
    pub itz_thin: Vec<u32>,
    /// Volume of the largest grain taken of each class, mm3; the entries of voids and fibres follow the grading's.
    pub largest_mm3: Vec<f64>,
}

impl GrainTally {
    /// Counts the `grains` by their poses, in `classes` size classes of aggregates.
    pub fn of(grains: &[Grain], poses: &[Option<Pose>], classes: usize, complete: bool) -> Self {
        let mut largest_mm3 = vec![0.0; classes + Kind::FURTHER.len()];
        for grain in grains {
            let largest = &mut largest_mm3[usize::from(grain.class)];
            *largest = grain.graded_volume().max(*largest);
        }
        let aggregates = || grains.iter().zip(poses).filter(|(grain, _)| grain.kind == Kind::Aggregate);
        let placed = aggregates().filter(|(_, pose)| pose.is_some());
        let (mut itz_limited, mut itz_thin) = (Vec::new(), Vec::new());
        for (id, (grain, _)) in (0..).zip(placed) {
            itz_limited.extend(grain.itz_limited.then_some(id));
            itz_thin.extend(grain.itz_thin.then_some(id));
        }
        Self { complete, aggregates: aggregates().count(), itz_limited, itz_thin, largest_mm3 }
    }
}
