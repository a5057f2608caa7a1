//! Values over those of a spec.

use crate::flags::of_schema::Flag;
use crate::given::{Given, Options};
use crate::{AskError, Giver};
use meso_core::packing::Strategy;
use meso_core::{Spec, SpecError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Values that take the place of a spec's own, where a packing is made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Over {
    /// Seed of all randomness; the same seed gives the same bytes
    pub seed: Option<u64>,
    /// Volume of the aggregates over the specimen's, 0 to 1
    pub fraction: Option<f64>,
    /// Strategy of placement
    pub strategy: Option<Strategy>,
    /// Random positions tried per aggregate
    #[schemars(range(min = 1))]
    pub attempts: Option<u32>,
    /// Smallest distance between two aggregates; 0 only proves them apart [default: the spec's, or as much as the mesh needs:
    /// 0.05 with the method conforming, half an element in a test, or less where the packing would get too dense]
    pub min_gap_mm: Option<f64>,
    /// Smallest distance between an aggregate and the specimen's surface. Periodic packings are shifted until no aggregate
    /// touches a face
    pub wall_gap_mm: Option<f64>,
    /// End the packing after S seconds with the best found. If generation used up the time, placement gets one more second
    pub time_limit_s: Option<f64>,
}

impl Options for Over {
    const FLAGS: &'static [Flag] = &[
        Flag::common("seed", "N"),
        Flag::common("fraction", "F"),
        Flag::common("strategy", ""),
        Flag::rare("attempts", "N"),
        Flag::common("min_gap_mm", "MM"),
        Flag::rare("wall_gap_mm", "MM"),
        Flag::common("time_limit_s", "S"),
    ];
}

impl Over {
    /// Refuses values that no spec can have, before one is read under them; `giver` gave them.
    ///
    /// # Errors
    /// The option, its value and the accepted range.
    pub fn accept(&self, giver: Giver<'_>) -> Result<(), AskError> {
        let mut alone = Spec::default();
        self.lay(&mut alone);
        let wrong = |error: SpecError| format!("{} {}", giver.option(key_of(&error)), error.message);
        alone.validate_over().map_err(|error| AskError::Usage(wrong(error)))
    }

    /// Lays the values over those of `spec`.
    pub fn lay(&self, spec: &mut Spec) {
        spec.seed = self.seed.unwrap_or(spec.seed);
        spec.fraction = self.fraction.unwrap_or(spec.fraction);
        let placement = &mut spec.placement;
        placement.strategy = self.strategy.unwrap_or(placement.strategy);
        placement.attempts = self.attempts.or(placement.attempts);
        placement.min_gap_mm = self.min_gap_mm.unwrap_or(placement.min_gap_mm);
        placement.wall_gap_mm = self.wall_gap_mm.unwrap_or(placement.wall_gap_mm);
        placement.time_limit_s = self.time_limit_s.or(placement.time_limit_s);
    }
}

/// The key here of a spec's value.
fn key_of(error: &SpecError) -> &str {
    error.key.strip_prefix("placement.").unwrap_or(&error.key)
}

impl Given<Over> {
    /// Lays the values over those of `spec`, and lets `leave_room` set the gaps that its mesh needs.
    ///
    /// # Errors
    /// A spec that cannot be, and those of `leave_room`.
    pub fn settle<T>(
        &self,
        spec: &mut Spec,
        leave_room: impl FnOnce(&mut Spec) -> Result<T, AskError>,
    ) -> Result<T, AskError> {
        let valid = |spec: &Spec| spec.validate().map_err(|error| AskError::Usage(self.spec_error(&error)));
        self.options.lay(spec);
        valid(spec)?;
        let left = leave_room(spec)?;
        valid(spec).map(|()| left)
    }

    /// An error of a spec, in the giver's spelling where its value was laid over the spec's own.
    pub fn spec_error(&self, error: &SpecError) -> String {
        let key = key_of(error);
        if self.has(key) { format!("{} {}", self.giver().option(key), error.message) } else { error.to_string() }
    }
}
