//! Growth of the bodies that are placed by outward shells, and the ITZ around them, beyond their stones.

use crate::Spec;
use meso_concrete::aggregate::take::ITZ_LIMIT;
use meso_concrete::aggregate::{OwnPhase, SizeClass, SizeDefinition};
use std::f64::consts::PI;

impl Spec {
    /// Diameter of the ball of a stone's volume over the stone's size. A sieve size is only known in order: that of the ball.
    pub(super) fn ball_over_size(&self) -> f64 {
        match self.grading.size {
            SizeDefinition::LongestAxis => libm::cbrt(super::mean_volume(&self.shape) * 6.0 / PI),
            SizeDefinition::Sieve => 1.0,
        }
    }

    /// Shares of the stones of `size` mm in a class, each with the least and the largest thickness of all that lies around it, mm.
    /// These are 0 where no shell is outward.
    pub(super) fn coatings(&self, class: &SizeClass, size: f64) -> impl Iterator<Item = (f64, [f64; 2])> {
        // No stone holds a larger ball than that of its volume.
        let itz = self.itz.thickness_mm.map(|mm| mm.min(ITZ_LIMIT * self.ball_over_size() * size / 2.0));
        let sum = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let shares =
            OwnPhase::shares(&self.phases, class).into_iter().zip((0..self.phases.len() as u8).map(Some).chain([None]));
        shares.filter(|(share, _)| *share > 0.0).map(move |(share, own)| {
            let outward = self.shells_of(own).into_iter().filter(|(_, law)| law.outward);
            let shells = outward.filter_map(|(_, law)| law.limits_mm(size)).reduce(sum);
            (share, shells.map_or([0.0; 2], |shells| sum(shells, itz)))
        })
    }

    /// Least size of the bodies of the smallest stones, mm.
    pub(super) fn smallest_body_mm(&self) -> f64 {
        self.least_body_mm(self.grading.classes().first(), self.grading.d_min_mm)
    }

    /// Least size of the bodies of the largest stones, mm: these with the thinnest coatings that they may have.
    pub fn largest_body_mm(&self) -> f64 {
        self.least_body_mm(self.grading.classes().last(), self.grading.d_max_mm)
    }

    fn least_body_mm(&self, class: Option<&SizeClass>, size: f64) -> f64 {
        let thinnest = |class| self.coatings(class, size).map(|(_, [least, _])| least).reduce(f64::min);
        // Shares that cannot be are named elsewhere.
        size + 2.0 * class.and_then(thinnest).unwrap_or(0.0)
    }
}
