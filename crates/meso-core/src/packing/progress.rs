//! How far long work is: named stages, and one measure of them all that never falls.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// A part of long work, by the name that users see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Generating the grains.
    Take,
    /// Placing them.
    Place,
    /// Proving them apart.
    Prove,
    /// Meshing, or measuring a mesh.
    Mesh,
    /// Measuring a packing.
    Measure,
    /// Making images.
    Image,
    /// Writing files.
    Write,
}

impl Stage {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Take => "take",
            Self::Place => "place",
            Self::Prove => "prove",
            Self::Mesh => "mesh",
            Self::Measure => "measure",
            Self::Image => "image",
            Self::Write => "write",
        }
    }
}

/// A long run reports its progress here, and asks whether to go on.
pub trait Progress: Sync {
    /// The fraction reached so far, of the target. Return `false` to stop with the best packing found.
    fn update(&self, fraction: f64, target: f64) -> bool;
    /// This share of a stage is done, 0 to 1. A stage may begin again, after a jam; whoever shows it keeps the most.
    fn stage(&self, stage: Stage, share: f64) {
        let _ = (stage, share);
    }
    /// Seconds since some fixed moment: the core itself reads no clock.
    fn seconds(&self) -> f64;
    /// Seconds of the time limit that were spent before packing began, as on reading a large surface.
    fn spent(&self) -> f64 {
        0.0
    }
}

/// No progress, no clock, never stops.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn update(&self, _: f64, _: f64) -> bool {
        true
    }
    fn seconds(&self) -> f64 {
        0.0
    }
}

/// One measure of several stages, 0 to 1: it never falls, whatever order and threads the shares come in.
#[derive(Debug)]
pub struct Measure {
    /// The stages in their order, with the share of the time that each takes, roughly.
    plan: Vec<(Stage, f64)>,
    /// Bits of the largest measure: those of positive numbers are in the numbers' order.
    most: AtomicU64,
    /// Place in the plan of the latest stage.
    latest: AtomicUsize,
}

impl Measure {
    /// Of stages in their order, with weights.
    pub fn new(plan: &[(Stage, f64)]) -> Self {
        Self { plan: plan.to_vec(), most: AtomicU64::new(0), latest: AtomicUsize::new(0) }
    }

    /// Takes in the share of a stage; a stage that is not in the plan and a share that is no number count for nothing.
    pub fn tell(&self, stage: Stage, share: f64) {
        let Some(place) = self.plan.iter().position(|planned| planned.0 == stage) else { return };
        let weight = |stages: &[(Stage, f64)]| stages.iter().map(|planned| planned.1).sum::<f64>();
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        let done = weight(&self.plan[..place]) + self.plan[place].1 * share;
        self.most.fetch_max((done / weight(&self.plan)).to_bits(), Ordering::Relaxed);
        self.latest.fetch_max(place, Ordering::Relaxed);
    }

    /// Share of all stages that is done.
    pub fn share(&self) -> f64 {
        f64::from_bits(self.most.load(Ordering::Relaxed))
    }

    /// The name of the latest stage.
    pub fn stage(&self) -> &'static str {
        self.plan.get(self.latest.load(Ordering::Relaxed)).map_or("", |planned| planned.0.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_measure_never_falls_and_counts_stages_by_their_weights() {
        let measure = Measure::new(&[(Stage::Take, 1.0), (Stage::Place, 3.0)]);
        let mut last = 0.0;
        for (stage, share, expected) in [
            (Stage::Take, 0.5, 0.125),
            (Stage::Place, 0.2, 0.4),
            (Stage::Take, 1.0, 0.4),
            (Stage::Mesh, 1.0, 0.4),
            (Stage::Place, f64::NAN, 0.4),
            (Stage::Place, 2.0, 1.0),
        ] {
            measure.tell(stage, share);
            assert!((measure.share() - expected).abs() < 1e-12 && measure.share() >= last, "{stage:?}");
            last = measure.share();
        }
        assert_eq!(measure.stage(), "place");
    }
}
