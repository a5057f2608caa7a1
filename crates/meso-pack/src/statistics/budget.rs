//! The size of samples where bodies have dents: a scan of thousands of triangles takes a second for figures that a polyhedron
//! has in a millisecond.
//!
//! Triangles are counted, not seconds, so that the figures are the same on every machine.

use super::StatisticsOptions;
use meso_collision::geometry::BodyForm;
use meso_concrete::aggregate::Aggregate;
use serde::{Deserialize, Serialize};

/// Triangles with dents of the bodies whose shapes are measured: some 5 s on one core.
const SHAPES: usize = 2_000_000;
/// Triangles with dents of the bodies that look for their nearest neighbour: some 20 s on one core.
const NEAREST: usize = 250_000;
/// Triangles with dents that all lines together may be compared with: some 10 s on one core.
const CROSSED: f64 = 5e8;
/// Fewest bodies and lines that are measured, where there are as many.
const LEAST: usize = 32;
const LEAST_LINES: f64 = 200.0;

/// How many of a packing's aggregates were measured, where these have many triangles. They are spread evenly over all sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Sampled {
    /// Aggregates of the packing.
    pub aggregates: usize,
    /// Aggregates whose shapes were measured.
    pub shapes: usize,
    /// Aggregates that looked for their nearest neighbour.
    pub nearest: usize,
    /// Random lines that were asked for; those that were looked at stand with the correlation functions.
    pub lines_asked: u32,
}

/// The work that is done for a packing.
pub(super) struct Budget {
    /// Every so many aggregates one is measured for its shape, and one looks for its neighbour.
    pub(super) shapes: usize,
    pub(super) nearest: usize,
    pub(super) lines: u32,
}

impl Budget {
    pub(super) fn of(aggregates: &[Aggregate], options: &StatisticsOptions) -> Self {
        let dents = aggregates.iter().map(|aggregate| &aggregate.body).filter(|body| body.form() == BodyForm::Surface);
        Self::of_triangles(dents.map(|body| body.triangles().count()).sum(), aggregates.len(), options)
    }

    fn of_triangles(triangles: usize, aggregates: usize, options: &StatisticsOptions) -> Self {
        let step = |most: usize| match options.whole {
            true => 1,
            false => triangles.div_ceil(most).clamp(1, (aggregates / LEAST).max(1)),
        };
        Self { shapes: step(SHAPES), nearest: step(NEAREST), lines: lines(triangles, aggregates, options) }
    }

    /// What is told of it, where not all was measured.
    pub(super) fn told(&self, aggregates: usize, options: &StatisticsOptions) -> Option<Sampled> {
        let is_whole = (self.shapes, self.nearest, self.lines) == (1, 1, options.lines);
        let [shapes, nearest] = [self.shapes, self.nearest].map(|step| aggregates.div_ceil(step));
        (!is_whole).then_some(Sampled { aggregates, shapes, nearest, lines_asked: options.lines })
    }
}

/// A line is compared with the triangles of as many bodies as lie along an edge of the specimen.
fn lines(triangles: usize, aggregates: usize, options: &StatisticsOptions) -> u32 {
    let each = triangles as f64 / libm::cbrt(aggregates as f64).powi(2);
    let most = (CROSSED / each).max(LEAST_LINES);
    if options.whole || f64::from(options.lines) <= most { options.lines } else { most as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_of_a_packing_without_dents_is_measured_and_a_sample_of_scanned_stones() {
        let options = StatisticsOptions::default();
        assert_eq!(Budget::of_triangles(0, 100_000, &options).told(100_000, &options), None);
        assert_eq!(Budget::of_triangles(200_000, 400, &options).told(400, &options), None);
        let of_scans = Budget::of_triangles(1_131 * 4_224, 1_131, &options);
        let told = Sampled { aggregates: 1_131, shapes: 377, nearest: 57, lines_asked: 10_000 };
        assert_eq!((of_scans.told(1_131, &options), of_scans.lines), (Some(told), 10_000));
        let whole = StatisticsOptions { whole: true, ..options };
        assert_eq!(Budget::of_triangles(1_131 * 4_224, 1_131, &whole).told(1_131, &whole), None);
    }

    #[test]
    fn a_few_stones_of_any_number_of_triangles_are_measured() {
        let options = StatisticsOptions::default();
        let few = Budget::of_triangles(40 * 20_000, 40, &options);
        let told = Sampled { aggregates: 40, shapes: 40, nearest: 40, lines_asked: 10_000 };
        assert_eq!((few.told(40, &options), few.lines), (Some(told), 7_310));
        let many = Budget::of_triangles(100_000 * 20_000, 100_000, &options);
        assert_eq!((many.told(100_000, &options).unwrap().nearest, many.lines), (32, 538));
    }
}
