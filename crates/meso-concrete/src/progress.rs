//! How far long work is: named stages, and one measure of them all that never falls.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

/// A part of long work, by the name that users see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading a specimen's surface and proving that it encloses a volume.
    Read,
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
            Self::Read => "read",
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
    /// When the time limit began to count, in [`seconds`](Progress::seconds): now, unless somebody waits since an earlier
    /// moment, as when a large surface was read first.
    fn began(&self) -> f64 {
        self.seconds()
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

/// Whoever waits for a proof, and when he gives it up.
#[derive(Clone, Copy)]
pub struct Waiting<'a> {
    /// Told how far the stage [`Stage::Read`] is.
    pub progress: &'a dyn Progress,
    /// In `progress.seconds()`.
    pub deadline: f64,
}

impl Waiting<'_> {
    /// This share of reading is done; true once the time is over.
    pub(crate) fn is_over_at(&self, share: f64) -> bool {
        self.progress.stage(Stage::Read, share);
        self.progress.seconds() >= self.deadline
    }
}

/// One measure of several stages, 0 to 1: it never falls, whatever order and threads the shares come in. Stages before the
/// first one that is told of are left out: few specimens have a surface to read.
#[derive(Debug)]
pub struct Measure {
    /// The stages in their order, with the share of the time that each takes, roughly.
    plan: Vec<(Stage, f64)>,
    /// Bits of the largest measure: those of positive numbers are in the numbers' order.
    most: AtomicU64,
    /// Place in the plan of the stage that was told of first; of none, [`usize::MAX`].
    first: AtomicUsize,
    /// Place in the plan of the latest stage.
    latest: AtomicUsize,
}

impl Measure {
    /// Of stages in their order, with weights.
    pub fn new(plan: &[(Stage, f64)]) -> Self {
        let [first, latest] = [usize::MAX, 0].map(AtomicUsize::new);
        Self { plan: plan.to_vec(), most: AtomicU64::new(0), first, latest }
    }

    /// Takes in the share of a stage; a stage that is not in the plan and a share that is no number count for nothing.
    pub fn tell(&self, stage: Stage, share: f64) {
        let Some(place) = self.plan.iter().position(|planned| planned.0 == stage) else { return };
        let first = match self.first.compare_exchange(usize::MAX, place, Ordering::Relaxed, Ordering::Relaxed) {
            Ok(_) => place,
            Err(first) => first,
        };
        if place < first {
            return;
        }
        let weight = |stages: &[(Stage, f64)]| stages.iter().map(|planned| planned.1).sum::<f64>();
        let share = if share > 0.0 { share.min(1.0) } else { 0.0 };
        let done = weight(&self.plan[first..place]) + self.plan[place].1 * share;
        self.most.fetch_max((done / weight(&self.plan[first..])).to_bits(), Ordering::Relaxed);
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

    #[test]
    fn stages_before_the_first_that_is_told_of_count_for_nothing() {
        let plan = [(Stage::Read, 6.0), (Stage::Take, 1.0), (Stage::Place, 3.0)];
        let (with, without) = (Measure::new(&plan), Measure::new(&plan));
        with.tell(Stage::Read, 0.5);
        assert!((with.share() - 0.3).abs() < 1e-12 && with.stage() == "read");
        with.tell(Stage::Take, 1.0);
        without.tell(Stage::Take, 1.0);
        without.tell(Stage::Read, 1.0);
        assert!((with.share() - 0.7).abs() < 1e-12 && (without.share() - 0.25).abs() < 1e-12);
        assert_eq!(without.stage(), "take");
    }
}
