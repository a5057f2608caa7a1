//! Values of the specimen's own phases, which have tables of their names beside the keys that every concrete has.

use super::{Elastic, MATERIALS, Materials};
use meso_concrete::{OutOfRange, Phase, PhaseNames, own_tables};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

impl Materials {
    /// Finds out whether these values are of the `phases` of a specimen, all of its own and no other.
    ///
    /// # Errors
    /// The first phase without values, and the first values without a phase.
    pub fn suits(&self, phases: &PhaseNames) -> Result<(), OutOfRange> {
        phases.suit(
            &self.own,
            MATERIALS,
            "{ youngs_modulus_mpa = 60000, poisson_ratio = 0.2, density_t_per_mm3 = 2.7e-9 }",
        )
    }

    /// The elastic values of a phase of the specimen's own; those of aggregates where it has none, for figures that need none.
    pub(super) fn own(&self, phase: Phase, phases: &PhaseNames) -> &Elastic {
        self.own.get(phases.name(phase)).unwrap_or(&self.aggregate)
    }
}

impl Serialize for Materials {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        struct Common<'a>(&'a Materials);
        impl Serialize for Common<'_> {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                Materials::serialize(self.0, serializer)
            }
        }
        #[derive(Serialize)]
        struct All<'a> {
            #[serde(flatten)]
            common: Common<'a>,
            #[serde(flatten)]
            own: &'a BTreeMap<String, Elastic>,
        }
        if self.own.is_empty() {
            return Self::serialize(self, serializer);
        }
        All { common: Common(self), own: &self.own }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Materials {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        own_tables::read(deserializer, |common| Self::deserialize(common)).map(|(common, own)| Self { own, ..common })
    }
}
