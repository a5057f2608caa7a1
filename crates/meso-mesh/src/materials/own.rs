//! Values of the specimen's own phases, which have tables of their names beside the keys that every concrete has.

use super::{Elastic, MATERIALS, Materials};
use meso_concrete::{OutOfRange, Phase, PhaseNames, own_tables};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;

/// Material of a phase of the specimen's own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "Flat", into = "Flat")]
pub struct OwnMaterial {
    /// Stiffness and density.
    pub elastic: Elastic,
    /// Strengths and energies over those of the mortar; absent, the phase stays elastic.
    pub strength_ratio: Option<f64>,
}

/// [`OwnMaterial`] as files have it.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct Flat {
    /// Young's modulus, MPa.
    youngs_modulus_mpa: f64,
    /// Poisson's ratio.
    poisson_ratio: f64,
    /// Density, tonne/mm3.
    density_t_per_mm3: f64,
    /// Strengths and energies over those of the mortar; absent, the phase stays elastic.
    #[serde(skip_serializing_if = "Option::is_none")]
    strength_ratio: Option<f64>,
}

impl From<Elastic> for OwnMaterial {
    /// A phase that stays elastic.
    fn from(elastic: Elastic) -> Self {
        Self { elastic, strength_ratio: None }
    }
}

impl From<Flat> for OwnMaterial {
    fn from(flat: Flat) -> Self {
        let Flat { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3, strength_ratio } = flat;
        Self { elastic: Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 }, strength_ratio }
    }
}

impl From<OwnMaterial> for Flat {
    fn from(OwnMaterial { elastic, strength_ratio }: OwnMaterial) -> Self {
        let Elastic { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3 } = elastic;
        Self { youngs_modulus_mpa, poisson_ratio, density_t_per_mm3, strength_ratio }
    }
}

/// The schema of a phase's values.
#[cfg(feature = "schema")]
pub(super) fn schema() -> schemars::Schema {
    let mut schema = schemars::schema_for!(Flat);
    schema.remove("$schema");
    schema.insert("title".to_owned(), "OwnMaterial".into());
    schema.insert("description".to_owned(), "Values of a phase of the packing's own.".into());
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
    pub(super) fn own(&self, phase: Phase, phases: &PhaseNames) -> &Elastic {
        self.own.get(phases.name(phase)).map_or(&self.aggregate, |own| &own.elastic)
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
            own: &'a BTreeMap<String, OwnMaterial>,
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
