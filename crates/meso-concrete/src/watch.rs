//! Progress of long work in named stages, and its stop by the user.
//!
//! Packing, meshing and a test get one [`Watch`] each. Work that keeps a result asks [`Watch::stops`]; see [`stop`](crate::stop)
//! for work without a result worth keeping.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};

/// A part of long work, by the name that users see.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reading a specimen's surface and proving that it encloses a volume.
    Read,
    /// Generating the grains.
    Take,
    /// Placing them.
    Place,
    /// Placing them, where nothing has moved forward for some seconds.
    Jam,
    /// Proving them apart.
    Prove,
    /// Meshing, or measuring a mesh.
    Mesh,
    /// Testing a mesh.
    Solve,
    /// Measuring a packing.
    Measure,
    /// Making images.
    Image,
    /// Writing files.
    Write,
}

impl Stage {
    /// Name of the stage, as users see it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Take => "take",
            Self::Place => "place",
            Self::Jam => "jammed",
            Self::Prove => "prove",
            Self::Mesh => "mesh",
            Self::Solve => "solve",
            Self::Measure => "statistics",
            Self::Image => "image",
            Self::Write => "write",
        }
    }
}

/// Watches long work: it receives the stages, and says when to stop. Every method has a default that does nothing.
pub trait Watch: Sync {
    /// Receives the share of a stage that is done, 0 to 1. A stage may begin again, after a jam; a display keeps the most.
    fn stage(&self, stage: Stage, share: f64) {
        let _ = (stage, share);
    }
    /// Receives the fraction that a spec asks for, as soon as it is read.
    fn target(&self, fraction: f64) {
        let _ = fraction;
    }
    /// Whether to stop. Packing then ends with the best packing found, a test with its curve so far, a mesh with an error.
    fn stops(&self) -> bool {
        false
    }
    /// A flag that is true once nobody waits for the result any more. Work on a thread that [listens](crate::stop::listen)
    /// then unwinds.
    fn abandoned(&self) -> Option<Arc<AtomicBool>> {
        None
    }
    /// Seconds since some fixed moment: the core itself reads no clock.
    fn seconds(&self) -> f64 {
        0.0
    }
    /// The moment when the time limit began to count, in [`seconds`](Watch::seconds). It is earlier than now where reading
    /// a large surface counts, too.
    fn began(&self) -> f64 {
        self.seconds()
    }
}

/// Watches nothing: no display, no clock, no stop.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Watch for Silent {}

/// The watch over a proof, and the moment at which the proof is given up.
#[derive(Clone, Copy)]
pub struct Waiting<'a> {
    /// Receives the share of the stage [`Stage::Read`] that is done.
    pub watch: &'a dyn Watch,
    /// Latest moment, in `watch.seconds()`.
    pub deadline: f64,
}

impl Waiting<'_> {
    /// Reports the share of reading that is done; true once the time is over.
    pub(crate) fn is_over_at(&self, share: f64) -> bool {
        self.watch.stage(Stage::Read, share);
        self.watch.seconds() >= self.deadline
    }
}

/// One measure of several stages, 0 to 1: it never falls, whatever order and threads the shares come in. Stages before
/// the first reported one do not count: few specimens have a surface to read.
#[derive(Debug)]
pub struct Measure {
    /// The stages in their order, with the share of the time that each takes, roughly.
    plan: Vec<(Stage, f64)>,
    /// Bits of the largest measure: those of positive numbers are in the numbers' order.
    most: AtomicU64,
    /// Index of the first reported stage; [`usize::MAX`] before any report.
    first: AtomicUsize,
    /// Index of the latest reported stage.
    latest: AtomicUsize,
    /// Whether placement has jammed.
    jammed: AtomicBool,
}

impl Measure {
    /// A measure of these stages, in their order, with their weights.
    pub fn new(plan: &[(Stage, f64)]) -> Self {
        let [first, latest] = [usize::MAX, 0].map(AtomicUsize::new);
        Self { plan: plan.to_vec(), most: AtomicU64::new(0), first, latest, jammed: AtomicBool::new(false) }
    }

    /// Receives the share of a stage. Ignores a stage that is not in the plan; NaN counts as 0. A jam has no share: it
    /// renames the stage [`Stage::Place`].
    pub fn tell(&self, stage: Stage, share: f64) {
        if stage == Stage::Jam {
            self.jammed.store(true, Ordering::Relaxed);
        }
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
        let latest = self.plan.get(self.latest.load(Ordering::Relaxed)).map(|planned| planned.0);
        let is_jammed = latest == Some(Stage::Place) && self.jammed.load(Ordering::Relaxed);
        latest.map_or("", |stage| if is_jammed { Stage::Jam } else { stage }.name())
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
    fn a_jam_renames_the_placement_alone() {
        let measure = Measure::new(&[(Stage::Take, 1.0), (Stage::Place, 3.0), (Stage::Prove, 1.0)]);
        let mut named = |stage| {
            measure.tell(stage, 0.5);
            measure.stage()
        };
        let stages = [Stage::Take, Stage::Place, Stage::Jam, Stage::Place, Stage::Prove];
        assert_eq!(stages.map(&mut named), ["take", "place", "jammed", "jammed", "prove"]);
    }

    #[test]
    fn stages_before_the_first_reported_one_count_for_nothing() {
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
