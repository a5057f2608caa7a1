//! Room for the requested fraction. Gaps, walls and coatings of stones make a packing denser than its fraction says.
//!
//! Bodies that keep a gap g from each other stay apart when each is grown by g / 2. So a packing with gaps is as
//! dense as one without, in which the grown bodies lie in the space between the walls.

use super::{Checked, mean_volume};
use crate::messages::number;
use crate::{Spec, SpecError};
use meso_concrete::aggregate::Grain;
use meso_concrete::aggregate::{Fibres, SizeClass, Voids};
use meso_concrete::specimen::Largest;
use meso_place::Strategy;

impl Spec {
    /// Volume of all bodies grown by half of the gap, over the volume that the walls leave, roughly; without gaps
    /// their fraction, coatings and the ITZ around them included.
    ///
    /// An underestimate: a body grows by at least as much as a ball of its volume (Brunn and Minkowski), and a
    /// container shrinks by at least as much as a box of its lengths.
    pub fn crowding(&self) -> f64 {
        let gap = self.placement.min_gap_mm;
        let voids = self.voids.as_ref().map_or(0.0, |voids| voids.fraction * void_growth(voids, gap));
        let fibres = self.fibres.map_or(0.0, |fibres| fibres.fraction * fibre_growth(&fibres, gap));
        (self.grown_aggregates(gap) + voids + fibres) / self.room_left()
    }

    /// The fraction that the chosen strategy was measured to reach in a specimen of this size, roughly: walls keep a
    /// rim of a quarter of the smallest body empty.
    ///
    /// By rearrangement (the paper's grading, seed 1) cubes of 60 and 75 mm reached 0.67 and 0.68; this predicts 0.65
    /// and 0.67. Where 0.72 was asked, those of 25, 40 and 60 mm ended at 0.52, 0.60 and 0.64, predicted 0.54, 0.61
    /// and 0.65. A periodic one of 75 mm reached 0.74, as predicted.
    pub fn reach(&self) -> f64 {
        let full = |spec: &Self| {
            let rim = spec.smallest_body_mm() / 4.0;
            spec.specimen.container().share_within(rim).unwrap_or_else(|| spec.share_within(rim))
        };
        self.placement.reach() * full(self) / full(&Self::default())
    }

    /// Warnings before the work starts: that so dense a packing was never seen, that a class is too small
    /// for a single aggregate, that an option counts for nothing.
    pub fn doubts(&self) -> Vec<String> {
        self.beyond_reach().into_iter().chain(self.empty_class()).chain(self.unused_attempts()).collect()
    }

    fn unused_attempts(&self) -> Option<String> {
        let unused = self.placement.attempts.is_some() && self.placement.chosen() == Strategy::Rearrange;
        unused.then(|| "attempts count for the strategy take-and-place alone; rearrange makes none".to_owned())
    }

    /// The first class whose target is less than half of its smallest aggregate, and so gets none.
    fn empty_class(&self) -> Option<String> {
        let per_cube = mean_volume(&self.shape) / (self.fraction * self.specimen.volume());
        let classes = self.grading.classes();
        let class = classes.iter().find(|class| class.share < 0.5 * per_cube * class.d_min_mm.powi(3))?;
        Some(format!(
            "the class {}-{} mm asks for less than one aggregate and stays empty: take a larger specimen, a higher fraction or \
             wider classes",
            number(class.d_min_mm),
            number(class.d_max_mm)
        ))
    }

    fn beyond_reach(&self) -> Option<String> {
        let (crowding, reach) = (self.crowding(), self.reach());
        // A target without space is an error instead.
        if crowding <= reach || crowding >= 1.0 {
            return None;
        }
        let asked = self.fraction + self.inclusions().fractions().iter().sum::<f64>();
        let way_out = match (self.placement.chosen(), self.shape.has_coatings()) {
            (Strategy::TakeAndPlace, _) => "give more attempts, or take the strategy rearrange",
            (_, true) => "take a lower fraction, thinner outward shape.shells or a wider grading",
            (_, false) => "take a lower fraction or a wider grading",
        };
        let asked = if crowding > asked + 1e-3 {
            format!("{} with its {} is as dense as {crowding:.2} without; that is", number(asked), self.growth())
        } else {
            format!("{} is", number(asked))
        };
        Some(format!(
            "{asked} more than this strategy reached in tests, {reach:.2} in a specimen of this size; the packing may fall \
             short: {way_out}"
        ))
    }

