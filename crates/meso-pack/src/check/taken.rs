//! Agreement of the grains with the spec and the seed: the take is repeated and every body looked up in it: by its class,
//! by its ITZ to the last bit, and by its volume.

use super::Finding;
use crate::model::{self, Model};
use meso_concrete::aggregate::{Aggregate, Grain, Kind, Shell};
use meso_place::{GrainTally, Placed, StopReason, Strategy, Work};
use std::cmp::Ordering;

/// Where the spec makes more grains than this many times those that the report accounts for, they are not made: estimates are
/// five times too high at worst.
const MOST_MADE: f64 = 20.0;
/// And so many more, which take seconds.
const FEW: f64 = 100_000.0;

/// Grains that the take of the model's spec gives, and the end of the run according to the report.
pub(super) struct Taken {
    pub(super) tally: GrainTally,
    pub(super) outcome: Placed,
}

/// Grains that the spec gives, and those found among the bodies.
///
/// Nothing taken where the grains are a label volume's, or making them would take far longer than the file is long.
pub(super) fn check(model: &Model, bodies: &[Aggregate]) -> (Option<Taken>, Vec<Finding>) {
    if model.report.labels.is_some() {
        return (None, Vec::new());
    }
    let accounted = model.aggregates.len().saturating_add(model.report.discarded);
    let made = model.spec.estimated_aggregates();
    if made > MOST_MADE * accounted as f64 + FEW {
        let reason = format!("the spec makes about {made:.0} aggregates, the report accounts for {accounted}");
        let finding = (!was_stopped(model)).then_some(Finding::Report { reason });
        return (None, finding.into_iter().collect());
    }
    let grains = match model::taken(&model.spec) {
        Ok(grains) => grains,
        Err(error) => return (None, vec![Finding::Report { reason: error.to_string() }]),
    };
    let Taken { mut tally, outcome } = as_reported(model, &grains);
    let mut drafts = Drafts::new(&grains);
    let mut findings = Vec::new();
    // The smallest first, each with the smallest grain that it may be: so no other is left without one.
    let mut order: Vec<&Aggregate> = bodies.iter().collect();
    order.sort_by(|a, b| a.body.volume().total_cmp(&b.body.volume()).then(a.id.cmp(&b.id)));
    for body in order {
        match drafts.claim(body) {
            Some([limited, thin]) => {
                tally.itz_limited.extend(limited.then_some(body.id));
                tally.itz_thin.extend(thin.then_some(body.id));
            }
            None => findings.push(Finding::NotTaken { body: body.id }),
        }
    }
    tally.itz_limited.sort_unstable();
    tally.itz_thin.sort_unstable();
    findings.sort_by_key(Finding::body);
    (Some(Taken { tally, outcome }), findings)
}

/// Whether a time limit or the user ended the run, so that its grains and attempts depend on the clock.
pub(super) fn was_stopped(model: &Model) -> bool {
    matches!(model.report.stop_reason, StopReason::TimeLimit | StopReason::Interrupted)
}

fn as_reported(model: &Model, grains: &[Grain]) -> Taken {
    let (strategy, dead_end) = match model.spec.placement.chosen() {
        Strategy::TakeAndPlace => ("take-and-place", StopReason::AttemptsExhausted),
        _ => ("rearrange", StopReason::Jammed),
    };
    let largest = model::largest(&model.spec);
    let outcome = Placed {
        poses: vec![None; grains.len()],
        work: Work::default(),
        stop: was_stopped(model).then_some(model.report.stop_reason),
        dead_end,
        strategy,
        too_large: grains.iter().filter(|grain| !largest.admits(grain)).count(),
    };
    let mut tally = GrainTally::of(grains, &outcome.poses, model.spec.grading.classes().len(), true);
    // A file with more bodies than were taken has a finding for each of them.
    tally.aggregates = tally.aggregates.max(model.aggregates.len());
    Taken { tally, outcome }
}

/// Properties of a grain that do not depend on its pose.
struct Draft {
    /// Its size class, and its phase among the specimen's own.
    class: (u16, Option<u8>),
    itz_bits: u64,
    volume: f64,
    shells: Vec<Shell>,
    /// Whether its ITZ was limited, and whether it has parts that are too thin for it.
    itz: [bool; 2],
}

/// The grains in order, each to be claimed once.
struct Drafts {
    sorted: Vec<Draft>,
    /// The next grain from here on that may be free; one past the last where there is none.
    free: Vec<usize>,
}

impl Drafts {
    fn new(grains: &[Grain]) -> Self {
        let draft = |grain: &Grain| Draft {
            class: (grain.class, grain.own),
            itz_bits: grain.itz_thickness_mm.to_bits(),
            volume: grain.volume(),
            shells: grain.shells.clone(),
            itz: [grain.itz_limited, grain.itz_thin],
        };
        let mut sorted: Vec<Draft> = grains.iter().map(draft).collect();
        sorted.sort_unstable_by(|a, b| a.cmp(b.class, b.itz_bits, b.volume));
        Self { free: (0..=sorted.len()).collect(), sorted }
    }

    /// What the report says of the ITZ of the grain that this body is; `None` where it is none that is left.
    fn claim(&mut self, body: &Aggregate) -> Option<[bool; 2]> {
        let itz_bits = if body.kind == Kind::Aggregate { body.itz_thickness_mm.to_bits() } else { 0 };
        let (class, volume) = ((body.class, body.own), body.body.volume());
        let rounding = rounding(volume);
        let first = self.sorted.partition_point(|d| d.cmp(class, itz_bits, volume - rounding).is_lt());
        let found = self.next_free(first);
        let draft = self.sorted.get(found)?;
        if draft.cmp(class, itz_bits, volume + rounding).is_gt() || draft.shells != body.shells {
            return None;
        }
        self.free[found] = found + 1;
        Some(draft.itz)
    }

    fn next_free(&mut self, mut at: usize) -> usize {
        while self.free[at] != at {
            self.free[at] = self.free[self.free[at]];
            at = self.free[at];
        }
        at
    }
}

impl Draft {
    fn cmp(&self, class: (u16, Option<u8>), itz_bits: u64, volume: f64) -> Ordering {
        (self.class, self.itz_bits).cmp(&(class, itz_bits)).then(self.volume.total_cmp(&volume))
    }
}

/// A body that was turned has its corners on a lattice of 2^-30 mm: its volume, mm3, errs by half a step on every face.
fn rounding(volume: f64) -> f64 {
    1e-12 * volume + 4e-8 * libm::cbrt(volume * volume)
}
