//! Statistics of a packing: grading, shape, orientation, walls, gaps and correlation functions.
//!
//! None of it is computed unless it is asked for. Samples are drawn from portable streams in fixed batches and summed
//! in batch order: the figures are the same on any number of threads.

mod budget;
mod correlation;
mod distribution;
mod index;
mod nearest;
mod phases;
mod shape;
mod wall;

pub use budget::Sampled;
pub use correlation::Correlation;
pub use distribution::Distribution;
pub use phases::PhaseFigures;
pub use shape::{Orientation, Shapes, Zingg};
pub use wall::WallEffect;

use crate::model::Model;
use budget::Budget;
use index::Index;
use meso_collision::gjk::GjkError;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::images::near as images_near;
use meso_concrete::parallel;
use meso_concrete::specimen::Container;
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_place::ClassReport;
use meso_spec::SpecError;
use serde::{Deserialize, Serialize};

/// How much is sampled, and how finely it is resolved.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct StatisticsOptions {
    /// Seed of the samples.
    pub seed: u64,
    /// Random lines for the correlation functions.
    pub lines: u32,
    /// Step between two lags of the correlation functions, mm.
    pub lag_mm: f64,
    /// Number of lags, from 0; those that no line of the specimen has are left out, as are those beyond 10,000.
    pub lags: u32,
    /// Random points for the wall effect.
    pub points: u32,
    /// Width of a layer of the wall effect, mm; at least a thousandth of the specimen.
    pub layer_mm: f64,
    /// Whether all aggregates with dents are measured, and all lines looked at, however many triangles these have.
    pub whole: bool,
}

impl Default for StatisticsOptions {
    fn default() -> Self {
        Self { seed: 1, lines: 10_000, lag_mm: 0.5, lags: 81, points: 200_000, layer_mm: 1.0, whole: false }
    }
}

impl StatisticsOptions {
    /// A fifth of the samples, for a page that is written beside other files: curves scatter twice as much.
    pub fn quick() -> Self {
        Self { lines: 2_000, points: 40_000, ..Self::default() }
    }

    /// Names the first invalid value.
    ///
    /// # Errors
    /// A step or layer that is not a positive length; more lags than a curve needs.
    pub fn validate(&self) -> Result<(), SpecError> {
        for (key, value) in [("lag_mm", self.lag_mm), ("layer_mm", self.layer_mm)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(SpecError::value(key, format!("is {value}; it must be a positive length")));
            }
        }
        if self.lags > MAX_LAGS {
            return Err(SpecError::value("lags", format!("is {}; it must be at most {MAX_LAGS}", self.lags)));
        }
        Ok(())
    }
}

/// Most lags of a correlation function: every line stores one figure for each.
const MAX_LAGS: u32 = 10_000;

/// The figures of one packing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Volume of the aggregates over the specimen's.
    pub fraction: f64,
    /// Surface of the aggregates over the specimen's volume, 1/mm.
    pub specific_surface_per_mm: f64,
    /// Asked and reached volume, and number, by size class.
    pub classes: Vec<ClassReport>,
    /// Shapes of the aggregates.
    pub shapes: Shapes,
    /// Directions of the longest axes.
    pub orientation: Orientation,
    /// Fraction against depth.
    pub wall_effect: WallEffect,
    /// Distance from each aggregate to the nearest other one, mm; absent for fewer than two. In a periodic specimen
    /// images count as others, an aggregate's own among them.
    pub nearest_distance_mm: Option<Distribution>,
    /// Two-point correlation and lineal path.
    pub correlation: Correlation,
    /// Voids and fibres, where there are some; all other figures are of the aggregates alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub phases: Vec<PhaseFigures>,
    /// How many aggregates were measured; absent where it is all of them, as without dents of many triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sampled: Option<Sampled>,
}

impl Statistics {
    /// Measures a packed model.
    ///
    /// # Errors
    /// A loaded model may hold coordinates beyond the range of the exact distance.
    pub fn of(model: &Model, options: &StatisticsOptions) -> Result<Self, GjkError> {
        Self::watched(model, options, &Silent)
    }

    /// Measures like [`Statistics::of`], and reports to `watch` as [`Stage::Measure`].
    ///
    /// # Errors
    /// Fails like [`Statistics::of`].
    pub fn watched(model: &Model, options: &StatisticsOptions, watch: &dyn Watch) -> Result<Self, GjkError> {
        watch.stage(Stage::Measure, 0.02);
        let (container, aggregates) = (model.spec.specimen.container(), model.aggregates.as_slice());
        // Images that a point or a line in the specimen meets, and most of those that are nearest to an aggregate.
        let images = WithImages::near(model, 2.0 * model.spec.grading.d_max_mm);
        let budget = Budget::of(aggregates, options);
        let sampled = budget.told(aggregates.len(), options);
        let options = &StatisticsOptions { lines: budget.lines, ..*options };
        let sample = Sample { container: &*container, aggregates: &images.aggregates, index: &images.index, options };
        let (shapes, orientation) = (Shapes::of(aggregates, budget.shapes), Orientation::of(aggregates));
        watch.stage(Stage::Measure, 0.2);
        let wall_effect = wall::wall_effect(&sample);
        watch.stage(Stage::Measure, 0.35);
        let nearest_distance_mm = nearest::nearest_distances(model, &images, budget.nearest)?;
        watch.stage(Stage::Measure, 0.7);
        let correlation = correlation::correlation(&sample);
        watch.stage(Stage::Measure, 1.0);
        Ok(Statistics {
            fraction: ordered_sum(aggregates, |a| a.body.volume()) / container.volume(),
            specific_surface_per_mm: ordered_sum(aggregates, |a| a.body.area()) / container.volume(),
            classes: model.report.classes.clone(),
            shapes,
            orientation,
            wall_effect,
            nearest_distance_mm,
            correlation,
            phases: PhaseFigures::all(&model.inclusions, container.volume()),
            sampled,
        })
    }
}

/// The aggregates, then, where the specimen repeats itself, their images that come within `margin` mm of it.
struct WithImages {
    aggregates: Vec<Aggregate>,
    index: Index,
    margin: f64,
}

impl WithImages {
    fn near(model: &Model, margin: f64) -> Self {
        let aggregates = images_near(&model.aggregates, &model.spec.specimen, margin);
        let index = Index::new(&aggregates, &model.spec.specimen.aabb());
        Self { aggregates, index, margin }
    }
}

/// Data that sampling needs.
#[derive(Clone, Copy)]
struct Sample<'a> {
    container: &'a dyn Container,
    aggregates: &'a [Aggregate],
    index: &'a Index,
    options: &'a StatisticsOptions,
}

/// The sum in list order of figures computed in parallel.
fn ordered_sum(aggregates: &[Aggregate], figure: impl Fn(&Aggregate) -> f64 + Sync + Send) -> f64 {
    parallel::map_each(aggregates, figure).iter().sum()
}

/// Joins the figures of numbered batches in their order; only a bounded number is held at a time.
fn in_order<T: Send>(batches: u32, figures: impl Fn(u32) -> T + Sync + Send, mut join: impl FnMut(T)) {
    const HELD: u32 = 512;
    for first in (0..batches).step_by(HELD as usize) {
        let last = batches.min(first.saturating_add(HELD));
        let held = parallel::map((last - first) as usize, |k| figures(first + k as u32));
        held.into_iter().for_each(&mut join);
    }
}
