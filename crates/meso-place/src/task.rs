//! The task of a strategy: the request, and the quantities derived from it.

use super::{Request, StopReason, Strategy};
use meso_collision::geometry::BodyForm;
use meso_collision::math::Aabb;
use meso_concrete::aggregate::Grain;
use meso_concrete::specimen::{Container, Period};
use meso_concrete::watch::Stage;
use std::sync::{Arc, OnceLock};

/// A request, and the quantities that every strategy derives from it.
pub(super) struct Task<'a> {
    pub(super) request: Request<'a>,
    /// The specimen's container, its volume in mm3, and its periods.
    pub(super) container: Arc<dyn Container>,
    pub(super) volume: f64,
    pub(super) period: Period,
    /// Volume each class may take, mm3. A grain that would exceed it by more than half of itself is left out.
    /// Infinite where no surplus was taken.
    pub(super) class_targets: Vec<f64>,
    /// `watch.seconds()` when it began, and at which to stop.
    started: f64,
    pub(super) deadline: f64,
    /// True where all grains are convex polyhedra, so that their vertices decide.
    pub(super) only_hulls: bool,
    /// Why the run stops; set once by the first thread that finds a reason.
    stop: OnceLock<StopReason>,
}

impl<'a> Task<'a> {
    pub(super) fn new(request: &Request<'a>) -> Self {
        let target = &request.target;
        let container = target.specimen.container();
        let (volume, period) = (container.volume(), target.specimen.period());
        let (wanted, started) = (target.fraction * volume, request.started);
        let bound = if request.placement.chosen() == Strategy::TakeAndPlace { 1.0 } else { f64::INFINITY };
        let classes = target.grading.classes();
        let aggregates = classes.iter().map(|class| class.share * wanted * bound);
        // Phases that were not asked for have no grains, whatever their target.
        let inclusions = target.inclusions.fractions().map(|fraction| fraction * volume * bound);
        Self {
            request: *request,
            container,
            volume,
            period,
            class_targets: aggregates.chain(inclusions).collect(),
            started,
            deadline: request.placement.deadline(started),
            only_hulls: request.grains.iter().all(|grain| grain.body.form() == BodyForm::Hull),
            stop: OnceLock::new(),
        }
    }

    /// False for a grain that fits nowhere in the specimen.
    pub(super) fn admits(&self, grain: &Grain) -> bool {
        self.request.largest.admits(grain)
    }

    /// Admissible centres of a grain whose box about its centre is `local`: that box keeps its distance to the walls
    /// of the specimen's bounding box.
    pub(super) fn reach(&self, local: &Aabb) -> Aabb {
        let aabb = self.container.aabb();
        let inside = Aabb { min: aabb.min - local.min, max: aabb.max - local.max };
        self.period.mixed(&aabb, &inside.grown(-self.request.placement.wall_gap_mm))
    }

    /// The space that a grain with its centre in the specimen's box may reach, with its gap: the box itself at walls,
    /// more at periodic faces.
    pub(super) fn domain(&self) -> Aabb {
        let aabb = self.container.aabb();
        let largest = self.request.grains.iter().map(|grain| f64::from(grain.outer_radius)).fold(0.0, f64::max);
        let margin = (largest + self.request.placement.min_gap_mm) * (1.0 + 1e-9);
        self.period.mixed(&aabb.grown(margin), &aabb)
    }

    /// Share of the time limit that has gone by; 0 where there is none.
    pub(super) fn spent(&self) -> f64 {
        (self.request.watch.seconds() - self.started) / (self.deadline - self.started)
    }

    /// Seconds of the watch.
    pub(super) fn seconds(&self) -> f64 {
        self.request.watch.seconds()
    }

    /// This share of the placing is done, or of the proof after it.
    pub(super) fn done(&self, stage: Stage, share: f64) {
        self.request.watch.stage(stage, share);
    }

    /// Reports `volume` mm3 placed; the reason to stop now, if there is one.
    pub(super) fn stopped(&self, volume: f64) -> Option<StopReason> {
        if volume > 0.0 {
            self.done(Stage::Place, volume / (self.volume * self.request.target.fraction));
        }
        self.over()
    }

    /// The reason to stop, if there is one. Any thread may ask; a reason once found stays.
    pub(super) fn over(&self) -> Option<StopReason> {
        let watch = self.request.watch;
        let reason = || {
            let is_late = || (watch.seconds() >= self.deadline).then_some(StopReason::TimeLimit);
            if watch.stops() { Some(StopReason::Interrupted) } else { is_late() }
        };
        self.stop.get().copied().or_else(|| reason().map(|reason| *self.stop.get_or_init(|| reason)))
    }
}