    /// Names the gap that leaves no space for the target. Not part of [`Spec::validate`]: the fraction of a spec may
    /// be replaced until the packing begins, and a saved model may have fallen short.
    pub fn has_room(&self) -> Checked {
        let crowding = self.crowding();
        if crowding < 1.0 {
            return Ok(());
        }
        let placement = &self.placement;
        let coated = self.grown_aggregates(0.0) + self.inclusions().fractions().iter().sum::<f64>();
        if self.shape.has_coatings() && coated >= 1.0 {
            let message = format!(
                "is {}, which leaves no room for the coatings: with them and the ITZ around them the bodies would take \
                 {coated:.2} of the specimen; take thinner outward shape.shells or a lower fraction",
                number(self.fraction)
            );
            return Err(SpecError::value("fraction", message));
        }
        let (key, gap) = if placement.wall_gap_mm > placement.min_gap_mm {
            ("placement.wall_gap_mm", placement.wall_gap_mm)
        } else {
            ("placement.min_gap_mm", placement.min_gap_mm)
        };
        let message = format!(
            "is {}, which leaves no room for a fraction of {}: the bodies with their {} would take {crowding:.2} of what the \
             walls leave them; lower the gap{} or the fraction",
            number(gap),
            number(self.fraction),
            self.growth(),
            if self.shape.has_coatings() { ", the coatings" } else { "" }
        );
        Err(SpecError::value(key, message))
    }

    /// Names the first class of which every aggregate taken is too large for the specimen, its walls' gap kept.
    pub fn fits_nowhere(&self, grains: &[Grain], largest: &Largest) -> Option<SpecError> {
        let classes = self.grading.classes();
        let (_, class) = classes.iter().enumerate().find(|(index, _)| {
            let mut own = grains.iter().filter(|grain| usize::from(grain.class) == *index).peekable();
            own.peek().is_some() && own.all(|grain| !largest.admits(grain))
        })?;
        let message = format!(
            "has {}-{} mm, of which no aggregate fits into the specimen: nothing in it is thicker than {}, longer than {} or of more \
             volume than {} mm3; take smaller aggregates{} or a larger specimen",
            number(class.d_min_mm),
            number(class.d_max_mm),
            number(rounded(2.0 * largest.ball_radius)),
            number(rounded(largest.length)),
            number(rounded(largest.volume)),
            if self.shape.has_coatings() { ", thinner coatings" } else { "" }
        );
        Some(SpecError::value("grading.classes_mm", message))
    }

    /// Fraction of the aggregates with their coatings, grown by half of `gap`.
    fn grown_aggregates(&self, gap: f64) -> f64 {
        let (law, ball) = (self.grading.size_law, self.ball_over_size());
        let grown = |class: &SizeClass| -> f64 {
            let [low, high] = [class.d_min_mm, class.d_max_mm];
            let more = |[least, most]: [f64; 2]| (least + most + gap) / ball;
            let ends = self.coatings(class, low).zip(self.coatings(class, high));
            let of_phase = |((share, thin), (_, thick))| share * law.mean_cube(low + more(thin), high + more(thick));
            ends.map(of_phase).sum::<f64>() / law.mean_cube(low, high)
        };
        self.grading.classes().iter().map(|class| self.fraction * class.share * grown(class)).sum()
    }

    /// What makes a packing denser than its fraction.
    fn growth(&self) -> &'static str {
        let gap = self.placement.min_gap_mm.max(self.placement.wall_gap_mm);
        match (self.shape.has_coatings(), gap > 0.0) {
            (true, true) => "coatings and gaps",
            (true, false) => "coatings",
            (false, _) => "gaps",
        }
    }

    /// Share of the specimen that grown bodies may take: they end half a gap nearer to the walls than the bodies do.
    fn room_left(&self) -> f64 {
        self.share_within(self.placement.wall_gap_mm - self.placement.min_gap_mm / 2.0)
    }

    /// Share of the specimen more than `rim` mm inside its walls, as if it were a box.
    fn share_within(&self, rim: f64) -> f64 {
        let (period, size) = (self.specimen.period(), self.specimen.aabb().size());
        let walled = (0..3).filter(|&axis| period.along(axis).is_none());
        walled.map(|axis| (size[axis] - 2.0 * rim) / size[axis]).product()
    }
}

/// To hundredths, upwards: an upper bound stays one.
fn rounded(bound: f64) -> f64 {
    (bound * 100.0).ceil() / 100.0
}

fn void_growth(voids: &Voids, gap: f64) -> f64 {
    let law = voids.size_law();
    let grown = |&SizeClass { d_min_mm: low, d_max_mm: high, share }: &SizeClass| {
        share * law.mean_cube(low + gap, high + gap) / law.mean_cube(low, high)
    };
    voids.classes().iter().map(grown).sum()
}

fn fibre_growth(fibres: &Fibres, gap: f64) -> f64 {
    let across = 1.0 + gap / fibres.diameter_mm;
    across * across * (1.0 + gap / fibres.length_mm)
}
