//! Values of the specimen's own phases, which have tables of their names beside the keys that every concrete has.

use super::{Elastic, MATERIALS, Materials};
use meso_concrete::{OutOfRange, Phase, PhaseNames, own_tables};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// Values of a phase of the packing's own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct OwnMaterial {
    /// Young's modulus, MPa.
    pub youngs_modulus_mpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Density, tonne/mm3.
    pub density_t_per_mm3: f64,
    /// Strengths and energies over those of the mortar; absent, the phase stays elastic.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub strength_ratio: Option<f64>,
}

impl OwnMaterial {
    /// Its stiffness and density.
    pub fn elastic(&self) -> Elastic {
        let &Self { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3, .. } = self;
        Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 }
    }
}

impl From<Elastic> for OwnMaterial {
    /// A phase that stays elastic.
    fn from(Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 }: Elastic) -> Self {
        Self { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3, strength_ratio: None }
    }
}

/// The schema of a phase's values.
#[cfg(feature = "schema")]
pub(super) fn schema() -> schemars::Schema {
    let mut schema = schemars::schema_for!(OwnMaterial);
    schema.remove("$schema");
    schema
}

impl Materials {
    /// Names of the phases that have values here.
    pub fn own_phases(&self) -> PhaseNames {
        self.own.keys().cloned().collect()
    }

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
    pub(super) fn own(&self, phase: Phase, phases: &PhaseNames) -> Elastic {
        self.own.get(phases.name(phase)).map_or(self.aggregate, OwnMaterial::elastic)
    }

    /// The elastic values of all phases by their names, with the share of the mortar's strengths that each has; `None` of those
    /// that stay elastic.
    pub fn by_name(&self) -> impl Iterator<Item = (&str, Elastic, Option<f64>)> {
        let common = [
            ("aggregate", self.aggregate, None),
            ("itz", self.itz, Some(self.itz_strength_ratio)),
            ("mortar", self.mortar, Some(1.0)),
            ("fibre", self.fibre, None),
        ];
        common.into_iter().chain(self.own.iter().map(|(name, own)| (name.as_str(), own.elastic(), own.strength_ratio)))
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
        struct EveryPhase<'a> {
            #[serde(flatten)]
            common: Common<'a>,
            #[serde(flatten)]
            own: &'a BTreeMap<String, OwnMaterial>,
        }
        if self.own.is_empty() {
            return Self::serialize(self, serializer);
        }
        EveryPhase { common: Common(self), own: &self.own }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Materials {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        own_tables::read(deserializer, |common| Self::deserialize(common)).map(|(common, own)| Self { own, ..common })
    }
}
