//! Chooses the strategy and runs it: grains in, poses out.

use super::{DEFAULT_ATTEMPTS, Outcome, Placement, Request, StopReason, Strategy, rearrange, take_and_place};
use crate::aggregate::take::Grain;
use crate::gjk;
use rayon::prelude::*;

/// A request, and what every strategy derives from it.
pub(super) struct Task<'a> {
    pub(super) request: Request<'a>,
    /// Volume each class may take, mm3; a grain that would pass it by more than half of itself is left out. Without
    /// bound where no surplus was taken.
    pub(super) class_targets: Vec<f64>,
    /// `progress.seconds()` at which to stop.
    deadline: f64,
    /// The grains in the form collision works on.
    pub(super) bodies: Vec<gjk::Body>,
}

impl Placement {
    /// The strategy that `Auto` stands for: take-and-place where a number of attempts is given, since only it has one;
    /// else rearrangement, which begins with take-and-place and is done when that leaves nothing over.
    pub fn chosen(&self) -> Strategy {
        match self.strategy {
            Strategy::Auto if self.attempts.is_some() => Strategy::TakeAndPlace,
            Strategy::Auto => Strategy::Rearrange,
            strategy => strategy,
        }
    }
}

/// Places the grains of `request`.
pub fn place(request: &Request) -> Outcome {
    let task = Task::new(request);
    match request.placement.chosen() {
        Strategy::TakeAndPlace => take_and_place::place(&task, request.placement.attempts.unwrap_or(DEFAULT_ATTEMPTS)),
        _ => rearrange::place(&task),
    }
}

impl<'a> Task<'a> {
    fn new(request: &Request<'a>) -> Self {
        let volume = request.fraction * request.specimen.volume();
        let limit = request.placement.time_limit_s;
        let bound = if request.placement.chosen() == Strategy::TakeAndPlace { 1.0 } else { f64::INFINITY };
        Self {
            request: *request,
            class_targets: request.grading.classes().iter().map(|class| class.share * volume * bound).collect(),
            deadline: limit.map_or(f64::INFINITY, |limit| request.progress.seconds() + limit),
            bodies: request.grains.par_iter().map(collider).collect(),
        }
    }

    /// Reports `volume` mm3 placed; the reason to stop now, if there is one.
    pub(super) fn stopped(&self, volume: f64) -> Option<StopReason> {
        let total = self.request.specimen.volume();
        if !self.request.progress.update(volume / total, self.request.fraction) {
            return Some(StopReason::Interrupted);
        }
        (self.request.progress.seconds() >= self.deadline).then_some(StopReason::TimeLimit)
    }
}

/// The grain in the form collision works on, with all that lets pairs be told apart early.
fn collider(grain: &Grain) -> gjk::Body {
    gjk::Body::on_ellipsoid(grain.body.vertices(), &grain.semi_axes, &grain.rotation).with_inside_of(&grain.body)
}
